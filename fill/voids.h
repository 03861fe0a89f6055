#pragma once

#include "fill/fill_path.h"
#include "fill/slice.h"

namespace afptraj {

/// The places that beads of `width_mm` along `paths` enclose and leave bare, each with its area. Gaps
/// narrower than `tolerance_mm` are closed first. Bare places at the boundary, which no bead encloses, are
/// not among them.
struct Void {
  Slice region;
  double area_mm2 = 0;
};
std::vector<Void> voids(const std::vector<Polyline>& paths, double width_mm, double tolerance_mm);

/// Paths that fill a void: its medial axis, shortened at its tips by half a width, which the end of the bead
/// covers. Of a void shorter than that one stretch of length area / width remains: as much as the void holds.
std::vector<Polyline> void_paths(const Void& place, double width_mm);

/// Adds `void_paths` to `fill` for every void within the slice above `least_area_mm2`; the smaller ones, and
/// those that a hole of the slice opens into, are listed as leftovers. Holes of the slice themselves are no
/// voids.
void fill_voids(Fill& fill, const Slice& slice, double width_mm, double tolerance_mm, double least_area_mm2);

}  // namespace afptraj
