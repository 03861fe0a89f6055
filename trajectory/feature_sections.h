#pragma once

#include "geometry/section.h"
#include "trajectory/source_curve.h"

namespace afptraj {

/// How far the skin reaches from the reference path, measured in the planes across it.
struct FeatureSections {
  double L1_mm = 0, L2_mm = 0;  ///< greatest section length to the left, to the right
  int N1 = 0, N2 = 0;           ///< bands needed beside course 0
};

/// At points Q_i of the path every `spacing_mm`, the plane spanned by n and b cuts the skin in one
/// curve to the left and one to the right; N = ceil((L - W/2) / W), never below 0. A section that comes back
/// to its start is shared: half of it belongs to each side.
FeatureSections feature_sections(const Skin& skin, const SourceCurve& path, double band_width_mm, double spacing_mm);

}  // namespace afptraj
