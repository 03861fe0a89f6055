#pragma once

#include "winding/wind_definition.h"

namespace afptraj {

/// The geodesic on a cone that leaves its large end (z = 0, radius r0) at the winding angle alpha:
///   r(z) sin a(z) = K = r0 sin alpha                                   (Clairaut)
///   theta(z) = (acos(K / r0) - acos(K / r(z))) / sin phi,  tan phi = (r0 - r1) / L
class ConeGeodesic {
 public:
  /// REQUIRES: mandrel.is_cone(), r1 < r0.
  ConeGeodesic(const WindMandrel& mandrel, double angle_deg);

  double turn_deg(double z_mm) const;   ///< theta, from z = 0
  double angle_deg(double z_mm) const;  ///< winding angle there
  double clairaut_mm() const { return K_; }

 private:
  double radius(double z_mm) const;
  double r0_, r1_, length_, K_, sin_phi_;
};

/// Angles as the program's arithmetic has them: one multiplication.
double radians(double degrees);
double degrees(double radians);

}  // namespace afptraj
