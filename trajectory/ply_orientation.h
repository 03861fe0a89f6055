#pragma once

#include <string>
#include <vector>

#include "geometry/types.h"

namespace afptraj {

/// One asked fibre direction: a place near the skin and the direction there (any length; an axis:
/// its sign carries no meaning).
struct PlyPoint {
  Vec3 position = Vec3::Zero();
  Vec3 direction = Vec3::UnitX();
  int line = 0;  ///< line in the file, 0 when it has none
};

/// The orientation points of one ply. `start` is the index of the point where the reference path
/// begins.
struct PlyOrientation {
  std::string name;
  std::vector<PlyPoint> points;
  std::size_t start = 0;
};

}  // namespace afptraj
