#include "geometry/section_march.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/curvature.h"

namespace afptraj::sections {
namespace {

/// Sine of the angle between surface and plane below which they count as touching.
constexpr double touching = 1e-9;

/// Second-order terms up to this are followed by Taylor's formula: the third is smaller by the
/// ratio of the step to the size of the surface's waves, 1e-4 mm to many.
constexpr double second_order_mm = 1e-10;

}  // namespace

March::March(const Skin& skin, const Plane& plane) : skin_(skin), plane_(plane) {
  // A few ulp of the greatest coordinates that points are computed from.
  const double reach = std::max({skin.box_min().cwiseAbs().maxCoeff(), skin.box_max().cwiseAbs().maxCoeff(),
                                 plane.origin.cwiseAbs().maxCoeff()});
  rounding_ = 1e-15 * reach + 1e-300;
}

Vec3 March::tangent(const SurfaceDerivatives& d, double sense) const {
  const Vec3 normal = d.Su.cross(d.Sv);
  const Vec3 along = normal.cross(plane_.normal);
  const double sine = along.norm();
  // The sine of the angle between surface and plane, times |Su x Sv|.
  if (!(sine > touching * normal.norm())) return Vec3::Zero();
  return along * (sense / sine);
}

std::optional<MarchPoint> March::at(int face, const Uv& uv, double sense) const {
  return at(face, uv, skin_.face(face).surface.derivatives(uv), sense);
}

std::optional<MarchPoint> March::at(int face, const Uv& uv, const SurfaceDerivatives& d, double sense) const {
  MarchPoint m;
  m.face = face;
  m.uv = uv;
  m.d = d;
  m.tangent = tangent(d, sense);
  if (m.tangent.isZero(0)) return std::nullopt;
  m.velocity = tangent_to_uv(d, m.tangent);
  const double u1 = m.velocity.x(), v1 = m.velocity.y();
  const Vec3 quadratic = d.Suu * (u1 * u1) + d.Suv * (2 * u1 * v1) + d.Svv * (v1 * v1);
  // The curvature vector lies in the plane, across the tangent; its part along n is II(t, t).
  const Vec3 n = d.Su.cross(d.Sv);
  const Vec3 across = plane_.normal.cross(m.tangent);
  m.bend = across * (quadratic.dot(n) / across.dot(n));
  m.kappa = m.bend.norm();
  m.acceleration = tangent_to_uv(d, m.bend - quadratic);
  if (!m.velocity.allFinite() || !m.acceleration.allFinite()) return std::nullopt;
  return m;
}

double March::sense_toward(int face, const Uv& uv, const Vec3& heading) const {
  const Vec3 n = unit_normal(skin_.face(face).surface.derivatives(uv));
  return n.cross(plane_.normal).dot(heading) >= 0 ? 1 : -1;
}

std::optional<Uv> March::onto_plane(int face, Uv uv) const {
  const Surface& surface = skin_.face(face).surface;
  for (int i = 0; i < 20; ++i) {
    const SurfaceDerivatives d = surface.derivatives(uv);
    const double h = height(d.S);
    if (std::abs(h) <= rounding_) return uv;
    // Straight down the slope of the height on the surface.
    const Uv slope = tangent_to_uv(d, plane_.normal);
    const double rate = plane_.normal.dot(uv_to_tangent(d, slope));
    if (!(rate > touching * touching)) return std::nullopt;
    const Uv step = slope * (-h / rate);
    if (!step.allFinite()) return std::nullopt;
    uv += step;
    if (step.norm() <= 4e-16 * uv.norm()) return uv;
  }
  return std::nullopt;
}

bool March::solve(const MarchPoint& from, double h, Uv& uv, SurfaceDerivatives& d) const {
  const Surface& surface = skin_.face(from.face).surface;
  const auto newton = [&] {
    const double e1 = height(d.S);
    const double e2 = from.tangent.dot(d.S - from.d.S) - h;
    const double a = plane_.normal.dot(d.Su), b = plane_.normal.dot(d.Sv);
    const double c = from.tangent.dot(d.Su), e = from.tangent.dot(d.Sv);
    const double det = a * e - b * c;
    return Uv((b * e2 - e * e1) / det, (c * e1 - a * e2) / det);
  };
  for (int i = 0; i < 12; ++i) {
    d = surface.derivatives(uv);
    const Uv step = newton();
    if (!step.allFinite()) return false;
    uv += step;
    const Vec3 du = d.Suu * step.x() + d.Suv * step.y(), dv = d.Suv * step.x() + d.Svv * step.y();
    const Vec3 second = 0.5 * (du * step.x() + dv * step.y());
    if (second.norm() > second_order_mm) continue;
    // So short a step needs no evaluation: Taylor's next term is below rounding. What the second
    // order leaves over is taken away by one more step.
    d.S += uv_to_tangent(d, step) + second;
    d.Su += du;
    d.Sv += dv;
    const Uv last = newton();
    uv += last;
    d.S += uv_to_tangent(d, last);
    return true;
  }
  return false;
}

std::optional<MarchPoint> March::advance(const MarchPoint& from, double h, double sense,
                                         const Uv& guess) const {
  Uv uv = guess;
  SurfaceDerivatives d;
  if (!solve(from, h, uv, d)) return std::nullopt;
  std::optional<MarchPoint> to = at(from.face, uv, d, sense);
  // A step that turns by more than 60 degrees has left the branch.
  if (to && to->tangent.dot(from.tangent) < 0.5) return std::nullopt;
  return to;
}

std::optional<March::Step> March::step_to(const MarchPoint& from, const MarchPoint& to, double sense) const {
  const double h = from.tangent.dot(to.d.S - from.d.S);
  const double cosine = to.tangent.dot(from.tangent);
  if (!(h > 0) || !(cosine > 0.5)) return std::nullopt;
  // ds = dx / (t . t0) with x along the first tangent. Simpson's rule and the trapezoid corrected by
  // the slopes at its ends have errors -1 : 4, so that (4 S + H) / 5 is of sixth order.
  const double chord = (to.d.S - from.d.S).norm();
  const Uv between = 0.5 * (from.uv + to.uv) + (chord / 8) * (from.velocity - to.velocity);
  Uv middle = between;
  SurfaceDerivatives dm;
  if (!solve(from, 0.5 * h, middle, dm)) return std::nullopt;
  const double cosine_middle = tangent(dm, sense).dot(from.tangent);
  if (!(cosine_middle > 0.5)) return std::nullopt;
  const double f1 = 1 / cosine, fm = 1 / cosine_middle;
  const double slope1 = -to.bend.dot(from.tangent) * f1 * f1 * f1;
  const double simpson = h / 6 * (1 + 4 * fm + f1);
  const double hermite = h / 2 * (1 + f1) - h * h / 12 * slope1;
  Step s{to, (4 * simpson + hermite) / 5, 0, {}};
  const double turn = h * std::max(from.kappa, to.kappa);
  const double sharpen = std::min(1.0, 0.25 * turn * turn + h * (to.bend - from.bend).norm());
  s.error = std::abs(simpson - hermite) / 5 * sharpen;
  s.path = UvCubic::hermite(from.uv, s.length * from.velocity, to.uv, s.length * to.velocity);
  // The cubic stands for the step where loops are looked for: it must run along the section.
  const Uv off = s.path.point(0.5) - middle;
  if (uv_to_tangent(dm, off).norm() > 1e-2 * h) return std::nullopt;
  return s;
}

std::optional<March::Step> March::step(const MarchPoint& from, double h, double sense) const {
  const Uv guess = from.uv + h * from.velocity + 0.5 * h * h * from.acceleration;
  const std::optional<MarchPoint> to = advance(from, h, sense, guess);
  if (!to) return std::nullopt;
  return step_to(from, *to, sense);
}

}  // namespace afptraj::sections
