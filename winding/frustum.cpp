#include "winding/frustum.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace afptraj {

double radians(double degrees) { return degrees * (std::numbers::pi / 180); }
double degrees(double radians) { return radians * (180 / std::numbers::pi); }

ConeGeodesic::ConeGeodesic(const WindMandrel& mandrel, double angle_deg)
    : r0_(mandrel.diameter_mm / 2),
      r1_(*mandrel.end_diameter_mm / 2),
      length_(mandrel.length_mm),
      K_(r0_ * std::sin(radians(angle_deg))),
      sin_phi_(std::sin(std::atan((r0_ - r1_) / length_))) {}

// z / L first: the last digit of a program depends on it.
double ConeGeodesic::radius(double z_mm) const { return r0_ + (r1_ - r0_) * (z_mm / length_); }

double ConeGeodesic::turn_deg(double z_mm) const {
  return degrees((std::acos(K_ / r0_) - std::acos(std::min(1.0, K_ / radius(z_mm)))) / sin_phi_);
}

double ConeGeodesic::angle_deg(double z_mm) const {
  return degrees(std::asin(std::min(1.0, K_ / radius(z_mm))));
}

}  // namespace afptraj
