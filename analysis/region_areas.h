#pragma once

#include <vector>

#include "fill/planar.h"

namespace afptraj {

/// What two regions of the plane share and what each has alone, mm^2.
struct RegionAreas {
  double both = 0, only_first = 0, only_second = 0;
};

/// Regions are given by their boundaries, closed curves of lines and arcs; a point is inside when it lies
/// within an odd number of them.
///
/// The plane is cut into upright slabs at all ends and at the leftmost and rightmost points of arcs; between
/// two neighbouring boundaries a slab's area has a closed form. A slab in which boundaries change places is
/// halved until they do so by less than `tolerance_mm`. Error: below tolerance_mm times the length of the
/// boundaries, beside rounding; boundaries that lie on each other are no special case. Cost: O(n m log m), m
/// boundaries above one place.
RegionAreas region_areas(const std::vector<ArcRing>& first, const std::vector<ArcRing>& second,
                         double tolerance_mm = 1e-9);

}  // namespace afptraj
