#include "io/slice_dxf.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "geometry/error.h"
#include "io/flat_curve.h"
#include "io/number_text.h"
#include "io/text_file.h"

namespace afptraj {
namespace {

constexpr std::size_t most_bytes = std::size_t{256} << 20;
constexpr double join_mm = 1e-4;

// A group: a code and its value.
struct Group {
  int code = 0;
  std::string value;
  int line = 0;
};

struct Curve {
  std::vector<Vec2> points;  // mm
  bool closed = false;
  int line = 0;
};

std::string trimmed(const std::string& text) {
  const std::size_t from = text.find_first_not_of(" \t\r"), to = text.find_last_not_of(" \t\r");
  return from == std::string::npos ? "" : text.substr(from, to - from + 1);
}

class Reader {
 public:
  Reader(const std::string& path, double tolerance) : path_(path), tolerance_(tolerance) {
    const std::string text = read_text_file(path, most_bytes);
    std::size_t at = 0;
    int line = 0;
    const auto next = [&](std::string& out) {
      if (at >= text.size()) return false;
      const std::size_t end = std::min(text.find('\n', at), text.size());
      out = trimmed(text.substr(at, end - at));
      at = end + 1;
      ++line;
      return true;
    };
    std::string code, value;
    while (next(code)) {
      if (code.empty() && at >= text.size()) break;
      const auto number = parse_number(code);
      if (!number || *number != std::floor(*number) || std::abs(*number) > 1e5)
        bad(line, "'" + printable(code) + "' is no group code; give an ASCII DXF file");
      if (!next(value)) bad(line, "the file ends within a group; save it again as ASCII DXF");
      groups_.push_back({static_cast<int>(*number), value, line});
    }
  }

  SliceFile read() {
    units();
    std::size_t i = find("ENTITIES");
    while (i < groups_.size() && !(groups_[i].code == 0 && groups_[i].value == "ENDSEC")) {
      std::size_t end = i + 1;
      while (end < groups_.size() && groups_[end].code != 0) ++end;
      i = entity(i, end);
    }
    join();
    for (const auto& [name, count] : left_out_)
      warnings_.push_back(std::to_string(count) + " " + name + " left out: a slice is made of closed curves");
    return {Slice(path_, rings_), z_.value_or(0), warnings_};
  }

 private:
  [[noreturn]] void bad(int line, const std::string& message) const {
    throw Error(ErrorCode::bad_input, line > 0 ? file_line(path_, line) : path_, message);
  }

  double number(const Group& group) const {
    const auto value = parse_number(group.value);
    if (!value)
      bad(group.line, "group " + std::to_string(group.code) + ": '" + printable(group.value) +
                          "' is not a finite number; save the drawing again");
    return *value;
  }

  // Where a section's content begins.
  std::size_t find(const std::string& section) const {
    for (std::size_t i = 0; i + 1 < groups_.size(); ++i) {
      if (groups_[i].code == 0 && groups_[i].value == "SECTION" && groups_[i + 1].code == 2 &&
          groups_[i + 1].value == section)
        return i + 2;
    }
    bad(0, "has no " + section + " section; give an ASCII DXF file");
  }

  void units() {
    for (std::size_t i = 0; i + 1 < groups_.size(); ++i) {
      if (groups_[i].code != 9 || groups_[i].value != "$INSUNITS") continue;
      static const std::map<int, double> scales{{1, 25.4}, {2, 304.8}, {4, 1}, {5, 10}, {6, 1000}};
      const int unit = static_cast<int>(number(groups_[i + 1]));
      const auto found = scales.find(unit);
      if (found != scales.end()) {
        scale_ = found->second;
        return;
      }
      if (unit != 0)
        bad(groups_[i + 1].line, "$INSUNITS: unit " + std::to_string(unit) +
                                     " is not known; use millimetres, centimetres, metres, inches or feet");
    }
    warnings_.push_back("says nothing of its units; they are taken for millimetres");
  }

  // The values of an entity.
  struct Values {
    std::map<int, std::vector<double>> by_code;
    double get(int code, double otherwise) const {
      const auto found = by_code.find(code);
      return found == by_code.end() ? otherwise : found->second.front();
    }
    const std::vector<double>& all(int code) const {
      static const std::vector<double> nothing;
      const auto found = by_code.find(code);
      return found == by_code.end() ? nothing : found->second;
    }
  };
  Values values(std::size_t from, std::size_t to) const {
    Values out;
    for (std::size_t i = from; i < to; ++i) {
      const int code = groups_[i].code;
      if ((code >= 10 && code < 60) || (code >= 70 && code < 80) || (code >= 210 && code < 240))
        out.by_code[code].push_back(number(groups_[i]));
    }
    return out;
  }

  void height(double z, int line) {
    z *= scale_;
    if (z_ && std::abs(*z_ - z) > 1e-6)
      bad(line, "lies at another height than the curves before; a slice is planar, give one height");
    z_ = z;
  }

  // Reads the entity at `i`, whose groups end before `end`; returns where the next one begins.
  std::size_t entity(std::size_t i, std::size_t end) {
    const std::string kind = groups_[i].value;
    const int line = groups_[i].line;
    const Values v = values(i + 1, end);
    Curve curve;
    curve.line = line;
    const double tolerance = tolerance_ / scale_;
    // the plane of the entity's own coordinates
    const Eigen::Vector3d normal(v.get(210, 0), v.get(220, 0), v.get(230, 1));
    if (normal.head<2>().norm() > 1e-9 * normal.norm())
      bad(line, kind + " lies in a tilted plane; a slice lies in x and y");
    bool own = true;  // coordinates are the entity's own, not the world's
    const auto xy = [&](int x) { return Vec2(v.get(x, 0), v.get(x + 10, 0)); };
    if (kind == "LWPOLYLINE") {
      std::vector<std::pair<Vec2, double>> corners;
      for (std::size_t k = i + 1; k < end; ++k) {
        if (groups_[k].code == 10) corners.emplace_back(Vec2(number(groups_[k]), 0), 0);
        if (groups_[k].code == 20 && !corners.empty()) corners.back().first.y() = number(groups_[k]);
        if (groups_[k].code == 42 && !corners.empty()) corners.back().second = number(groups_[k]);
      }
      polyline(corners, (static_cast<int>(v.get(70, 0)) & 1) != 0, curve, tolerance);
      height(v.get(38, 0), line);
    } else if (kind == "POLYLINE") {
      std::vector<std::pair<Vec2, double>> corners;
      const int flags = static_cast<int>(v.get(70, 0));
      if ((flags & ~(1 | 128 | 8)) != 0)
        bad(line, "POLYLINE is a mesh or a curve fit; explode it to lines and arcs");
      std::size_t next = end;
      while (next < groups_.size() && groups_[next].value == "VERTEX") {
        std::size_t stop = next + 1;
        while (stop < groups_.size() && groups_[stop].code != 0) ++stop;
        const Values w = values(next + 1, stop);
        corners.emplace_back(Vec2(w.get(10, 0), w.get(20, 0)), w.get(42, 0));
        height(w.get(30, 0), groups_[next].line);
        next = stop;
      }
      if (next < groups_.size() && groups_[next].value == "SEQEND") {
        ++next;
        while (next < groups_.size() && groups_[next].code != 0) ++next;
      }
      end = next;
      polyline(corners, (flags & 1) != 0, curve, tolerance);
    } else if (kind == "CIRCLE" || kind == "ARC") {
      const double r = v.get(40, 0);
      if (!(r > 0)) bad(line, kind + " has no radius; give one above 0");
      const Vec2 c = xy(10);
      double t0 = v.get(50, 0) * pi / 180, t1 = v.get(51, 0) * pi / 180;
      curve.closed = kind == "CIRCLE";
      if (curve.closed) t0 = 0, t1 = 2 * pi;
      while (t1 <= t0) t1 += 2 * pi;
      const auto at = [&](double t) { return Vec2(c + r * Vec2(std::cos(t), std::sin(t))); };
      if (!curve.closed) curve.points.push_back(at(t0));
      append_curve(curve.points, at, t0, t1, 8, tolerance);
      height(v.get(30, 0), line);
    } else if (kind == "LINE") {
      own = false;
      curve.points = {xy(10), xy(11)};
      height(v.get(30, 0), line);
      height(v.get(31, 0), line);
    } else if (kind == "ELLIPSE") {
      own = false;
      const Vec2 c = xy(10), major = xy(11),
                 minor = v.get(40, 1) * left_of(major) * (normal.z() < 0 ? -1 : 1);
      const double t0 = v.get(41, 0);
      double t1 = v.get(42, 2 * pi);
      while (t1 <= t0 + 1e-12) t1 += 2 * pi;
      curve.closed = std::abs(t1 - t0 - 2 * pi) < 1e-9;
      const auto at = [&](double t) { return Vec2(c + std::cos(t) * major + std::sin(t) * minor); };
      if (!curve.closed) curve.points.push_back(at(t0));
      append_curve(curve.points, at, t0, t1, 8, tolerance);
      height(v.get(30, 0), line);
    } else if (kind == "SPLINE") {
      own = false;
      spline(v, line, curve, tolerance);
    } else {
      ++left_out_[printable(kind)];
      return end;
    }
    for (Vec2& p : curve.points) {
      if (own && normal.z() < 0) p.x() = -p.x();
      p *= scale_;
    }
    if (!curve.closed && curve.points.size() > 2 &&
        (curve.points.front() - curve.points.back()).norm() <= join_mm) {
      curve.points.pop_back();
      curve.closed = true;
    }
    if (curve.points.size() > 1) curves_.push_back(std::move(curve));
    return end;
  }

  // The bulge is the tangent of a quarter of the angle of the arc to the next corner.
  static void polyline(const std::vector<std::pair<Vec2, double>>& corners, bool closed, Curve& curve,
                       double tolerance) {
    curve.closed = closed;
    const std::size_t n = corners.size();
    for (std::size_t k = 0; k < n; ++k) {
      const auto& [a, bulge] = corners[k];
      curve.points.push_back(a);
      if (bulge == 0 || (!closed && k + 1 == n)) continue;
      const Vec2 b = corners[(k + 1) % n].first, chord = b - a;
      const double angle = 4 * std::atan(bulge);
      if (chord.norm() == 0) continue;
      const Vec2 centre = a + chord / 2 + left_of(chord) / (2 * std::tan(angle / 2)), arm = a - centre;
      append_curve(
          curve.points, [&](double t) { return Vec2(centre + Eigen::Rotation2Dd(t) * arm); }, 0, angle, 4,
          tolerance);
      curve.points.pop_back();  // the next corner itself
      if (!closed && k + 2 == n) continue;
    }
  }

  void spline(const Values& v, int line, Curve& curve, double tolerance) {
    const auto degree = static_cast<std::size_t>(v.get(71, 3));
    const auto &knots = v.all(40), &x = v.all(10), &y = v.all(20);
    std::vector<double> weights = v.all(41);
    if (weights.empty()) weights.assign(x.size(), 1);
    if (degree < 1 || degree > 25 || x.size() != y.size() || weights.size() != x.size() ||
        x.size() <= degree || knots.size() != x.size() + degree + 1 ||
        !std::is_sorted(knots.begin(), knots.end()))
      bad(line, "SPLINE has no sound degree, knots and control points; save it by control points");
    for (const double z : v.all(30)) height(z, line);
    // de Boor
    const auto at = [&](double t, std::size_t span) {
      std::vector<Eigen::Vector3d> d;
      for (std::size_t j = 0; j <= degree; ++j) {
        const std::size_t k = span - degree + j;
        d.emplace_back(x[k] * weights[k], y[k] * weights[k], weights[k]);
      }
      for (std::size_t r = 1; r <= degree; ++r) {
        for (std::size_t j = degree; j >= r; --j) {
          const double lo = knots[span - degree + j], hi = knots[span + 1 + j - r];
          const double a = hi > lo ? (t - lo) / (hi - lo) : 0;
          d[j] = (1 - a) * d[j - 1] + a * d[j];
        }
      }
      return Vec2(d[degree].head<2>() / d[degree].z());
    };
    bool first = true;
    for (std::size_t span = degree; span < x.size(); ++span) {
      if (knots[span + 1] <= knots[span]) continue;
      if (first) curve.points.push_back(at(knots[span], span));
      first = false;
      append_curve(
          curve.points, [&](double t) { return at(t, span); }, knots[span], knots[span + 1], 2, tolerance);
    }
  }

  // Open curves end to end.
  void join() {
    std::vector<Curve> open;
    for (Curve& curve : curves_) {
      if (curve.closed)
        add(curve);
      else
        open.push_back(std::move(curve));
    }
    using Cell = std::pair<std::int64_t, std::int64_t>;
    const auto cell = [](const Vec2& p) {
      return Cell(static_cast<std::int64_t>(std::floor(p.x() / join_mm)),
                  static_cast<std::int64_t>(std::floor(p.y() / join_mm)));
    };
    std::map<Cell, std::vector<std::size_t>> ends;  // 2 k: start of curve k, 2 k + 1: its end
    const auto point = [&](std::size_t e) {
      return e % 2 == 0 ? open[e / 2].points.front() : open[e / 2].points.back();
    };
    for (std::size_t e = 0; e < 2 * open.size(); ++e) ends[cell(point(e))].push_back(e);
    const auto mate = [&](std::size_t e) {
      std::vector<std::size_t> found;
      const Cell middle = cell(point(e));
      for (std::int64_t dx = -1; dx <= 1; ++dx) {
        for (std::int64_t dy = -1; dy <= 1; ++dy) {
          const auto there = ends.find({middle.first + dx, middle.second + dy});
          if (there == ends.end()) continue;
          for (const std::size_t other : there->second) {
            if (other != e && (point(other) - point(e)).norm() <= join_mm) found.push_back(other);
          }
        }
      }
      const Vec2 p = point(e);
      const std::string where = "(" + number_text(p.x(), 6) + ", " + number_text(p.y(), 6) + ")";
      if (found.empty())
        bad(open[e / 2].line, "a curve ends at " + where +
                                  " mm and none goes on from there; close it: a slice needs closed rings");
      if (found.size() > 1)
        bad(open[e / 2].line, "more than two curves meet at " + where + " mm; let each ring be its own");
      return found[0];
    };
    std::vector<char> used(open.size(), 0);
    for (std::size_t k = 0; k < open.size(); ++k) {
      if (used[k]) continue;
      Curve ring{{}, true, open[k].line};
      std::size_t start = 2 * k;
      do {
        const std::size_t c = start / 2;
        used[c] = 1;
        std::vector<Vec2> points = open[c].points;
        if (start % 2 == 1) std::reverse(points.begin(), points.end());
        ring.points.insert(ring.points.end(), points.begin(), points.end() - 1);
        start = mate(start ^ 1);
      } while (start != 2 * k && !used[start / 2]);
      add(ring);
    }
  }

  void add(const Curve& curve) {
    rings_.push_back(
        {std::to_string(rings_.size()), curve.points, std::vector<int>(curve.points.size(), curve.line)});
  }

  const std::string& path_;
  double tolerance_, scale_ = 1;
  std::vector<Group> groups_;
  std::vector<Curve> curves_;
  std::vector<InputRing> rings_;
  std::optional<double> z_;
  std::vector<std::string> warnings_;
  std::map<std::string, int> left_out_;
};

}  // namespace

SliceFile read_slice_dxf(const std::string& path, double tolerance_mm) {
  return Reader(path, tolerance_mm).read();
}

}  // namespace afptraj
