#pragma once

#include "analysis/sharp_corners.h"
#include "fill/fill_path.h"
#include "fill/slice.h"

namespace afptraj {

/// What a fill covers. The cover is the union of the beads: all points within half a width of a path.
struct FillReport {
  double slice_mm2 = 0, covered_mm2 = 0;
  double underfill = 0;  ///< share of the slice that is bare
  double unreachable =
      0;                ///< share of the slice that no bead reaches without leaving it: narrow places, tips
  double outside = 0;   ///< cover outside the slice, as share of the slice
  double overfill = 0;  ///< (length x width - cover) / slice: material that is laid on material
  double overfill_with_ends = 0;  ///< the same, and what the two round ends of each open path lay
  double length_mm = 0;
  double travel_mm = 0;  ///< from the end of each path straight to the start of the next
  int paths = 0;
  int sharp_corners = 0;
  double min_turning_radius_mm =
      0;  ///< least of chord length / turn at the points; infinite for straight paths
};

/// The areas are exact for the given points but for: gaps narrower than 2e-8 of the box, which count as
/// covered, and the bound of region_areas(). Deterministic.
FillReport judge_fill(const Slice& slice, const std::vector<FillPath>& paths, double width_mm,
                      const SharpCornerOptions& sharp = {});

}  // namespace afptraj
