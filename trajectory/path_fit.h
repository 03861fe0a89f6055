#pragma once

#include <memory>

#include "trajectory/reference_path.h"
#include "trajectory/source_curve.h"

namespace afptraj {

struct FitOptions {
  double fairness = 1e-3;   ///< see FairingOptions
  double length_mm = 50.8;  ///< the band width
  double knot_spacing_mm = 8;
};

struct PathFit {
  std::shared_ptr<const SplinePath> path;
  double rms_mm = 0;     ///< of the stepped points from the faired path, across it
  double max_mm = 0;     ///< greatest, with the spline's own deviation added
  double spline_mm = 0;  ///< greatest distance of the faired points from the spline
};

/// Fairs the stepped path (trajectory/fairing.h) and fits a cubic B-spline by least squares (Ceres, one
/// thread, so that the bytes do not depend on it) to each of its runs (trajectory/path_runs.h). Position and
/// direction are continuous from one to the next.
PathFit fit_path(const Skin& skin, const SteppedPath& stepped, const FitOptions& options);

}  // namespace afptraj
