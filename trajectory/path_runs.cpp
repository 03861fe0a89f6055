#include "trajectory/path_runs.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>

#include "geometry/curvature.h"

namespace afptraj {
namespace {

/// Coordinate lines bend as 1 / d at the distance d from a pole. A cubic spline of knot spacing h holds a
/// path there in (u, v) to h^4 / 57 d^3 (the fourth derivatives of polar coordinates along a line): 4e-5 h at
/// 8 h.
constexpr double turning_spacings = 8;

/// Where the step from p to q leaves p's chart, and where it arrives on the next one.
struct Passage {
  SurfacePoint out, in;
  Vec3 tangent = Vec3::Zero();
  int normal_sign = 1;
};

bool same_chart(const Skin& skin, const SurfacePoint& p, const SteppedPoint& q) {
  if (p.face != q.at.face || crease_between(skin.face(p.face).surface, p.uv, q.at.uv)) return false;
  // The straight (u, v) segment must be as long on the surface as the step in space.
  const SurfaceDerivatives d = skin.derivatives({p.face, 0.5 * (p.uv + q.at.uv)});
  const double along = uv_to_tangent(d, q.at.uv - p.uv).norm();
  return along < 1.5 * (q.position - skin.point(p)).norm() + 1e-9;
}

/// The cubic from `a` to `b` on a face with these directions at its ends; a straight line where they say
/// nothing.
UvCubic cubic_between(const Surface& surface, const Uv& a, const Uv& b, const Vec3& from, const Vec3& to) {
  const SurfaceDerivatives da = surface.derivatives(a), db = surface.derivatives(b);
  const double length = (db.S - da.S).norm();
  const Uv start = length * tangent_to_uv(da, from), end = length * tangent_to_uv(db, to);
  const double chord = (b - a).norm();
  if (!(start.norm() < 3 * chord && end.norm() < 3 * chord)) return UvCubic::line(a, b);
  return UvCubic::hermite(a, start, b, end);
}

/// Where the straight way over the surface from p to q crosses a line on which the parametrisation is only
/// continuous, from a guess on it: as far along the line as both sides laid flat say. A curve in (u, v) crosses
/// it elsewhere, as the speeds of the parametrisation on the two sides differ.
Uv straight_crossing(const Surface& surface, const CreaseCrossing& crease, Uv uv, const Vec3& p, const Vec3& q) {
  const int along = 1 - crease.axis;
  uv[crease.axis] = crease.value;
  for (int iteration = 0; iteration < 20; ++iteration) {
    const SurfaceDerivatives d = surface.derivatives(uv);
    const Vec3 line = along == 0 ? d.Su : d.Sv;
    const Vec3 e = line.normalized(), to_p = p - d.S, to_q = q - d.S;
    const double off_p = to_p.cross(e).norm(), off_q = to_q.cross(e).norm();
    const double move = (to_p.dot(e) * off_q + to_q.dot(e) * off_p) / (off_p + off_q);
    if (!std::isfinite(move / line.norm())) break;
    uv[along] += move / line.norm();
    if (std::abs(move) < 1e-9) break;
  }
  return uv;
}

/// Follows the path from p to q, where it has the directions `from` and `to`, over edges to q's chart; at
/// most a few faces lie between. Empty when it does not arrive there.
std::vector<Passage> passages(const Skin& skin, const SteppedPoint& p, const SteppedPoint& q, Vec3 from,
                              const Vec3& to) {
  std::vector<Passage> out;
  SurfacePoint at = p.at;
  Vec3 carried = p.normal_sign * skin.normal(p.at);
  for (int hop = 0; hop < 8; ++hop) {
    const Surface& surface = skin.face(at.face).surface;
    const SurfaceDerivatives d = surface.derivatives(at.uv);
    Uv seed = at.uv + tangent_to_uv(d, q.position - d.S);
    if (!seed.allFinite()) seed = at.uv;
    const auto foot = foot_point(surface, q.position, seed);
    const UvCubic path = cubic_between(surface, at.uv, foot ? *foot : seed, from, to);
    const auto hit = skin.trim(at.face).first_crossing(path, true);
    const auto crease = crease_between(surface, at.uv, path.point(1));
    Passage passage;
    if (crease && (!hit || crease->x < hit->x)) {
      const Uv uv = straight_crossing(surface, *crease, at.uv + crease->x * (path.point(1) - at.uv), d.S, q.position);
      const Vec3 x = surface.point(uv);
      const double before = (x - d.S).norm(), after = (q.position - x).norm();
      passage.tangent = (after * from + before * to).normalized();
      passage.out = passage.in = {at.face, uv};
    } else if (hit) {
      const EdgeUse use{at.face, hit->loop, hit->coedge};
      if (!skin.mate(use)) return {};
      passage.tangent = uv_to_tangent(surface.derivatives(path.point(hit->x)), path.derivative(hit->x)).normalized();
      passage.out = {at.face, hit->uv};
      passage.in = skin.across(use, hit->t, surface.point(hit->uv));
    } else {
      return {};
    }
    from = passage.tangent;
    const Vec3 n = skin.normal(passage.in);
    passage.normal_sign = n.dot(carried) >= 0 ? 1 : -1;
    if (!n.isZero()) carried = passage.normal_sign * n;
    out.push_back(passage);
    at = passage.in;
    if (same_chart(skin, at, q)) return out;
  }
  return {};
}

/// Greatest geodesic curvature of the coordinate lines; infinite at a pole.
double turn_of_lines(const Skin& skin, const SurfacePoint& at) {
  const SurfaceDerivatives d = skin.derivatives(at);
  const Vec3 n = unit_normal(d);
  const double turn = std::max(std::abs(geodesic_curvature(d, n, Uv(1, 0), Uv::Zero())),
                               std::abs(geodesic_curvature(d, n, Uv(0, 1), Uv::Zero())));
  return n.isZero() || !std::isfinite(turn) ? std::numeric_limits<double>::infinity() : turn;
}

class Splitter {
 public:
  Splitter(const Skin& skin, const SteppedPath& path, double knot_spacing_mm, double margin_mm)
      : skin_(skin),
        path_(path),
        points_(path.points),
        knot_spacing_mm_(knot_spacing_mm),
        t_(points_.size(), 0.0) {
    geodesic_.margin_mm = geodesic_.outside_limit_mm = margin_mm;
    for (std::size_t i = 1; i < points_.size(); ++i)
      t_[i] = t_[i - 1] + (points_[i].position - points_[i - 1].position).norm();
    for (const SteppedPoint& p : points_) turn_.push_back(turn_of_lines(skin, p.at));
  }

  std::vector<Run> split() {
    for (std::size_t first = 0; first + 1 < points_.size();) {
      std::size_t last = first + 1;
      const bool turns = turns_between(first);
      while (last + 1 < points_.size() && turns_between(last) == turns) ++last;
      // To an apex the path runs along a meridian, which (u, v) hold and no chart about a geodesic does.
      if (turns && !at_apex(first) && !at_apex(last))
        about_geodesics(first, last);
      else
        in_uv(first, last);
      first = last;
    }
    // A run of a single point (a touch of a chart) carries no curve.
    std::erase_if(runs_, [](const Run& r) { return r.t.size() < 2; });
    if (path_.closed) {
      const Vec3 along = (points_[1].position - points_[points_.size() - 2].position).normalized();
      runs_.front().fixed[0] = runs_.back().fixed[1] = true;
      runs_.front().tangent[0] = runs_.back().tangent[1] = along;
    }
    return std::move(runs_);
  }

 private:
  /// Whether (u, v) are no chart to fit the step from point i to the next in.
  bool turns_between(std::size_t i) const {
    return std::max(turn_[i], turn_[i + 1]) * turning_spacings * knot_spacing_mm_ > 1 ||
           (!same_chart(skin_, points_[i].at, points_[i + 1]) && passages_after(i).empty());
  }
  bool at_apex(std::size_t i) const {
    return (i == 0 && path_.end[0] == WalkEnd::pole) ||
           (i + 1 == points_.size() && path_.end[1] == WalkEnd::pole);
  }

  std::vector<Passage> passages_after(std::size_t i) const {
    return passages(skin_, points_[i], points_[i + 1], tangent_at(i), tangent_at(i + 1));
  }

  /// Direction at a point by the parabola through it and its neighbours.
  Vec3 tangent_at(std::size_t i) const {
    if (i == 0) return (points_[1].position - points_[0].position).normalized();
    const Vec3 a = points_[i].position - points_[i - 1].position;
    if (i + 1 == points_.size()) return a.normalized();
    const Vec3 b = points_[i + 1].position - points_[i].position;
    const double ha = std::max(a.norm(), 1e-12), hb = std::max(b.norm(), 1e-12);
    return (hb / ha * a + ha / hb * b).normalized();
  }
  void open_run(PathChart chart) {
    runs_.emplace_back();
    runs_.back().chart = std::move(chart);
  }
  void add(double t, const Uv& at) {
    runs_.back().t.push_back(t);
    runs_.back().at.push_back(at);
  }
  /// Drops points that would make a span of no length, but not the `last`.
  void add_next(double t, const Uv& at, bool last) {
    if (runs_.back().t.empty()) return add(t, at);
    const double reached = runs_.back().t.back();
    if (last || t - reached >= 1e-3) add(std::max(t, reached + 1e-6), at);
  }
  void fix(int end, const Vec3& tangent) {
    runs_.back().fixed[end] = true;
    runs_.back().tangent[end] = tangent;
  }
  /// Fixes an end of a run at point i, unless it is a free end of the path. At an apex the direction is left
  /// open.
  void fix_at(int end, std::size_t i) {
    if (at_apex(i))
      fix(end, Vec3::Zero());
    else if (i > 0 && i + 1 < points_.size())
      fix(end, tangent_at(i));
  }

  void in_uv(std::size_t first, std::size_t last) {
    open_run({points_[first].at.face, points_[first].normal_sign, nullptr});
    add(t_[first], points_[first].at.uv);
    fix_at(0, first);
    for (std::size_t i = first + 1; i <= last; ++i) {
      if (!same_chart(skin_, points_[i - 1].at, points_[i])) go_over(i);
      add_next(t_[i], points_[i].at.uv, i == last);
    }
    fix_at(1, last);
  }

  /// Goes over from the chart of point i - 1 to that of point i.
  void go_over(std::size_t i) {
    const std::vector<Passage> between = passages_after(i - 1);
    if (between.empty()) open_run({points_[i].at.face, points_[i].normal_sign, nullptr});
    for (const Passage& passage : between) {
      const Vec3 x = skin_.point(passage.out);
      const double a = (x - points_[i - 1].position).norm(), b = (points_[i].position - x).norm();
      const double at = t_[i - 1] + (t_[i] - t_[i - 1]) * a / std::max(a + b, 1e-12);
      // A stepped point on the very edge would make a span of no length: the passage replaces it.
      while (runs_.back().t.size() > 1 && at - runs_.back().t.back() < 1e-3) {
        runs_.back().t.pop_back();
        runs_.back().at.pop_back();
      }
      add(std::max(at, runs_.back().t.back() + 1e-6), passage.out.uv);
      fix(1, passage.tangent);
      const double reached = runs_.back().t.back();
      open_run({passage.in.face, passage.normal_sign, nullptr});
      add(reached, passage.in.uv);
      fix(0, passage.tangent);
    }
  }

  /// The first chart stands where the coordinate lines turn most; what it does not hold goes on others.
  void about_geodesics(std::size_t first, std::size_t last) {
    std::size_t middle = first;
    for (std::size_t i = first; i <= last; ++i)  // on a pole itself there is no frame
      if (std::isfinite(turn_[i]) && !(turn_[i] <= turn_[middle])) middle = i;
    const SteppedPoint& about = points_[middle];
    const double slack = 0.2 * (t_[last] - t_[first]) + knot_spacing_mm_;
    const auto chart = std::make_shared<const GeodesicChart>(
        skin_, about.at, tangent_at(middle), about.normal_sign, t_[middle] - t_[first] + slack,
        t_[last] - t_[middle] + slack, geodesic_);
    std::deque<Uv> at = {chart->origin()};
    std::size_t from = middle, to = middle;
    for (; from > first; --from) {
      const auto sw = next_coordinates(*chart, from - 1, from, at.front());
      if (!sw) break;
      at.push_front(*sw);
    }
    for (; to < last; ++to) {
      const auto sw = next_coordinates(*chart, to + 1, to, at.back());
      if (!sw) break;
      at.push_back(*sw);
    }
    if (from == to) return in_uv(first, last);  // no geodesic leads on from here
    if (from > first) about_geodesics(first, from);
    open_run({about.at.face, about.normal_sign, chart});
    for (std::size_t i = from; i <= to; ++i) add_next(t_[i], at[i - from], i == to);
    fix_at(0, from);
    fix_at(1, to);
    if (to < last) about_geodesics(to, last);
  }

  /// The coordinates of point i from those of its neighbour; nothing where the chart is no good one.
  std::optional<Uv> next_coordinates(const GeodesicChart& chart, std::size_t i, std::size_t neighbour,
                                     const Uv& from) const {
    const auto sw = chart.coordinates(points_[i].position, from);
    if (!sw) return std::nullopt;
    const GeodesicChart::Place place = chart.place(*sw);
    if (place.normal.dot(points_[i].normal_sign * skin_.normal(points_[i].at)) < 0) return std::nullopt;
    // Behind an apex the chart is torn.
    const double step = uv_to_tangent(place.d, *sw - from).norm();
    if (step > 1.5 * (points_[i].position - points_[neighbour].position).norm() + 1e-9) return std::nullopt;
    return sw;
  }

  const Skin& skin_;
  const SteppedPath& path_;
  const std::vector<SteppedPoint>& points_;
  double knot_spacing_mm_;
  GeodesicOptions geodesic_;
  std::vector<double> t_, turn_;  // by point
  std::vector<Run> runs_;
};

}  // namespace

std::vector<Run> split_runs(const Skin& skin, const SteppedPath& path, double knot_spacing_mm,
                            double margin_mm) {
  return Splitter(skin, path, knot_spacing_mm, margin_mm).split();
}

}  // namespace afptraj
