#include "geometry/trim_crossing.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/bezier.h"

namespace afptraj::trim {
namespace {

double cross(const Uv& a, const Uv& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Point and derivative of the true pcurve of a segment at s in [0, 1] (0 at `a`).
void curve_at(const SegmentGrid& grid, const Segment& segment, double s, Uv& point, Uv& derivative) {
  Eigen::Vector3d value, slope;
  bezier::evaluate(&grid.control[static_cast<std::size_t>(segment.control)], segment.degree, s, value, slope);
  point = project(value);
  derivative = (slope.head<2>() - slope.z() * point) / value.z();
}

double parameter(const Segment& segment, double s) { return segment.t0 + s * (segment.t1 - segment.t0); }

/// Node visits that one pair of path and segment may cost; a path that runs along a loop would
/// otherwise be split for ever.
constexpr int pair_budget = 400;

}  // namespace

CrossingSearch::CrossingSearch(const SegmentGrid& grid, const UvCubic& path)
    : grid_(grid),
      path_{grid.scaled(path.a), grid.scaled(path.b), grid.scaled(path.c), grid.scaled(path.d)} {}

CrossingSearch::PathPiece CrossingSearch::PathPiece::split_left() {
  PathPiece left;
  const double middle = 0.5 * (x0 + x1);
  const Uv p01 = 0.5 * (p[0] + p[1]), p12 = 0.5 * (p[1] + p[2]), p23 = 0.5 * (p[2] + p[3]);
  const Uv p012 = 0.5 * (p01 + p12), p123 = 0.5 * (p12 + p23);
  const Uv m = 0.5 * (p012 + p123);
  left.p = {p[0], p01, p012, m};
  left.x0 = x0;
  left.x1 = middle;
  p = {m, p123, p23, p[3]};
  x0 = middle;
  return left;
}

std::vector<LoopCrossing> CrossingSearch::run(bool first_only, bool outward) {
  std::vector<LoopCrossing> result;
  PathPiece whole{{path_.a, path_.a + path_.b / 3, path_.a + (2 * path_.b + path_.c) / 3,
                   path_.a + path_.b + path_.c + path_.d},
                  0,
                  1};
  int i0, i1, j0, j1;
  if (!grid_.cells(whole.low(), whole.high(), i0, i1, j0, j1) || grid_.mixed_count(i0, i1, j0, j1) == 0)
    return result;
  size_ = std::max((whole.high() - whole.low()).maxCoeff(), std::numeric_limits<double>::min());
  gather(whole, 0);
  if (candidates_.empty()) return result;
  std::sort(candidates_.begin(), candidates_.end(),
            [](const Candidate& a, const Candidate& b) { return a.x < b.x; });

  // The state between groups of coinciding candidates decides which of them are crossings: so
  // they alternate (law T3), and touching or twice-found points cancel.
  const double same = std::max(1e-15, 4 * grid_.on / size_);
  double x_before = 0;
  bool before = grid_.contains(point(0));
  for (std::size_t i = 0; i < candidates_.size();) {
    std::size_t end = i + 1;
    while (end < candidates_.size() && candidates_[end].x - candidates_[end - 1].x <= same) ++end;
    const double last = candidates_[end - 1].x;
    const double x_after = end < candidates_.size() ? 0.5 * (last + candidates_[end].x) : 1.0;
    const bool after = grid_.contains(point(x_after));
    if (after != before) {
      auto found = std::find_if(candidates_.begin() + static_cast<std::ptrdiff_t>(i),
                                candidates_.begin() + static_cast<std::ptrdiff_t>(end),
                                [](const Candidate& c) { return c.segment >= 0; });
      const bool known = found != candidates_.begin() + static_cast<std::ptrdiff_t>(end);
      if (!first_only || before == outward) {
        LoopCrossing crossing = known ? crossing_at(*found) : crossing_between(x_before, before, x_after);
        crossing.outward = before;
        result.push_back(crossing);
        if (first_only) return result;
      }
    }
    before = after;
    x_before = x_after;
    i = end;
  }
  return result;
}

void CrossingSearch::gather(PathPiece piece, int depth) {
  int i0, i1, j0, j1;
  if (!grid_.cells(piece.low(), piece.high(), i0, i1, j0, j1) || grid_.mixed_count(i0, i1, j0, j1) == 0)
    return;
  if ((i1 - i0 + 1) * (j1 - j0 + 1) > 16 && depth < 24) {
    gather(piece.split_left(), depth + 1);
    gather(piece, depth + 1);
    return;
  }
  std::vector<int> near;
  for (int j = j0; j <= j1; ++j) {
    for (int i = i0; i <= i1; ++i) {
      const auto k = static_cast<std::size_t>(j * grid_.nx + i);
      near.insert(near.end(), grid_.cell_segments.begin() + grid_.cell_begin[k],
                  grid_.cell_segments.begin() + grid_.cell_begin[k + 1]);
    }
  }
  std::sort(near.begin(), near.end());
  near.erase(std::unique(near.begin(), near.end()), near.end());
  for (const int segment : near) meet(piece, segment);
}

bool CrossingSearch::may_meet(const PathPiece& path, const Uv& a, const Uv& b, double eps) const {
  const double margin = eps + 2 * grid_.on;
  const Uv d = b - a;
  const double length = d.norm();
  const Uv t = length > 0 ? Uv(d / length) : Uv(Uv::UnitX());
  double across_lo = std::numeric_limits<double>::infinity(), across_hi = -across_lo;
  double along_lo = across_lo, along_hi = across_hi;
  for (const Uv& p : path.p) {
    const double across = cross(t, p - a);
    const double along = t.dot(p - a);
    across_lo = std::min(across_lo, across);
    across_hi = std::max(across_hi, across);
    along_lo = std::min(along_lo, along);
    along_hi = std::max(along_hi, along);
  }
  return across_lo <= margin && across_hi >= -margin && along_lo <= length + margin && along_hi >= -margin;
}

bool CrossingSearch::at_most_one(const PathPiece& path, const std::vector<Eigen::Vector3d>& control) {
  // Directions of a (rational) Bezier curve lie in the cone of P_j - P_i, i < j; those of the
  // path in the cone of its differences. Cones that never become parallel meet once at most.
  int sign = 0;
  const std::size_t n = control.size();
  for (int k = 0; k < 3; ++k) {
    const Uv d = path.p[static_cast<std::size_t>(k) + 1] - path.p[static_cast<std::size_t>(k)];
    const double length = d.norm();
    if (length == 0) return false;
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = i + 1; j < n; ++j) {
        const Uv e = project(control[j]) - project(control[i]);
        const double area = cross(e, d);
        if (std::abs(area) <= 1e-9 * length * e.norm()) return false;
        const int side = area > 0 ? 1 : -1;
        if (sign != 0 && side != sign) return false;
        sign = side;
      }
    }
  }
  return sign != 0;
}

void CrossingSearch::meet(const PathPiece& path, int index) {
  const Segment& segment = grid_.segments[static_cast<std::size_t>(index)];
  if (!may_meet(path, segment.a, segment.b, segment.eps)) return;
  const auto first = grid_.control.begin() + segment.control;
  budget_ = pair_budget;
  meet(path, {{first, first + segment.degree + 1}, segment.a, segment.b, segment.eps, 0, 1}, index, 0);
}

void CrossingSearch::meet(PathPiece path, CurvePiece curve, int segment, int depth) {
  if (!may_meet(path, curve.a, curve.b, curve.eps)) return;
  if (at_most_one(path, curve.control)) {
    double x = 0, s = 0;
    const Solve solved = newton(path, curve, segment, x, s);
    if (solved == Solve::found)
      candidates_.push_back({std::clamp(x, 0.0, 1.0), segment, std::clamp(s, 0.0, 1.0)});
    if (solved != Solve::failed) return;
  }
  const double path_size = (path.high() - path.low()).maxCoeff();
  const double curve_size = (curve.b - curve.a).norm() + curve.eps;
  if (path_size <= grid_.on && curve_size <= grid_.on) {
    candidates_.push_back({0.5 * (path.x0 + path.x1), segment, 0.5 * (curve.s0 + curve.s1)});
    return;
  }
  if (--budget_ < 0 || depth > 100) {
    candidates_.push_back({path.x0, -1, 0});
    candidates_.push_back({path.x1, -1, 0});
    return;
  }
  if (path_size >= curve_size) {
    meet(path.split_left(), curve, segment, depth + 1);
    meet(path, std::move(curve), segment, depth + 1);
    return;
  }
  CurvePiece left;
  left.control = bezier::split_half(curve.control);
  const Uv middle = project(left.control.back());
  left.a = curve.a;
  left.b = curve.a = middle;
  left.s0 = curve.s0;
  left.s1 = curve.s0 = 0.5 * (curve.s0 + curve.s1);
  left.eps = hull_deviation(left.control, left.a, left.b);
  curve.eps = hull_deviation(curve.control, curve.a, curve.b);
  meet(path, std::move(left), segment, depth + 1);
  meet(std::move(path), std::move(curve), segment, depth + 1);
}

CrossingSearch::Solve CrossingSearch::newton(const PathPiece& path, const CurvePiece& curve, int index,
                                             double& x, double& s) const {
  const Segment& segment = grid_.segments[static_cast<std::size_t>(index)];
  const Uv d = curve.b - curve.a;
  // Start where the chord of the path meets the chord of the curve.
  const Uv e = path.p[3] - path.p[0];
  const double area = cross(e, d);
  const Uv r = curve.a - path.p[0];
  const double dx = path.x1 - path.x0, ds = curve.s1 - curve.s0;
  x = path.x0 + dx * (area != 0 ? std::clamp(cross(r, d) / area, 0.0, 1.0) : 0.5);
  s = curve.s0 + ds * (area != 0 ? std::clamp(cross(r, e) / area, 0.0, 1.0) : 0.5);
  for (int i = 0; i < 20; ++i) {
    Uv c, cs;
    curve_at(grid_, segment, s, c, cs);
    const Uv px = path_.derivative(x);
    const Uv f = c - point(x);
    const double det = cross(px, cs);
    if (det == 0) return Solve::failed;
    const double step_x = cross(f, cs) / det;
    const double step_s = cross(f, px) / det;
    x = std::clamp(x + step_x, path.x0 - dx, path.x1 + dx);
    s = std::clamp(s + step_s, curve.s0 - ds, curve.s1 + ds);
    // Done when the residual is rounding (1e-15 of the coordinates), or the steps are.
    const bool still = std::abs(step_x) <= 4e-16 + 1e-14 * dx && std::abs(step_s) <= 4e-16 + 1e-14 * ds;
    if (still || f.norm() <= 0.01 * grid_.on) {
      // Solutions at the very ends belong to both neighbours: a little too far is accepted here
      // and the double is dropped when the candidates are grouped.
      const double slack_x = 1e-13 * dx + 4 * grid_.on / std::max(px.norm(), grid_.on);
      const double slack_s = 1e-13 * ds + 4 * grid_.on / std::max(cs.norm(), grid_.on);
      const bool inside = x >= path.x0 - slack_x && x <= path.x1 + slack_x && s >= curve.s0 - slack_s &&
                          s <= curve.s1 + slack_s;
      return inside ? Solve::found : Solve::none;
    }
    // Pinned to the border of the search: the solution, if any, lies outside.
    const bool outside_x = (x == path.x0 - dx && step_x < 0) || (x == path.x1 + dx && step_x > 0);
    const bool outside_s = (s == curve.s0 - ds && step_s < 0) || (s == curve.s1 + ds && step_s > 0);
    if (i > 6 && (outside_x || outside_s)) return Solve::failed;
  }
  return Solve::failed;
}

LoopCrossing CrossingSearch::crossing_at(const Candidate& candidate) const {
  const Segment& segment = grid_.segments[static_cast<std::size_t>(candidate.segment)];
  LoopCrossing crossing;
  crossing.x = candidate.x;
  crossing.loop = segment.loop;
  crossing.coedge = segment.coedge;
  crossing.t = parameter(segment, candidate.s);
  const Loop& loop = grid_.loops[static_cast<std::size_t>(segment.loop)];
  crossing.uv = loop.coedges[static_cast<std::size_t>(segment.coedge)].pcurve.point(crossing.t);
  return crossing;
}

LoopCrossing CrossingSearch::crossing_between(double x0, bool inside0, double x1) const {
  while (x1 - x0 > 1e-15) {
    const double middle = 0.5 * (x0 + x1);
    if (middle <= x0 || middle >= x1) break;
    (grid_.contains(point(middle)) == inside0 ? x0 : x1) = middle;
  }
  const double x = inside0 ? x0 : x1;  // the side that counts as on the loop
  LoopCrossing crossing = nearest_on_loops(grid_, point(x), Eigen::Matrix2d::Identity());
  crossing.x = x;
  return crossing;
}

namespace {

/// Branch and bound over the Bezier pieces of one segment for the point nearest to `q`, in a
/// plane mapped by `map` so that the metric there is Euclidean.
class NearestSearch {
 public:
  NearestSearch(const SegmentGrid& grid, const Uv& p, const Eigen::Matrix2d& metric)
      : grid_(grid), map_(Eigen::LLT<Eigen::Matrix2d>(metric).matrixU()), q_(map_ * p) {}

  void visit(int index) {
    const Segment& segment = grid_.segments[static_cast<std::size_t>(index)];
    if (chord_distance(q_, map_ * segment.a, map_ * segment.b) - stretch() * segment.eps >= best_) return;
    const auto first = grid_.control.begin() + segment.control;
    std::vector<Eigen::Vector3d> control(first, first + segment.degree + 1);
    for (Eigen::Vector3d& c : control) c.head<2>() = map_ * c.head<2>();
    refine(std::move(control), index, 0, 1, 0);
  }
  double best() const { return best_; }
  int segment() const { return segment_; }
  double s() const { return s_; }

 private:
  double stretch() const { return map_.norm(); }

  void offer(double s, int segment) {
    Uv c, d;
    curve_at(grid_, grid_.segments[static_cast<std::size_t>(segment)], s, c, d);
    const double distance = (map_ * c - q_).norm();
    if (distance >= best_) return;
    best_ = distance;
    segment_ = segment;
    s_ = s;
  }

  void refine(std::vector<Eigen::Vector3d> control, int segment, double s0, double s1, int depth) {
    const Uv a = project(control.front()), b = project(control.back());
    const double eps = hull_deviation(control, a, b);
    if (chord_distance(q_, a, b) - eps >= best_) return;
    offer(s0, segment);
    offer(s1, segment);
    const Uv d = b - a;
    const double dd = d.squaredNorm();
    const double along = dd > 0 ? (q_ - a).dot(d) / dd : 0;
    if (eps <= 1e-7 * std::sqrt(dd) || depth == 40) {
      newton(segment, s0, s1, along);
      return;
    }
    std::vector<Eigen::Vector3d> left = bezier::split_half(control);
    const double middle = 0.5 * (s0 + s1);
    const bool left_first = along < 0.5;
    if (left_first) refine(left, segment, s0, middle, depth + 1);
    refine(std::move(control), segment, middle, s1, depth + 1);
    if (!left_first) refine(std::move(left), segment, s0, middle, depth + 1);
  }

  void newton(int segment, double s0, double s1, double along) {
    double s = std::clamp(s0 + along * (s1 - s0), s0, s1);
    for (int i = 0; i < 12; ++i) {
      Uv c, d;
      curve_at(grid_, grid_.segments[static_cast<std::size_t>(segment)], s, c, d);
      c = map_ * c;
      d = map_ * d;
      const double dd = d.squaredNorm();
      if (dd == 0) break;
      const double next = std::clamp(s + (q_ - c).dot(d) / dd, s0, s1);
      const bool done = std::abs(next - s) <= 1e-15;
      s = next;
      if (done) break;
    }
    offer(s, segment);
  }

  const SegmentGrid& grid_;
  Eigen::Matrix2d map_;
  Uv q_;
  double best_ = std::numeric_limits<double>::infinity();
  int segment_ = -1;
  double s_ = 0;
};

}  // namespace

LoopCrossing nearest_on_loops(const SegmentGrid& grid, const Uv& p, const Eigen::Matrix2d& metric) {
  NearestSearch search(grid, p, metric);
  for (std::size_t i = 0; i < grid.segments.size(); ++i) search.visit(static_cast<int>(i));
  LoopCrossing nearest;
  if (search.segment() < 0) return nearest;
  const Segment& segment = grid.segments[static_cast<std::size_t>(search.segment())];
  nearest.loop = segment.loop;
  nearest.coedge = segment.coedge;
  nearest.t = parameter(segment, search.s());
  const Loop& loop = grid.loops[static_cast<std::size_t>(segment.loop)];
  nearest.uv = loop.coedges[static_cast<std::size_t>(segment.coedge)].pcurve.point(nearest.t);
  return nearest;
}

}  // namespace afptraj::trim
