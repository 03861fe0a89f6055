#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "trajectory/front.h"

namespace afptraj {

/// A strand of one of the two fronts of a level.
struct StrandPlace {
  int front = 0;
  std::size_t strand = 0;
  bool operator==(const StrandPlace&) const = default;
};

/// A point that two stretches of a level, or one stretch twice, pass through.
struct FrontCrossing {
  StrandPlace place[2];
  Ray ray[2];    ///< both end at the crossing
  double miss_mm = 0;  ///< how far apart they end
};

/// All crossings of the curves of one level, with each other and with themselves.
///
/// Found between chords of neighbouring rays (a hash of their places) and at the tails of
/// swallowtails (between two cusps of a strand), then solved by Newton-Raphson on
/// exp(t0, d) = exp(t1, d), whose Jacobian is y times the speed of the source along the front.
/// Ends at which two strands are linked are not crossings. In a fixed order.
std::vector<FrontCrossing> front_crossings(const std::array<const Front*, 2>& fronts, int level);

}  // namespace afptraj
