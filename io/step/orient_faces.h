#pragma once

#include <vector>

#include "geometry/part.h"

namespace afptraj::step {

struct OrientResult {
  int turned = 0;     ///< faces whose `reversed` was changed
  int one_sided = 0;  ///< groups that cannot be oriented (like a Moebius strip)
};

/// Turns faces so that neighbours agree, in the connected groups of faces that hold an edge of
/// `joined`. A closed group faces outward; an open one keeps the side of the most of its faces.
OrientResult orient_faces(Part& part, const std::vector<int>& joined);

}  // namespace afptraj::step
