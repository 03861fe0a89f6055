#pragma once

#include <array>
#include <vector>

#include "trajectory/front.h"

namespace afptraj {

/// Fronts that have left the skin and would come back.
///
/// A curve of the level before that ends at the boundary is swept on both sides of its end; its rays
/// may all have left the skin, or end there, while the front that comes from beyond that end would meet
/// another front inside. That one then stops where the curve comes to lie nearer than W all of a sudden, and
/// no other front ends there. Such stops tell which curves to go on from: along their own geodesic
/// outside, by two bands, with rays that may walk outside as far. What they go on from is added to
/// `laid`, since the front sweeps what lies beside it.
///
/// `untrimmed` are the strands of each front before it was trimmed. Returns the strands to add to them;
/// the caller trims again.
std::array<std::vector<Strand>, 2> lost_fronts(const std::array<Front*, 2>& fronts,
                                               const std::array<std::vector<Strand>, 2>& untrimmed, int level,
                                               LaidCurves& laid);

/// Gives a front its untrimmed strands back, and the lost ones, linked where they go on from each other.
void recall(Front& front, std::vector<Strand> untrimmed, const std::vector<Strand>& lost, int& next_link);

}  // namespace afptraj
