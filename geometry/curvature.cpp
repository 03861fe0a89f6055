#include "geometry/curvature.h"

#include <cmath>

#include <Eigen/Geometry>

namespace afptraj {

FirstForm first_form(const SurfaceDerivatives& d) { return {d.Su.dot(d.Su), d.Su.dot(d.Sv), d.Sv.dot(d.Sv)}; }

Vec3 unit_normal(const SurfaceDerivatives& d) {
  const Vec3 n = d.Su.cross(d.Sv);
  const double length = n.norm();
  return length > 1e-300 ? Vec3(n / length) : Vec3(Vec3::Zero());
}

SecondForm second_form(const SurfaceDerivatives& d, const Vec3& normal) {
  return {d.Suu.dot(normal), d.Suv.dot(normal), d.Svv.dot(normal)};
}

Curvatures curvatures(const SurfaceDerivatives& d, const Vec3& normal) {
  // The shape operator in an orthonormal tangent frame (e1, e2) is symmetric: solve it there.
  Curvatures out;
  const Vec3 e1 = d.Su.normalized();
  const Vec3 e2 = normal.cross(e1);
  const Uv a = tangent_to_uv(d, e1), b = tangent_to_uv(d, e2);
  const SecondForm II = second_form(d, normal);
  const auto form = [&](const Uv& p, const Uv& q) {
    return II.L * p.x() * q.x() + II.M * (p.x() * q.y() + p.y() * q.x()) + II.N * p.y() * q.y();
  };
  const double h11 = form(a, a), h12 = form(a, b), h22 = form(b, b);
  const double mean = 0.5 * (h11 + h22);
  const double half = std::hypot(0.5 * (h11 - h22), h12);
  const double angle = 0.5 * std::atan2(2 * h12, h11 - h22);
  out.k1 = mean + half;
  out.k2 = mean - half;
  out.mean = mean;
  out.gaussian = h11 * h22 - h12 * h12;
  out.direction1 = std::cos(angle) * e1 + std::sin(angle) * e2;
  out.direction2 = normal.cross(out.direction1);
  return out;
}

double gaussian_curvature(const SurfaceDerivatives& d) {
  const Vec3 n = d.Su.cross(d.Sv);  // |n|^2 = EG - F^2, so no root is needed
  const double g = n.squaredNorm();
  if (!(g > 0)) return 0;
  const double L = d.Suu.dot(n), M = d.Suv.dot(n), N = d.Svv.dot(n);
  return (L * N - M * M) / (g * g);
}

double normal_curvature(const SurfaceDerivatives& d, const Vec3& normal, const Vec3& direction) {
  const Uv a = tangent_to_uv(d, direction);
  const SecondForm II = second_form(d, normal);
  const double length2 = uv_to_tangent(d, a).squaredNorm();
  return (II.L * a.x() * a.x() + 2 * II.M * a.x() * a.y() + II.N * a.y() * a.y()) / length2;
}

Uv tangent_to_uv(const SurfaceDerivatives& d, const Vec3& vector) {
  const FirstForm I = first_form(d);
  const double p = vector.dot(d.Su), q = vector.dot(d.Sv);
  const double det = I.E * I.G - I.F * I.F;
  return {(I.G * p - I.F * q) / det, (I.E * q - I.F * p) / det};
}

double geodesic_curvature(const SurfaceDerivatives& d, const Vec3& normal, const Uv& duv, const Uv& dduv) {
  const Vec3 velocity = uv_to_tangent(d, duv);
  const Vec3 acceleration = uv_to_tangent(d, dduv) + duv.x() * duv.x() * d.Suu +
                            2 * duv.x() * duv.y() * d.Suv + duv.y() * duv.y() * d.Svv;
  const double speed = velocity.norm();
  return velocity.cross(acceleration).dot(normal) / (speed * speed * speed);
}

}  // namespace afptraj
