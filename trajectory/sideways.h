#pragma once

#include <vector>

#include "geometry/geodesic.h"
#include "trajectory/reference_path.h"

namespace afptraj {

/// The tracer for lateral moves of a stepped path: geodesics that may leave the skin by up to `reach_mm`.
GeodesicTracer sideways_tracer(const Skin& skin, double reach_mm);

/// Moves a point of the path by the signed length `w_mm` along the geodesic to its left (n x direction). False,
/// and the point as it was, when the geodesic does not get that far.
bool move_sideways(const GeodesicTracer& tracer, SteppedPoint& p, double w_mm);

/// Sets direction and s_mm of every point anew, from the points beside it; s_mm goes on from the first point's.
/// `closed`: the last point is the first again.
void renew_directions(std::vector<SteppedPoint>& points, bool closed);

}  // namespace afptraj
