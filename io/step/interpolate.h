#pragma once

#include <functional>
#include <vector>

#include "geometry/bspline_curve.h"
#include "geometry/surface.h"

namespace afptraj::step {

/// A surface or curve known by its points becomes a piecewise polynomial B-spline in the same
/// parametrisation: in every cell the tensor-product interpolant at Chebyshev-Lobatto nodes of
/// degree (9, 9), or less where less is exact. Cells end at `breaks` (where the function is not
/// smooth) and are halved until the error, sampled between the nodes, is within `tolerance`.
/// Knots inside have multiplicity degree: values join to rounding, derivatives to the error.
/// Source: Trefethen, Approximation Theory and Approximation Practice, ch. 8 (geometric
/// convergence for analytic functions).
inline constexpr int interpolation_degree = 9;

struct SurfaceInterpolation {
  BSplineSurface spline;
  double error = 0;  ///< greatest sampled distance; above `tolerance` only when `max_cells` was reached
};
SurfaceInterpolation interpolate_surface(const std::function<Vec3(double, double)>& point,
                                         std::vector<double> breaks_u, std::vector<double> breaks_v,
                                         double tolerance, int max_cells = 20000);

struct CurveInterpolation {
  BSplineCurve2 curve;
  double error = 0;
};
/// `tolerance(t0, t1)` is the one for a cell.
CurveInterpolation interpolate_curve(const std::function<Uv(double)>& point, std::vector<double> breaks,
                                     const std::function<double(double, double)>& tolerance,
                                     int max_cells = 2000);

}  // namespace afptraj::step
