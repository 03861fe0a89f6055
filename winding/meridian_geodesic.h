#pragma once

#include "winding/fibre_pass.h"

namespace afptraj {

/// The geodesic of Clairaut's constant K on a mandrel, through a place of its meridian, from end to end: a
/// pass whose r sin(alpha) = K all along.
///
/// Laws, checked by tests/meridian_geodesic_test.cpp, to 1e-9:
///   (M1) On a sphere a pass from turn to turn is half a great circle: turn pi, length pi R.
///   (M2) On a cylinder with hemispheres the turn is pi + L tan(alpha) / R.
///   (M3) On a cone it is that of ConeGeodesic.
///   (M4) Elsewhere it is what an integrator of the geodesic's equation on the surface finds.
///   (M5) On a cylinder with ellipsoids and (M6) on an isotensoid it is the elliptic integral of each.
/// Source: do Carmo, ch. 4.4, ex. 1; Koussios, Filament Winding: a Unified Approach (2004), ch. 3.
class MeridianGeodesic : public FibrePass {
 public:
  /// REQUIRES: 0 < K < r at `through`.
  MeridianGeodesic(const Meridian& meridian, double clairaut_mm, double through)
      : FibrePass(meridian, clairaut_mm, through, {}, {}) {}

  double clairaut_mm() const { return clairaut_at(first().t); }
};

}  // namespace afptraj
