#pragma once

#include <string>

#include "fill/fill_path.h"

namespace afptraj {

struct GcodeOptions {
  double feed_mm_per_min = 1200;
  double extrusion_mm_per_mm = 0;  ///< material fed per millimetre of path, E relative (M83); 0: no E words
  double z_mm = 0;
};

/// A program for a machine with the axes x, y, z: millimetres, absolute places; G0 to the start of each path,
/// G1 along it, closed paths back to their start. Coordinates to 1e-4 mm; E so that the rounding of one move
/// is made good by the next.
std::string fill_gcode(const Fill& fill, const GcodeOptions& options);

/// VTK poly data (XML, ASCII): one polyline a path, the cell data `path`, `kind` (of PathKind, from 0) and
/// `level`. A closed path repeats its first point by its index.
std::string fill_vtp(const Fill& fill, double z_mm);

}  // namespace afptraj
