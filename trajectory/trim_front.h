#pragma once

#include <array>

#include "trajectory/front.h"

namespace afptraj {

/// Cuts the two fronts of a level (right may be null) down to the true distance.
///
/// The curves are cut where they cross (each other or themselves) and at cusps that no meeting comes before. A crossing at which
/// no curve of a lower level is nearer than W is where fronts meet: of the four branches those two go
/// on that lead away from what the other front has swept; an extension ends at its first meeting. Any other crossing lies within what has been swept.
/// A stretch between cuts is kept if both its ends are such meetings or its own, the Jacobi
/// field is positive, and no curve of a lower level is nearer than W at any probe on it: by the
/// triangle inequality this is exact, since a shortest path to p crosses that level at a kept point.
/// Ends at meetings become `corner`; ends at cusps, beyond which no ray leads, become `open`.
void trim_fronts(const std::array<Front*, 2>& fronts, int level, const LaidCurves& laid);

}  // namespace afptraj
