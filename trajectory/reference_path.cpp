#include "trajectory/reference_path.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "geometry/curvature.h"
#include "trajectory/apex.h"
#include "trajectory/sideways.h"

namespace afptraj {
namespace {

/// Point at arc length `length` on the circle through p with unit tangent t and curvature k toward n.
Vec3 on_arc(const Vec3& p, const Vec3& t, const Vec3& n, double k, double length) {
  const double a = k * length;
  if (std::abs(a) < 1e-4)  // series: the closed form loses digits; next term a^4 length / 24
    return p + length * (1 - a * a / 6) * t + length * (a / 2 - a * a * a / 24) * n;
  return p + (std::sin(a) * t + (1 - std::cos(a)) * n) / k;
}

/// Normal sign on a new face that keeps the carried normal.
int keep_sign(const Skin& skin, const SurfacePoint& at, const Vec3& carried) {
  return skin.normal(at).dot(carried) >= 0 ? 1 : -1;
}

std::optional<ArcStep> by_search(const Skin& skin, const Vec3& target, double length, const Vec3& carried) {
  const auto found = skin.closest_point().closest(target, 0.5 * length);
  if (!found || found->on_boundary) return std::nullopt;
  return ArcStep{found->at, keep_sign(skin, found->at, carried), false};
}

/// Follows the straight (u, v) segment to the foot over shared edges; each face projects anew.
std::optional<ArcStep> follow(const Skin& skin, const ArcStep& from, const Vec3& target, const Vec3& direction,
                              double length, const Vec3& carried) {
  ArcStep at = from;
  Uv seed = at.at.uv;
  {
    const SurfaceDerivatives d = skin.derivatives(at.at);
    seed += tangent_to_uv(d, length * direction);
  }
  for (int hop = 0; hop < 8; ++hop) {
    const Surface& surface = skin.face(at.at.face).surface;
    const auto foot = foot_point(surface, target, seed);
    if (!foot || (surface.point(*foot) - target).norm() > 0.5 * length) return by_search(skin, target, length, carried);
    const UvCubic path = UvCubic::line(at.at.uv, *foot);
    const auto hit = skin.trim(at.at.face).first_crossing(path, !at.outside);
    if (!hit) {
      at.at.uv = *foot;
      return at;
    }
    const EdgeUse use{at.at.face, hit->loop, hit->coedge};
    if (at.outside) {
      at.outside = false;
      at.at.uv = hit->uv + 1e-9 * (*foot - hit->uv);
      continue;
    }
    if (skin.edge(use).degenerate) return by_search(skin, target, length, carried);
    const auto mate = skin.mate(use);
    if (!mate) {
      if (!skin.is_hole(use.face, use.loop)) return std::nullopt;
      at.outside = true;
      at.at.uv = *foot;
      return at;
    }
    const Coedge& in = skin.coedge(*mate);
    at.at = {mate->face, in.pcurve.point(std::clamp(hit->t, in.pcurve.first(), in.pcurve.last()))};
    at.normal_sign = keep_sign(skin, at.at, carried);
    seed = at.at.uv;
  }
  return by_search(skin, target, length, carried);
}

/// Finds earlier points of the path near a new one.
class PointGrid {
 public:
  explicit PointGrid(double cell) : cell_(cell) {}
  void add(const Vec3& p, std::size_t index) { cells_[key(p)].push_back(index); }
  template <typename Visit>
  void near(const Vec3& p, Visit visit) const {
    for (int i = -1; i <= 1; ++i)
      for (int j = -1; j <= 1; ++j)
        for (int k = -1; k <= 1; ++k) {
          const auto it = cells_.find(key(p + cell_ * Vec3(i, j, k)));
          if (it == cells_.end()) continue;
          for (std::size_t index : it->second) visit(index);
        }
  }

 private:
  std::int64_t key(const Vec3& p) const {
    const auto c = [&](double x) { return static_cast<std::int64_t>(std::floor(x / cell_)) & 0x1fffff; };
    return c(p.x()) | (c(p.y()) << 21) | (c(p.z()) << 42);
  }
  double cell_;
  std::unordered_map<std::int64_t, std::vector<std::size_t>> cells_;
};

struct Walk {
  std::vector<SteppedPoint> points;
  WalkEnd end = WalkEnd::stuck;
  std::size_t steps = 0, doubled = 0;
};

class Walker {
 public:
  Walker(const Skin& skin, const DirectionField& field, const StepOptions& options)
      : skin_(skin), field_(field), options_(options), poles_(poles_of(skin)), grid_(options.band_width_mm) {}

  Walk walk(const SteppedPoint& start, const Vec3& first_direction) {
    Walk out;
    out.points.push_back(start);
    ArcStep at{start.at, start.normal_sign, false};
    Vec3 direction = first_direction;
    double s = 0;
    while (s < options_.max_length_mm) {
      const SurfaceDerivatives d = skin_.derivatives(at.at);
      const Vec3 n = at.normal_sign * skin_.normal(at.at);
      if (n.isZero()) return ended(out, WalkEnd::pole);
      AskedDirection asked = field_.at(d.S, n, direction);
      if (asked.singular || (asked.strength < options_.least_strength && s > 0))
        return ended(out, WalkEnd::singular_field);
      double length = step_length(d, n, asked.direction);
      if (const Pole* apex = apex_ahead(d.S, asked.direction, length)) {
        if (!go_over(*apex, out)) return ended(out, WalkEnd::pole);
        at = {out.points.back().at, out.points.back().normal_sign, false};
        direction = out.points.back().direction;
        s = out.points.back().s_mm;
        continue;
      }
      // Midpoint rule: the direction half a step ahead makes the step second order.
      bool doubled = asked.range_doubled;
      if (const auto half = arc_step(skin_, at, asked.direction, 0.5 * length);
          half && !meets_pole(d.S, length, half)) {
        const Vec3 half_n = half->normal_sign * skin_.normal(half->at);
        const AskedDirection ahead = field_.at(skin_.point(half->at), half_n, asked.direction);
        if (!half_n.isZero() && !ahead.singular) {
          const Vec3 back = turn_back(ahead.direction, half_n, n);
          if (back.norm() > 0.5) asked.direction = back.normalized();
          doubled = doubled || ahead.range_doubled;
        }
      }
      auto next = arc_step(skin_, at, asked.direction, length);
      // A pole itself has no frame: half the step ends before it, and the next one beyond.
      if (meets_pole(d.S, length, next)) next = arc_step(skin_, at, asked.direction, length *= 0.5);
      if (!next) return ended(out, WalkEnd::boundary);
      const Vec3 position = skin_.point(next->at);
      const double moved = (position - d.S).norm();
      if (moved < 0.1 * length) return ended(out, WalkEnd::stuck);
      ++out.steps;
      if (doubled) ++out.doubled;
      s += moved;
      longest_step_ = std::max(longest_step_, moved);
      // Carry the direction by the chord: it keeps the sense of the walk.
      direction = (position - d.S).normalized();
      const SteppedPoint point{next->at, position, direction, next->normal_sign, s};
      if (const auto met = alongside(point)) {
        if (*met == WalkEnd::closed) out.points.push_back(point);
        return ended(out, *met);
      }
      remember(out.points.back());
      out.points.push_back(point);
      at = *next;
    }
    return ended(out, WalkEnd::length);
  }

  /// Points of an earlier walk that this one must not come alongside of.
  void keep_clear_of(const std::vector<SteppedPoint>& points) { earlier_ = points; earlier_grid_fill(); }

 private:
  static Walk ended(Walk& walk, WalkEnd end) {
    walk.end = end;
    return std::move(walk);
  }
  /// Parallel transport over half a step: the rotation that takes one normal to the other.
  static Vec3 turn_back(const Vec3& v, const Vec3& from, const Vec3& to) {
    return Eigen::Quaterniond::FromTwoVectors(from, to) * v;
  }
  double step_length(const SurfaceDerivatives& d, const Vec3& n, const Vec3& direction) const {
    const double k = std::abs(normal_curvature(d, n, direction));
    const double by_chord = k > 0 ? std::sqrt(8 * options_.chord_error_mm / k) : options_.step_mm;
    return std::min(options_.step_mm, by_chord);
  }
  /// Whether a step from p ends on a pole to a rounding error, or finds no foot that near to one.
  bool meets_pole(const Vec3& p, double length, const std::optional<ArcStep>& step) const {
    return std::any_of(poles_.begin(), poles_.end(), [&](const Pole& pole) {
      return (pole.point - p).norm() < 1.5 * length &&
             (!step || (pole.point - skin_.point(step->at)).norm() < 1e-6);
    });
  }
  /// An apex that the next step would pass.
  const Pole* apex_ahead(const Vec3& p, const Vec3& direction, double length) const {
    for (const Pole& pole : poles_) {
      const Vec3 to = pole.point - p;
      if (!pole.smooth && to.norm() < 1.5 * length && to.dot(direction) > 0.5 * to.norm()) return &pole;
    }
    return nullptr;
  }
  /// Goes on over an apex, by an arc from W/2 before it to W/2 after it, or else ends there: false.
  bool go_over(const Pole& apex, Walk& out) {
    std::vector<SteppedPoint>& points = out.points;
    std::size_t kept = points.size();
    while (kept > 1 && (points[kept - 1].position - apex.point).norm() < 0.5 * options_.band_width_mm) --kept;
    const auto arc = arc_over_apex(skin_, apex, points[kept - 1], options_);
    if (!arc) {
      const auto end = beside_pole(skin_, apex.point, points.back().position, beside_apex_mm, points.back());
      if (end) points.push_back(*end);
      return false;
    }
    points.resize(kept);
    for (const SteppedPoint& p : *arc) {
      remember(points.back());
      points.push_back(p);
      ++out.steps;
    }
    return true;
  }
  void remember(const SteppedPoint& p) {
    own_.push_back(p);
    grid_.add(p.position, own_.size() - 1);
  }
  void earlier_grid_fill() {
    for (std::size_t i = 0; i < earlier_.size(); ++i) {
      remember(earlier_[i]);
      if (i > 0) longest_step_ = std::max(longest_step_, earlier_[i].s_mm - earlier_[i - 1].s_mm);
    }
    own_start_ = own_.size();
  }
  /// Whether the path has come back alongside an older stretch of itself, within W and not just
  /// end-on; or to its own start, near enough to be closed.
  std::optional<WalkEnd> alongside(const SteppedPoint& p) const {
    const double W = options_.band_width_mm;
    const Vec3 n = p.normal_sign * skin_.normal(p.at);
    std::optional<WalkEnd> out;
    grid_.near(p.position, [&](std::size_t i) {
      if (out == WalkEnd::closed) return;
      const SteppedPoint& q = own_[i];
      const bool own = i >= own_start_;
      // An earlier walk ran the other way from the same start.
      const double apart = own ? p.s_mm - q.s_mm : p.s_mm + q.s_mm;
      const bool same_sense = (own ? 1 : -1) * p.direction.dot(q.direction) > 0.5;
      // Abreast of a point it passed in the same sense, it has gone full circle since, however small that was.
      // In the other sense it may only have made a turn.
      if (apart < (same_sense ? 4 * longest_step_ : 3 * W)) return;
      const Vec3 r = q.position - p.position;
      if (std::abs(r.dot(p.direction)) > longest_step_ || r.norm() > W) return;
      if (n.dot(q.normal_sign * skin_.normal(q.at)) < 0.5) return;
      // Sideways along the skin: the height of the arc between the points is no distance.
      const double lateral = r.norm() < 2 * longest_step_ ? std::abs(r.dot(n.cross(p.direction))) : r.norm();
      const bool is_start = own && i == 0;
      out = is_start && same_sense && lateral <= options_.closing_rad * p.s_mm ? WalkEnd::closed : WalkEnd::alongside;
    });
    return out;
  }

  const Skin& skin_;
  const DirectionField& field_;
  StepOptions options_;
  std::vector<Pole> poles_;
  PointGrid grid_;
  std::vector<SteppedPoint> own_, earlier_;
  std::size_t own_start_ = 0;
  double longest_step_ = 0;
};

/// Closes a walk that came back alongside its start: takes the distance up evenly along the way.
void close(const Skin& skin, const StepOptions& options, std::vector<SteppedPoint>& points, SteppedPath& out) {
  const SteppedPoint start = points.front(), end = points.back();
  const Vec3 left = (end.normal_sign * skin.normal(end.at)).cross(end.direction);
  const double w = (start.position - end.position).dot(left);
  out.closed_over_mm = std::abs(w);
  const GeodesicTracer tracer = sideways_tracer(skin, options.band_width_mm);
  for (SteppedPoint& p : points)
    if (const double part = w * p.s_mm / end.s_mm; std::abs(part) > 1e-9) move_sideways(tracer, p, part);
  points.back().at = start.at;
  points.back().position = start.position;
  points.back().normal_sign = start.normal_sign;
  renew_directions(points, true);
}

}  // namespace

const char* to_string(WalkEnd end) {
  switch (end) {
    case WalkEnd::boundary: return "boundary";
    case WalkEnd::pole: return "pole";
    case WalkEnd::closed: return "closed on itself";
    case WalkEnd::alongside: return "came alongside itself";
    case WalkEnd::singular_field: return "directions cancel or stand on the skin";
    case WalkEnd::length: return "length limit";
    case WalkEnd::stuck: return "no foot on the skin";
  }
  return "";
}

std::optional<ArcStep> arc_step(const Skin& skin, const ArcStep& from, const Vec3& direction, double length) {
  const SurfaceDerivatives d = skin.derivatives(from.at);
  const Vec3 n = from.normal_sign * skin.normal(from.at);
  if (n.isZero()) return std::nullopt;
  const Vec3 t = (direction - direction.dot(n) * n).normalized();
  const double k = normal_curvature(d, n, t);
  const Vec3 target = on_arc(d.S, t, n, k, length);
  return follow(skin, from, target, t, length, n);
}

SteppedPath step_reference_path(const Skin& skin, const DirectionField& field, const SurfacePoint& start,
                                const StepOptions& options) {
  SteppedPath out;
  const Vec3 n = skin.normal(start);
  const Vec3 p = skin.point(start);
  const AskedDirection asked = field.at(p, n, field.points().empty() ? Vec3::UnitX() : field.points().front().direction);
  SteppedPoint first{start, p, asked.direction, 1, 0};
  if (n.isZero() || asked.singular) {
    out.points = {first};
    out.end[0] = out.end[1] = n.isZero() ? WalkEnd::pole : WalkEnd::singular_field;
    return out;
  }
  Walker forward_walker(skin, field, options);
  Walk forward = forward_walker.walk(first, asked.direction);
  out.steps = forward.steps;
  out.doubled = forward.doubled;
  out.end[1] = forward.end;
  if (forward.end == WalkEnd::closed) {
    out.closed = true;
    out.end[0] = WalkEnd::closed;
    close(skin, options, forward.points, out);
    out.points = std::move(forward.points);
    return out;
  }
  Walker backward_walker(skin, field, options);
  backward_walker.keep_clear_of(forward.points);
  Walk backward = backward_walker.walk(first, -asked.direction);
  out.steps += backward.steps;
  out.doubled += backward.doubled;
  out.end[0] = backward.end;
  for (std::size_t i = backward.points.size(); i-- > 1;) {
    SteppedPoint q = backward.points[i];
    q.direction = -q.direction;
    q.s_mm = -q.s_mm;
    out.points.push_back(q);
  }
  out.points.insert(out.points.end(), forward.points.begin(), forward.points.end());
  return out;
}

}  // namespace afptraj
