#pragma once

#include "fill/distance_diagram.h"
#include "fill/fill_path.h"

namespace afptraj {

struct ContourOptions {
  double spacing_mm = 1;           ///< from ring to ring, and the width of a bead; > 0
  double first_mm = 0.5;           ///< the outermost ring's distance from the boundary, positive inside
  double tolerance_mm = 1e-3;      ///< greatest distance of a chord of a path from the exact arc
  double corner_mm = 0.25;         ///< radius of convex corners of rings, at most half a spacing; 0: sharp
  double least_void_share = 0.05;  ///< bare places above this share of spacing^2 get a path of their own
};

/// The slice's boundary moved inside by `distance_mm` (outside where negative): tool compensation. Rings
/// merge, split and vanish as they must.
std::vector<ArcRing> offset_rings(const Slice& slice, double distance_mm, double tolerance_mm);

/// The paths nearest to the boundary: the level curve at `first_mm`, or the boundary itself at 0, and the
/// middle lines of strips exactly twice that wide. `diagram` is that of the slice, with a reach of at least
/// -first_mm.
std::vector<FillPath> outermost_paths(const Slice& slice, const DistanceDiagram& diagram, double first_mm,
                                      double tolerance_mm);

/// All rings at first, first + spacing, ... from the boundary, outlines and holes alike, each read from one
/// diagram; with convex corners rounded (a sharp corner lays material twice inside and leaves a gap outside);
/// then paths along the medial axes of the bare places that remain (fill/voids.h). Source of the behaviour:
/// contour-parallel pocketing (Held 1991); of the extra paths: own.
Fill contour_parallel(const Slice& slice, const ContourOptions& options);

}  // namespace afptraj
