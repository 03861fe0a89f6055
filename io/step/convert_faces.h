#pragma once

// Private to io/step: from placed OpenCASCADE faces to plain faces with loops and numbered edges.

#include "io/step/collect.h"
#include "io/step/part_codec.h"

namespace afptraj::step {

/// Converts every face; what had to be repaired is added to `model.head.warnings`. Edges of one
/// solid, and of all shells and loose faces that are not in a solid, share their numbers.
/// A face that cannot be converted is left out, with a warning.
void convert_faces(const std::vector<SourceFace>& faces, PlainModel& model);

}  // namespace afptraj::step
