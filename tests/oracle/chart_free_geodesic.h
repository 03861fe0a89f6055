#pragma once

#include "occt_skin.h"

namespace oracle {

/// Where a geodesic shot ended.
struct Shot {
  Foot at;
  Vec tangent{0, 0, 0};    ///< unit, along the shot
  Vec normal{0, 0, 0};     ///< unit, of the sense it had at the start, carried along
  double length = 0;       ///< reached; less than asked when the shot ran off the surfaces
  double y = 1;            ///< Jacobi field with y(0) = 1, y'(0) = dy0
  bool left_skin = false;  ///< it ran outside of the material for a while
  int steps = 0;
};

struct ShotOptions {
  double tolerance_mm = 1e-8;  ///< per step, by step doubling
  double fixed_step_mm = 0;    ///< > 0: no step control (to measure the order)
};

/// A geodesic integrated in space, without the chart: x' = t, t' = kappa_n(x, t) n(x), x put back on the
/// surface after every step. Classical fourth-order Runge-Kutta with step doubling. At the edge of a
/// face it goes on where another face takes over; the tangent is turned by the least rotation that
/// takes one normal to the other (the straightest continuation). Where no face follows, the
/// surface beyond the trim is used.
Shot shoot(const Skin& skin, const Foot& start, const Vec& normal, const Vec& direction, double length,
           double dy0, const ShotOptions& options = {});

/// `t` turned by the least rotation that takes unit `from` to unit `to`.
Vec transported(const Vec& t, const Vec& from, const Vec& to);

}  // namespace oracle
