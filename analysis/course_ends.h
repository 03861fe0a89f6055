#pragma once

#include <array>
#include <vector>

#include "analysis/course_lines.h"
#include "geometry/geodesic.h"

namespace afptraj {

/// Why a line ends where it does.
enum class LineEnd {
  boundary,  ///< a free edge, or a pole
  meeting,   ///< another end of the same level, where fronts met
  none,      ///< the line is closed, or off the skin
  loose,     ///< inside the skin for no reason
};

/// First and last end of every line.
std::vector<std::array<LineEnd, 2>> line_ends(const GeodesicTracer& tracer, const std::vector<CourseLine>& lines);

}  // namespace afptraj
