#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "geometry/part.h"

namespace afptraj {

/// A cubic in (u, v) over x in [0, 1]: a + b x + c x^2 + d x^3. One piece of a path.
struct UvCubic {
  Uv a, b, c, d;
  /// From end points and end derivatives with respect to x (Hermite).
  static UvCubic hermite(const Uv& p0, const Uv& d0, const Uv& p1, const Uv& d1);
  static UvCubic line(const Uv& p0, const Uv& p1);
  Uv point(double x) const { return a + x * (b + x * (c + x * d)); }
  Uv derivative(double x) const { return b + x * (2 * c + x * 3 * d); }
};

/// Where a path crosses a trim loop.
struct LoopCrossing {
  double x = 0;          ///< path parameter in [0, 1]
  int loop = -1;         ///< index in Face::loops
  int coedge = -1;       ///< index in Loop::coedges
  double t = 0;          ///< parameter of the pcurve
  Uv uv = Uv::Zero();    ///< the point, on the pcurve
  bool outward = false;  ///< the path leaves the material here
};

/// The region of (u, v) inside the trim loops of a face, an immutable value.
///
/// The loops are flattened once into segments (chord error `flatten_uv`, relative to the size of
/// the loops in (u, v), or finer) kept in a grid of cells, so that a query touches the few segments
/// near it; answers are then refined on the true pcurves.
///
/// Laws, checked by tests/trim_region_test.cpp:
///   (T1) contains(p) counts crossings of a ray with the flattened loops by CGAL's exact
///        predicates: no input makes it wrong for the polygon; within the chord error of a
///        segment the true pcurve decides.
///   (T2) a crossing lies on its pcurve exactly and on the path to 1e-12 of the loop size.
///   (T3) along a path, crossings alternate between outward and inward, beginning with outward
///        when the start is inside.
class TrimRegion {
 public:
  explicit TrimRegion(const Face& face, double flatten_uv = 1e-5);

  /// Inside the material; a point on a loop counts as inside.
  bool contains(const Uv& uv) const;

  /// Of a box in (u, v): `mixed` when a loop may pass through it (a box that is not may be called mixed).
  enum class BoxState { outside, inside, mixed };
  BoxState classify(const Uv& lo, const Uv& hi) const;

  /// All crossings of the path with the loops, in order of x, found by bracketing on the
  /// segments and Newton-Raphson on path(x) = pcurve(t), with bisection as the fall-back. Crossings
  /// at x = 0 exactly are reported only if the path turns through the loop there.
  std::vector<LoopCrossing> crossings(const UvCubic& path) const;

  /// The first outward (or inward) crossing, or nothing.
  std::optional<LoopCrossing> first_crossing(const UvCubic& path, bool outward) const;

  /// The point of the loops nearest to `uv` in the metric (E, F, G) of the surface there, with
  /// x unused. For telling how far a point lies from the boundary.
  LoopCrossing nearest(const Uv& uv, const Eigen::Matrix2d& metric) const;

  /// Bounding box of the loops.
  Uv box_min() const;
  Uv box_max() const;

 private:
  struct Data;
  std::shared_ptr<const Data> data_;
};

}  // namespace afptraj
