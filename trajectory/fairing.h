#pragma once

#include "trajectory/reference_path.h"

namespace afptraj {

struct FairingOptions {
  /// Weight of the fairness term, without unit: the minimised sum is
  ///   integral w^2 ds + fairness * length_mm^6 * integral (d kappa_g / ds)^2 ds
  /// over lateral moves w, so that features of the path much shorter than about
  /// 6 length_mm fairness^(1/6) are smoothed. 0 leaves the path as it is.
  double fairness = 1e-3;
  double length_mm = 50.8;  ///< the band width
};

/// Fairs a stepped path on the skin: moves each point sideways, along b, so that the geodesic
/// curvature changes slowly. Least squares (Ceres): a move w changes kappa_g by w'' + K w (first
/// variation), which is linear in w while it turns the path and changes its length by little: in as many rounds as
/// that takes, and two with whole moves. An arc of constant kappa_g is left where it is.
/// Works over edges, seams and poles, because a move is a geodesic, and round the joint of a closed path. Ends at
/// an apex stay.
SteppedPath fair_path(const Skin& skin, const SteppedPath& stepped, const FairingOptions& options);

}  // namespace afptraj
