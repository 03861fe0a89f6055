#pragma once

#include <vector>

#include "geometry/section_march.h"

namespace afptraj::sections {

/// At least one point of each branch of plane ∩ skin that is longer than rounding: crossings of the
/// plane with the edges, and points on closed branches inside of faces. A branch that is only
/// touched (no change of sign anywhere) has none.
std::vector<SurfacePoint> seeds(const March& march, const Plane& plane);

}  // namespace afptraj::sections
