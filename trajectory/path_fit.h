#pragma once

#include <memory>

#include "trajectory/reference_path.h"
#include "trajectory/source_curve.h"

namespace afptraj {

struct FitOptions {
  /// Weight of the fairness term against the data, without unit: the minimised sum is
  ///   integral |c - p|^2 ds + fairness * length_mm^6 * integral (d kappa_g / ds)^2 ds
  /// so that features of the path shorter than about 6 length_mm fairness^(1/6) are smoothed.
  double fairness = 1e-3;
  double length_mm = 50.8;  ///< the band width
  double knot_spacing_mm = 8;
};

struct PathFit {
  std::shared_ptr<const SplinePath> path;
  double rms_mm = 0;  ///< of the stepped points from the fitted curve, across it
  double max_mm = 0;
};

/// Fits cubic B-splines in (u, v) to a stepped path by least squares with a fairness term (Ceres,
/// one thread, so that the bytes do not depend on it). Where the path goes over to another face,
/// crosses a seam or a pole, a new piece begins: position and direction are continuous there.
PathFit fit_path(const Skin& skin, const SteppedPath& stepped, const FitOptions& options);

}  // namespace afptraj
