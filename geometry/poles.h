#pragma once

#include <vector>

#include "geometry/skin.h"

namespace afptraj {

/// A point of a skin in which a side of a face, or of several, is degenerate.
struct Pole {
  Vec3 point = Vec3::Zero();
  std::vector<int> faces;
  Vec3 axis = Vec3::UnitZ();  ///< mean normal around it
  bool smooth = true;         ///< one tangent plane, as on a dome; else an apex, as on a cone
};
std::vector<Pole> poles_of(const Skin& skin);

}  // namespace afptraj
