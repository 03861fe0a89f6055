#pragma once

#include <vector>

#include "trajectory/front.h"

namespace afptraj {

/// A chain of strands joined by their links, as one curve; `strands[i]` begins at parameter
/// rays.front().t + offset[i] of it.
struct ChainedCurve {
  SurfaceCurve curve;
  std::vector<std::size_t> strands;
  std::vector<double> offsets;
};

/// The level curves of a front. Between neighbouring rays on different charts (an edge, a seam, a
/// pole between them) the crossing is located by further rays, so that each piece ends on the edge.
std::vector<ChainedCurve> level_curves(const GeodesicTracer& tracer, const Front& front, int level);

}  // namespace afptraj
