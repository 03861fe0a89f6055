#pragma once

#include <optional>
#include <vector>

#include "geometry/geodesic.h"
#include "geometry/skin.h"

namespace afptraj {

/// A node of a curve on a skin. `t` is the curve's parameter (near arc length, mm), `duv` the
/// derivative of (u, v) by t.
struct CurveNode {
  double t = 0;
  SurfacePoint at;
  Uv duv = Uv::Zero();
  double kg_per_mm = 0;  ///< geodesic curvature, positive to the left of the carried normal
  int normal_sign = 1;   ///< the carried normal is this times the face's
};

/// A point of a curve with its Darboux frame and the speed ds/dt.
struct CurveFrame {
  SurfacePoint at;
  PathFrame frame;
  int normal_sign = 1;
  double speed = 1;
  double kg_per_mm = 0;
};

/// A curve on a skin: cubic Hermite in (u, v) between nodes on one face. `pieces` are charts in
/// order: at the end of one and the start of the next lies the same point, on the two faces (or
/// sides of a seam) that meet there. Between smooth nodes the error is O(spacing^4).
struct SurfaceCurve {
  std::vector<std::vector<CurveNode>> pieces;
  bool closed = false;

  bool empty() const { return pieces.empty(); }
  double first() const { return pieces.front().front().t; }
  double last() const { return pieces.back().back().t; }
};

/// Where a step in (u, v) from `a` to `b` passes a line of the surface's parametrisation that is only
/// continuous: x in (0, 1) along the straight step, and the line. Ends on the line do not count.
struct CreaseCrossing {
  double x = 0;
  int axis = 0;      ///< 0: a line u = value, 1: v = value
  double value = 0;
};
std::optional<CreaseCrossing> crease_between(const Surface& surface, const Uv& a, const Uv& b);
/// Whether a point lies on such a line.
bool on_crease(const Surface& surface, const Uv& uv);

/// The cubic between nodes `i` and `i + 1` of a piece, over x in [0, 1].
UvCubic cubic(const std::vector<CurveNode>& piece, std::size_t i);

/// The frame at x between nodes i and i + 1; kg is interpolated from the nodes.
CurveFrame frame_at(const Skin& skin, const std::vector<CurveNode>& piece, std::size_t i, double x);

/// The frame at parameter t, clamped to the curve.
CurveFrame frame_at(const Skin& skin, const SurfaceCurve& curve, double t);

/// Arc length of the cubic from x0 to x1 (Gauss-Legendre with 5 points, order 10).
double arc_length(const Skin& skin, const std::vector<CurveNode>& piece, std::size_t i, double x0, double x1);

/// The foot of the geodesic that meets `curve` at a right angle and passes `p`.
struct GeodesicFoot {
  double t = 0;            ///< curve parameter of the foot
  double distance_mm = 0;  ///< positive: p lies to the left of the curve
  double miss_mm = 0;      ///< how far from p the geodesic ends (solver's residual)
};

/// Solves exp(curve(t), d) = p by Newton-Raphson with the Jacobi field as the Jacobian, from
/// t = `t_seed` and the chord. Nothing when it does not converge to `tolerance_mm` within the
/// curve (`slack_mm` beyond its ends is allowed), or when the geodesic leaves the skin.
std::optional<GeodesicFoot> geodesic_foot(const GeodesicTracer& tracer, const SurfaceCurve& curve, double t_seed,
                                          const Vec3& p, double tolerance_mm = 1e-8, double slack_mm = 0);

}  // namespace afptraj
