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

/// The curve with straight cells (in u, v) in place of those whose cubic is more than half longer than the way between
/// their ends: derivatives by a parameter that does not fit there (a few microns where faces gap, or where the speed of
/// the rays jumps) make it loop. Such a cell becomes a piece of its own; nodes stay where they are.
SurfaceCurve without_loops(const Skin& skin, const SurfaceCurve& curve);

/// The level curves of a front. Between neighbouring rays on different charts (an edge, a seam, a
/// pole between them) the crossing is located by further rays, so that each piece ends on the edge.
std::vector<ChainedCurve> level_curves(const GeodesicTracer& tracer, const Front& front, int level);

}  // namespace afptraj
