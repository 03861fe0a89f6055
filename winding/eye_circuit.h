#pragma once

#include <vector>

#include "winding/fibre_pass.h"
#include "winding/machine_profile.h"
#include "winding/payout_eye.h"

namespace afptraj {

/// The axes of a machine along a fibre path.
struct EyeSample {
  double length_mm = 0;  ///< of the path from its start
  double angle_rad = 0;  ///< winding angle: 0 axial, pi / 2 hoop
  AxisValues axes{};
};

/// Pieces between samples are straight in all axes. They depart from the true axes by no more than this: the
/// eye by 0.004 mm, so that what is laid departs by no more (ThreadContact: errors of the eye fade along the
/// path).
inline constexpr double circuit_tolerance_mm =
    0.0025;  ///< of carriage, cross-feed, and the eye's way round the axis
inline constexpr double circuit_rotation_deg = 0.05;  ///< of the eye's rotation

/// One circuit of a fibre between the places where it turns, there and back, from the turn at the first end
/// to the next one there. The last sample is the first, one circuit's turn of the mandrel further.
struct EyeCircuit {
  std::vector<EyeSample> samples;
  double least_free_mm = 0, most_free_mm = 0;  ///< lengths of the free thread
};

/// REQUIRES: the pass turns at both ends.
/// Throws Error(no_path, "mandrel", ...) where the thread would bridge a hollow by more than 0.01 mm, or the
/// meridian has an edge of more than 0.1 rad.
EyeCircuit eye_circuit(const Meridian& meridian, const FibrePass& pass, const PayoutEye& eye);

}  // namespace afptraj
