#include "geometry/part.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace afptraj {
namespace {

/// Points closer than this share of the face's size are one point: far above rounding, far below
/// anything a machine lays.
constexpr double same_point = 1e-11;

/// Sides in the order v = lo, u = hi, v = hi, u = lo. All run from low to high, so that opposite
/// sides of a seam agree in their parameter; the last two are used backwards.
struct Side {
  Uv from, to;
  bool along_u;
  bool reversed;
  BSplineCurve2 curve() const {
    const int axis = along_u ? 0 : 1;
    return line_segment(from, to, from[axis], to[axis]);
  }
};

std::array<Side, 4> sides_of(const Interval& u, const Interval& v) {
  const Uv a(u.lo, v.lo), b(u.hi, v.lo), c(u.hi, v.hi), d(u.lo, v.hi);
  return {{{a, b, true, false}, {b, c, false, false}, {d, c, true, true}, {a, d, false, true}}};
}

std::vector<Vec3> sample(const Surface& surface, const Side& side) {
  constexpr int count = 33;
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const double x = static_cast<double>(i) / (count - 1);
    points.push_back(surface.point(side.from + x * (side.to - side.from)));
  }
  return points;
}

double extent(const std::vector<Vec3>& points) {
  double most = 0;
  for (const Vec3& p : points) most = std::max(most, (p - points.front()).norm());
  return most;
}

double greatest_distance(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, (a[i] - b[i]).norm());
  return most;
}

void require_finite(const Interval& u, const Interval& v) {
  const bool finite =
      std::isfinite(u.lo) && std::isfinite(u.hi) && std::isfinite(v.lo) && std::isfinite(v.hi);
  if (!finite || !(u.lo < u.hi) || !(v.lo < v.hi)) {
    throw std::invalid_argument("make_rectangular_face: needs finite intervals with lo < hi");
  }
}

}  // namespace

RectangularFace make_rectangular_face(const Surface& surface, const Interval& u, const Interval& v,
                                      int first_edge) {
  require_finite(u, v);
  const std::array<Side, 4> sides = sides_of(u, v);
  std::array<std::vector<Vec3>, 4> points;
  double size = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    points[i] = sample(surface, sides[i]);
    size = std::max({size, extent(points[i]), (points[i].front() - points[0].front()).norm()});
  }
  const double tolerance = same_point * size;

  RectangularFace result{Face{surface, false, {}, {}, {}, 0}, {}};
  Loop loop;
  std::array<int, 4> edge{};
  for (std::size_t i = 0; i < 4; ++i) {
    const bool degenerate = extent(points[i]) <= tolerance;
    // A side that coincides with the opposite one (a whole period, or a spline that closes on
    // itself) is the second use of that side's edge.
    const bool seam = i >= 2 && !degenerate && greatest_distance(points[i], points[i - 2]) <= tolerance;
    if (seam) {
      edge[i] = edge[i - 2];
    } else {
      edge[i] = first_edge + static_cast<int>(result.edges.size());
      result.edges.push_back(Edge{degenerate, 0});
    }
    loop.coedges.push_back(Coedge{sides[i].curve(), sides[i].reversed, edge[i]});
  }
  result.face.loops.push_back(std::move(loop));
  return result;
}

Part make_rectangular_part(const Surface& surface, const Interval& u, const Interval& v) {
  RectangularFace one = make_rectangular_face(surface, u, v);
  Part part;
  part.faces.push_back(std::move(one.face));
  part.edges = std::move(one.edges);
  return part;
}

}  // namespace afptraj
