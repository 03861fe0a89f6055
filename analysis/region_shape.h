#pragma once

#include <vector>

#include "geometry/skin.h"

namespace afptraj {

/// Extent of a region of one face, seen along the normal at its middle.
struct RegionShape {
  double length_mm = 0;       ///< between the two points of its outline that lie farthest apart, to 0.5 %
  double width_mm = 0;        ///< greatest across that, measured at 65 places
  Vec3 where = Vec3::Zero();  ///< the middle of the widest place
};

/// `outline`: the outer boundary in (u, v), three points or more.
RegionShape region_shape(const Skin& skin, int face, const std::vector<Uv>& outline);

}  // namespace afptraj
