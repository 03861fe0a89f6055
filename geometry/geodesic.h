#pragma once

#include <limits>

#include "geometry/poles.h"
#include "geometry/skin.h"

namespace afptraj {

/// A geodesic on its way, parametrised by arc length, with the Jacobi field y of the family it
/// belongs to: y'' + K y = 0. For rays that leave a curve orthogonally, y ds is the arc length of
/// the offset curve, y'/y its curvature, and y = 0 a focal point.
struct GeodesicState {
  SurfacePoint at;
  Uv duv = Uv::Zero();   ///< derivative of (u, v) by arc length: |u' Su + v' Sv| = 1
  double y = 1, dy = 0;  ///< Jacobi field and its derivative by arc length
  double s_mm = 0;       ///< arc length walked
  int normal_sign = 1;   ///< the normal carried along is normal_sign times the face's
  bool outside = false;  ///< beyond a free edge, on the continuation of the face's surface
  bool in_hole = false;  ///< outside, within an inner loop of the face
  double outside_mm = 0; ///< arc length since it left the material
  double step_mm = 0;    ///< last step, a first guess for the next
};

enum class TraceEnd {
  reached,   ///< walked the whole length
  left,      ///< went beyond the skin farther than the options allow
  singular,  ///< ran into a point without a tangent plane (the apex of a cone), or a surface that degenerates
};

struct GeodesicOptions {
  /// Bounds the local error of a step in position (mm), direction (times the step, or 2 % of the
  /// skin's diagonal) and y. The global error over 1 m was at most 6 times this on all test surfaces.
  double tolerance_mm = 1e-10;
  /// How far a geodesic follows the face's own surface beyond a free edge of its outer loop, and
  /// how far it follows the linear continuation beyond the natural domain or beside other faces.
  double outside_limit_mm = 0;
  double margin_mm = 0;
};

/// Traces geodesics over the faces of a skin: the exponential map.
///
/// Integrates u'' + Gamma(u', u') = 0 and the Jacobi field in (u, v) with Dormand-Prince 8(5,3), one
/// polynomial piece at a time: a step ends on the knot line it would cross, so derivative jumps do
/// not spoil the order; the tangent is then re-expressed on the next piece. At a shared edge or
/// seam it goes on in the neighbour by the straightest continuation (the tangent keeps its angle to
/// the edge). At a smooth pole it crosses in space; at a cone's apex it ends. Holes are crossed on
/// the surface that was trimmed away.
///
/// Laws, checked by tests/geodesic_test.cpp:
///   (G1) cylinder: a helix of constant slope; cone: a straight line of the unrolled cone; sphere: a
///        great circle; torus: Clairaut's r sin(alpha) = const; to 1e-9 mm over 1 m.
///   (G2) a step has order 8; the error falls with the tolerance.
///   (G3) walking back from the end gives the start.
///   (G4) y = cos(s/R) on a sphere, 1 on a developable; equal to the distance of neighbouring rays.
/// Sources: do Carmo, ch. 4.4 and 5.5; Hairer, Norsett & Wanner, Solving ODEs I, II.4 and II.5.
class GeodesicTracer {
 public:
  GeodesicTracer(const Skin& skin, const GeodesicOptions& options);

  /// A geodesic from `at` along the part of `direction` in the tangent plane. `normal_sign` as in the state.
  GeodesicState start(const SurfacePoint& at, const Vec3& direction, int normal_sign = 1, double y = 1,
                      double dy = 0, bool outside = false) const;

  /// Walks on by `length` mm.
  TraceEnd advance(GeodesicState& state, double length) const;

  const Skin& skin() const { return *skin_; }
  const GeodesicOptions& options() const { return options_; }

 private:
  struct Here;  // derivatives and slope at a state, on its piece
  Here look(const GeodesicState& state, const Span& span) const;
  bool integrate(GeodesicState& state, const Here& here, const Span& span, double h, double* error) const;
  bool shift(GeodesicState& state, const Here& here, const Span& span, double by, double scale) const;
  double way_to_box(const GeodesicState& state, const Here& here, const Uv& lo, const Uv& hi) const;
  void land_on_box(GeodesicState& state, const GeodesicState& from, const Here& start, const Span& span,
                   double longest, double& h) const;
  bool cross_knot(GeodesicState& state, Span& span) const;
  enum class Crossing { none, moved, left, singular };
  Crossing cross_loops(GeodesicState& state, const GeodesicState& from, const Here& start, Span& span,
                       double& h) const;
  Crossing enter_mate(GeodesicState& state, const EdgeUse& use, double t) const;
  void wrap_outside(GeodesicState& state, Span& span) const;
  void settle_outside(GeodesicState& state, Span& span) const;
  bool relocate(GeodesicState& state) const;
  bool beside_hole(const GeodesicState& state) const;
  Crossing hop_pole(GeodesicState& state, const Pole& pole, double& walked) const;
  const Pole* approached_pole(const GeodesicState& state, const SurfaceDerivatives& d, double& distance,
                              double& miss) const;
  double longest_outside(const GeodesicState& state, const Span& span) const;

  const Skin* skin_;
  GeodesicOptions options_;
  std::vector<std::vector<Pole>> poles_;  // by face
  double pole_radius_mm_, lever_mm_;
};

/// Position, unit tangent and unit normal (with its sign) of a state.
struct PathFrame {
  Vec3 position, tangent, normal;
  Vec3 left() const { return normal.cross(tangent); }
};
PathFrame frame_of(const Skin& skin, const GeodesicState& state);

/// The straightest continuation over a fold: keeps the component along the unit `edge` and turns
/// the rest from the plane with normal `n_from` into the one with `n_to`.
Vec3 turn_across(const Vec3& tangent, const Vec3& edge, const Vec3& n_from, const Vec3& n_to);

}  // namespace afptraj
