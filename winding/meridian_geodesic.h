#pragma once

#include <vector>

#include "winding/meridian.h"

namespace afptraj {

/// Where a geodesic's pass along a mandrel ends.
struct PassEnd {
  double t = 0;  ///< of the meridian
  double z_mm = 0, r_mm = 0;
  /// The fibre turns back there, at the polar opening r = K. Otherwise the mandrel ends before: its
  /// opening is wider than K, and the fibre runs off.
  bool turns = false;
};

struct FibrePoint {
  double t = 0, z_mm = 0, r_mm = 0;
  double turn_rad = 0;   ///< of the mandrel, from the pass's first end
  double length_mm = 0;  ///< of the fibre, from there
  double angle_rad = 0;  ///< winding angle: sin = K / r
};

/// The geodesic of Clairaut's constant K on a mandrel, through a place of its meridian, from end to end:
///   r sin(alpha) = K
///   d theta / d sigma = K / (r sqrt(r^2 - K^2)),   d s / d sigma = r / sqrt(r^2 - K^2),   sigma: way along m
/// Both grow beyond bounds where the fibre turns; with t = (a + b)/2 - (b - a)/2 cos(phi) between the ends a
/// and b their integrals have smooth integrands, and are taken from knot to knot.
///
/// Laws, checked by tests/meridian_geodesic_test.cpp, to 1e-9:
///   (M1) On a sphere a pass from turn to turn is half a great circle: turn pi, length pi R.
///   (M2) On a cylinder with hemispheres the turn is pi + L tan(alpha) / R.
///   (M3) On a cone it is that of ConeGeodesic.
///   (M4) Elsewhere it is what an integrator of the geodesic's equation on the surface finds.
///   (M5) On a cylinder with ellipsoids and (M6) on an isotensoid it is the elliptic integral of each.
/// Source: do Carmo, ch. 4.4, ex. 1; Koussios, Filament Winding: a Unified Approach (2004), ch. 3.
class MeridianGeodesic {
 public:
  /// REQUIRES: 0 < K < r at `through`.
  MeridianGeodesic(const Meridian& meridian, double clairaut_mm, double through);

  double clairaut_mm() const { return K_; }
  const PassEnd& first() const { return first_; }
  const PassEnd& last() const { return last_; }
  double turn_rad() const { return turn_rad_; }    ///< of the mandrel over the pass
  double length_mm() const { return length_mm_; }  ///< of the fibre
  /// The pass in `count` + 1 points, closer where it turns.
  std::vector<FibrePoint> points(int count) const;

  /// A place of the pass: phi grows from 0 to pi along it, t = (a + b)/2 - (b - a)/2 cos(phi).
  struct Phase {
    double phi = 0, t = 0;
  };
  /// `count` + 1 even phases, and those of the meridian's breaks, with their very parameters.
  std::vector<Phase> phases_and_breaks(int count) const;
  Phase between(const Phase& a, const Phase& b) const;
  /// The first counts as the pass's first end. REQUIRES: growing.
  std::vector<FibrePoint> points_at(const std::vector<Phase>& phases) const;
  /// The place at a phase, counted on from the one at an earlier phase.
  FibrePoint next_point(const FibrePoint& before, const Phase& from, const Phase& to) const;

 private:
  enum class Quantity { turn, length };
  FibrePoint place(const Phase& phase) const;
  double over(Quantity quantity, double phi0, double phi1) const;
  double rate(Quantity quantity, double phi) const;
  double above_clairaut(double phi, const MeridianPoint& at) const;
  double smooth_way(bool near_first) const;
  double parameter(double phi) const;
  double phase(double t) const;
  PassEnd end_of(double from, bool forward) const;

  const Meridian& meridian_;
  double K_;
  PassEnd first_, last_;
  double turn_rad_ = 0, length_mm_ = 0;
};

}  // namespace afptraj
