#pragma once

#include "fill/planar.h"

namespace afptraj {

struct SharpCornerOptions {
  double radius_mm = 1;     ///< of the disc round each point
  double threshold = 0.3;   ///< sharp: the smaller side has at most this share of the disc
  double cluster_mm = 0.5;  ///< sharp points nearer than this to the one before count as one corner
};

/// The share of the disc of `radius_mm` round point i of the path that lies on the larger side of the path,
/// 0.5 ... 1: 0.5 on a straight line, 1 - phi / 2 pi at a corner of the interior angle phi. Negative where
/// the path does not leave the disc both ways. O(log n) for a point after O(n) for the path.
///
/// Source: H. Pottmann et al., Integral invariants for robust geometry processing, CAGD 26 (2009): the area
/// invariant.
std::vector<double> area_invariants(const Polyline& path, double radius_mm);

/// Places where the path turns sharply.
std::vector<Vec2> sharp_corners(const Polyline& path, const SharpCornerOptions& options = {});

}  // namespace afptraj
