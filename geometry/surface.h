#pragma once

#include <memory>
#include <vector>

#include "geometry/types.h"

namespace afptraj {

/// A point of a surface and its partial derivatives up to second order, mm per parameter unit.
struct SurfaceDerivatives {
  Vec3 S, Su, Sv, Suu, Suv, Svv;
};

enum class SurfaceKind { plane, cylinder, cone, sphere, torus, bspline };

/// Name for people: "plane", "B-spline" ...
const char* to_string(SurfaceKind kind);

/// A tensor-product B-spline as files give it. Knots are flat (repeated) and clamped; poles run
/// with v fastest: poles[i * count_v() + j]. `weights` is empty for a non-rational surface.
/// A periodic direction is given clamped over one period and flagged; evaluation wraps it.
struct BSplineSurface {
  int degree_u = 1, degree_v = 1;
  std::vector<double> knots_u, knots_v;
  std::vector<Vec3> poles;
  std::vector<double> weights;
  bool periodic_u = false, periodic_v = false;

  int count_u() const { return static_cast<int>(knots_u.size()) - degree_u - 1; }
  int count_v() const { return static_cast<int>(knots_v.size()) - degree_v - 1; }
};

/// One polynomial (or rational) piece of a surface: the indices of its knot span, and the number
/// of periods by which (u, v) lies beyond the base period. Spans -1 and n are the linear
/// continuation beyond a non-periodic end. Analytic surfaces have the single span {0, 0}.
struct Span {
  int iu = 0, iv = 0;
  double shift_u = 0, shift_v = 0;
  bool operator==(const Span&) const = default;
};

/// A surface, an immutable value (copies share the data).
///
/// Analytic kinds use the parametrisations of ISO 10303-42 with the frame (O; x, y, z):
///   plane     O + u x + v y
///   cylinder  O + R (cos u x + sin u y) + v z
///   cone      O + (R + v sin a)(cos u x + sin u y) + v cos a z
///   sphere    O + R cos v (cos u x + sin u y) + R sin v z
///   torus     O + (R + r cos v)(cos u x + sin u y) + r sin v z
///
/// B-splines are held as one polynomial piece per pair of knot spans, extracted once. Beyond a
/// non-periodic end of the domain the surface continues linearly (tangent, C1): far enough to
/// solve for crossings at the edge, not a place to plan on.
class Surface {
 public:
  static Surface plane(const Frame& frame);
  static Surface cylinder(const Frame& frame, double radius);
  static Surface cone(const Frame& frame, double radius, double half_angle_rad);
  static Surface sphere(const Frame& frame, double radius);
  static Surface torus(const Frame& frame, double major_radius, double minor_radius);
  /// Throws std::invalid_argument when the sizes, knots or weights do not fit together.
  static Surface bspline(BSplineSurface spline);

  SurfaceKind kind() const;
  /// The natural domain; infinite for the open directions of analytic kinds.
  Interval domain_u() const;
  Interval domain_v() const;
  /// The period, 0 where the direction is not periodic.
  double period_u() const;
  double period_v() const;

  Vec3 point(const Uv& uv) const;
  SurfaceDerivatives derivatives(const Uv& uv) const;

  /// The piece that (u, v) lies on; at a knot the piece on the side of `heading` (zero: the upper).
  Span span_at(const Uv& uv, const Uv& heading = Uv::Zero()) const;
  /// The box of a piece in (u, v), infinite where the piece is.
  void span_box(const Span& span, Uv& lo, Uv& hi) const;
  /// Evaluates the polynomial of `span`, also outside of its box: the analytic continuation that
  /// an integrator needs to step up to a knot with full order.
  SurfaceDerivatives derivatives(const Span& span, const Uv& uv) const;

  /// Distinct knots of the domain, ends included; empty for a direction without knots.
  const std::vector<double>& breaks_u() const;
  const std::vector<double>& breaks_v() const;

  /// Inner knots where the parametrisation is only continuous (multiplicity >= degree): a curve that is
  /// smooth in space may have a corner in (u, v) there.
  const std::vector<double>& creases_u() const;
  const std::vector<double>& creases_v() const;

  /// The data of a B-spline, null for analytic kinds.
  const BSplineSurface* spline() const;
  /// Frame and radii of an analytic kind (cone: R and half angle; torus: R and r).
  const Frame& frame() const;
  double radius() const;
  double second_parameter() const;

 private:
  struct Data;
  explicit Surface(std::shared_ptr<const Data> data) : data_(std::move(data)) {}
  std::shared_ptr<const Data> data_;
};

}  // namespace afptraj
