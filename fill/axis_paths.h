#pragma once

#include "fill/distance_diagram.h"

namespace afptraj {

/// Paths along a medial axis without its tips: what is farther than `trim_mm`, measured along the axis, from
/// the tip of its branch. Branches are joined straight on where they meet; loops stay closed. Empty when
/// nothing is that far.
std::vector<Polyline> trimmed_axis(const DistanceDiagram::MedialAxis& axis, double trim_mm);

/// The longest way along the axis from tip to tip (of a tree; of an axis with loops, one of its long ways).
Polyline longest_way(const DistanceDiagram::MedialAxis& axis);

}  // namespace afptraj
