#pragma once

#include "io/slice_csv.h"

namespace afptraj {

/// Reads the closed curves of a DXF drawing (ASCII): LWPOLYLINE and POLYLINE with bulges, CIRCLE, ELLIPSE,
/// SPLINE, and LINE, ARC and open ones of the others joined where their ends are within 1e-4 mm. Units by
/// $INSUNITS (mm, cm, m, inch, foot; millimetres with a warning where it says nothing). Curves are flattened
/// to `tolerance_mm`. What is drawn otherwise (texts, inserts, hatches ...) is left out with a warning.
/// Throws Error(bad_input, "file:line" or file) for curves that do not close, that lie at different heights
/// or in a tilted plane, for data that cannot be read, and what Slice refuses.
SliceFile read_slice_dxf(const std::string& path, double tolerance_mm);

}  // namespace afptraj
