#pragma once

#include <cstdint>
#include <vector>

#include "winding/meridian.h"

namespace afptraj {

struct VesselQuery {
  double angle_deg = 0;  ///< asked winding angle at the widest place, from the axis
  double tolerance_deg = 0;
  double tow_width_mm = 0;
  double most_overlap = 0.1;  ///< of neighbouring tows at the widest place, as a share of the tow
  std::int64_t most_starts = 12;
};

/// A helical layer of pure geodesics that closes on a mandrel between its polar openings, without any dwell:
/// by one circuit the mandrel turns `turn_deg`, which is `stride` / `circuits` of a turn beyond whole ones.
struct VesselPattern {
  double angle_deg = 0;  ///< at the widest place
  std::int64_t circuits = 0, stride = 0;
  std::int64_t starts =
      0;                ///< circuits until one lies beside the first: starts * stride = +-1 modulo circuits
  bool leading = true;  ///< beside it ahead (+1), or behind (-1)
  double turn_deg = 0, length_mm = 0;                ///< of the mandrel and the fibre, by circuit
  double opening_first_mm = 0, opening_last_mm = 0;  ///< radii of the polar openings
  double overlap = 0;                                ///< of neighbouring tows at the widest place
};

/// The winding angle at the widest place whose polar opening is as wide as the tow; below it tows cross the
/// axis.
double least_angle_deg(const Meridian& meridian, double tow_width_mm);

/// All patterns within the tolerance, least error of the angle first. The circuits are those that cover the
/// widest place, N = ceil(2 pi R cos(alpha) / w); for each N and stride the angle solves
///   2 turn(alpha) = 360 (whole + stride / N)   to 1e-10 of a turn.
/// Angles at which a pass does not turn at both ends, or turns nearer to the axis than half a tow, are left
/// out.
std::vector<VesselPattern> find_vessel_patterns(const Meridian& meridian, const VesselQuery& query);

}  // namespace afptraj
