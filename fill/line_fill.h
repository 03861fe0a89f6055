#pragma once

#include "fill/fill_path.h"
#include "fill/slice.h"

namespace afptraj {

struct LineOptions {
  double spacing_mm = 1;           ///< greatest distance from line to line, and the width of a bead; > 0
  double angle_rad = 0;            ///< the lines' direction, from x towards y
  double first_mm = 0.5;           ///< the outermost path's distance from the boundary, positive inside
  double tolerance_mm = 1e-3;      ///< greatest distance of a chord of a path from the exact arc
  bool outline = false;            ///< rings at first_mm around the lines, which end half a width inside them
  bool zigzag = false;             ///< joins lines by links; else each line is a path of its own
  double most_link_mm = 10;        ///< zigzag: a longer link is not laid, the path ends before it
  double least_void_share = 0.05;  ///< with the outline: bare places above this share of spacing^2 get a path
};

/// Parallel lines over the slice: raster, or zigzag where links join them.
///
/// Lines end where the level curve at first_mm (with the outline: half a width farther inside) cuts them, so
/// that the round end of a bead touches the boundary and does not pass it. They are evenly spaced, at most
/// spacing_mm apart, the first and the last within a bead's half width of where the slice, or the outline's
/// bead, ends. Lines shorter than a twentieth of the spacing are left out.
///
/// Laws, checked by tests/line_fill_test.cpp:
///   (L1) No point of a path is nearer to the boundary than first_mm, up to tolerance_mm.
///   (L2) The lines are all of what is that deep on evenly spaced parallels.
///   (L3) A link runs on the level curve from the end of a line to the end of a next one; zigzag lays the
///        lines of raster, each once, and paths never cross.
///
/// Cost: that of one distance diagram, O(n log n), and O(k log k) for k lines.
Fill line_fill(const Slice& slice, const LineOptions& options);

}  // namespace afptraj
