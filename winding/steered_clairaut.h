#pragma once

#include <array>
#include <vector>

#include "winding/meridian.h"

namespace afptraj {

/// A way along a meridian on which steering is integrated, with what that needs of the mandrel.
class SteeringGrid {
 public:
  /// From `from_t` to `to_t`, either way; they differ. At least `blocks` of three steps each over the whole
  /// way; no step crosses a place where the meridian's polynomials meet.
  SteeringGrid(const Meridian& meridian, double from_t, double to_t, int blocks = 32);

  /// At one place: dq/dt = ratio (a + b q^2).
  struct Rate {
    double a = 0, b = 0;
  };
  struct Step {
    double t = 0, width = 0;  ///< width has the direction's sign
    Rate start, middle, end;
    double end_r_mm = 0;
  };
  const std::vector<Step>& steps() const { return steps_; }
  bool forward() const { return forward_; }

 private:
  bool forward_;
  std::vector<Step> steps_;
};

/// q = r sin(alpha) along a fibre that is steered with a constant ratio lambda of its geodesic to its normal
/// curvature. With
///   kappa_n = kappa_m cos^2(alpha) + (z' / r) sin^2(alpha),   kappa_m the meridian's curvature,
/// and sigma the way along the meridian, the geodesic curvature lambda kappa_n makes
///   dq / d sigma = lambda r kappa_n = lambda (kappa_m (r - q^2 / r) + z' q^2 / r^2),
/// a Riccati equation, smooth also where the fibre turns (q = r). It is integrated by Runge-Kutta's method of
/// fourth order; between its steps q is the polynomial of degree 7 through values and slopes of three steps.
///
/// A thread stays where its friction is at least |lambda|. With lambda > 0, q grows towards larger t.
///
/// Laws, checked by tests/fibre_pass_test.cpp:
///   (S1) On a cylinder 1 / sin(alpha) falls by lambda z / R over a way z.
///   (S2) On a cone 1 / q - lambda (z' / r') / r stays.
///   (S3) lambda = 0 keeps q: Clairaut's relation.
///   (S4) The error falls with the fourth power of the step.
///   (S5) It is the curve of that curvature on the surface, integrated by its own length.
/// Source: Koussios, Filament Winding: a Unified Approach (2004), ch. 6; do Carmo, ch. 4.4.
class SteeredClairaut {
 public:
  /// From q = `clairaut_mm` at the grid's beginning to its end, or a little beyond where q reaches r.
  SteeredClairaut(const SteeringGrid& grid, double clairaut_mm, double ratio);

  double ratio() const { return ratio_; }
  struct Value {
    double q_mm = 0, slope = 0;  ///< q, and its derivative by t
  };
  /// Before the beginning as there, beyond the end as at the end.
  Value at(double t) const;

 private:
  struct Block {
    double t = 0, width = 0;  // of a step
    std::array<double, 8> newton{};
  };
  const Block& block_at(double t) const;

  bool forward_;
  double ratio_;
  std::vector<Block> blocks_;
};

}  // namespace afptraj
