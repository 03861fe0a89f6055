#pragma once

#include <functional>
#include <vector>

#include "fill/planar.h"

namespace afptraj {

/// Appends points of the curve from t0 (left out) to t1 (with it) such that no chord is farther than
/// `tolerance_mm` from the curve where it is looked at: at a quarter, half and three quarters of each chord,
/// which is halved until they hold, at least into `pieces` parts.
void append_curve(std::vector<Vec2>& points, const std::function<Vec2(double)>& curve, double t0, double t1,
                  int pieces, double tolerance_mm);

}  // namespace afptraj
