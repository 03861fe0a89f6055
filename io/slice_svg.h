#pragma once

#include "io/slice_csv.h"

namespace afptraj {

/// Reads the closed shapes of an SVG drawing: path, polygon, polyline, rect, circle, ellipse, with the
/// transforms of their groups. y is turned upwards within the view box. One user unit is a millimetre; where
/// the drawing has a width in mm, cm, in, pt, pc or px, and a view box, that gives the scale. Curves are
/// flattened to `tolerance_mm`. Content of defs, clipPath, mask, symbol, pattern and marker is no shape;
/// lines, text, images and uses are left out with a warning. Throws Error(bad_input, "file:line" or file) for
/// shapes that are not closed, data that cannot be read, and what Slice refuses.
SliceFile read_slice_svg(const std::string& path, double tolerance_mm);

}  // namespace afptraj
