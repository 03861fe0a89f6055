#pragma once

#include "geometry/surface.h"

namespace afptraj {

/// First fundamental form: E = Su.Su, F = Su.Sv, G = Sv.Sv. Source: do Carmo, ch. 2.5.
struct FirstForm {
  double E, F, G;
  Eigen::Matrix2d matrix() const { return (Eigen::Matrix2d() << E, F, F, G).finished(); }
};
/// Second fundamental form with respect to the unit normal: L = Suu.n ... Source: do Carmo, ch. 3.2.
struct SecondForm {
  double L, M, N;
};

FirstForm first_form(const SurfaceDerivatives& d);
/// Su x Sv normalised; zero where the surface is singular (a pole).
Vec3 unit_normal(const SurfaceDerivatives& d);
SecondForm second_form(const SurfaceDerivatives& d, const Vec3& normal);

/// Principal curvatures kappa_1 >= kappa_2, their unit directions in space, mean H = (k1 + k2)/2 and
/// Gaussian K = k1 k2, with respect to `normal` (positive: bends toward it).
struct Curvatures {
  double k1 = 0, k2 = 0, mean = 0, gaussian = 0;
  Vec3 direction1 = Vec3::Zero(), direction2 = Vec3::Zero();
};
Curvatures curvatures(const SurfaceDerivatives& d, const Vec3& normal);
double gaussian_curvature(const SurfaceDerivatives& d);

/// kappa_n = II(t, t) / I(t, t) in the tangent direction `direction` (any length, projected).
double normal_curvature(const SurfaceDerivatives& d, const Vec3& normal, const Vec3& direction);

/// The (u', v') of a vector of space in the tangent plane (its normal part is dropped).
Uv tangent_to_uv(const SurfaceDerivatives& d, const Vec3& vector);
/// The vector u' Su + v' Sv.
inline Vec3 uv_to_tangent(const SurfaceDerivatives& d, const Uv& duv) { return duv.x() * d.Su + duv.y() * d.Sv; }

/// kappa_g of the curve with (u', v') and (u'', v''), any parametrisation; positive when it turns
/// toward b = n x t. Source: do Carmo, ch. 4.4.
double geodesic_curvature(const SurfaceDerivatives& d, const Vec3& normal, const Uv& duv, const Uv& dduv);

}  // namespace afptraj
