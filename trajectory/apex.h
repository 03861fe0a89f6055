#pragma once

#include <optional>
#include <vector>

#include "geometry/poles.h"
#include "trajectory/reference_path.h"

namespace afptraj {

/// A path that ends on an apex stands this far beside it: there the skin has a normal.
inline constexpr double beside_apex_mm = 5e-7;

/// The point of the skin at a distance from a pole, on the side of `toward`, as the next of a path after
/// `from`. Nothing where the skin does not lie there.
std::optional<SteppedPoint> beside_pole(const Skin& skin, const Vec3& pole, const Vec3& toward,
                                        double distance_mm, const SteppedPoint& from);

/// How a path goes on from `from` over an apex: to the opposite meridian, which leaves as much of the skin to
/// its left as to its right, by an arc beside the apex that ends as far from it as it began.
///
/// Unrolled, half of the skin about an apex is a sector of less than two right angles (pi times the sine of a
/// cone's half angle). The arc touches both of its sides and turns by what is missing. Nothing where that is
/// more than one right angle, so that the parallels of a path that ends there meet before they come to the
/// apex, or where there is no skin.
std::optional<std::vector<SteppedPoint>> arc_over_apex(const Skin& skin, const Pole& apex,
                                                       const SteppedPoint& from, const StepOptions& options);

}  // namespace afptraj
