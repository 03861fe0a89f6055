#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "winding/pass_maker.h"

namespace afptraj {

struct VesselQuery {
  double angle_deg = 0;  ///< asked winding angle at the widest place, from the axis
  double tolerance_deg = 0;
  double tow_width_mm = 0;
  double most_overlap = 0.1;  ///< of neighbouring tows at the widest place, as a share of the tow
  std::int64_t most_starts = 12;
  SteeringRule steering = {};
};

/// A helical layer that closes on a mandrel between the places where it turns, without any dwell: by one
/// circuit the mandrel turns `turn_deg`, which is `stride` / `circuits` of a turn beyond whole ones.
struct VesselPattern {
  double angle_deg = 0;  ///< at the widest place
  std::int64_t circuits = 0, stride = 0;
  std::int64_t starts =
      0;                ///< circuits until one lies beside the first: starts * stride = +-1 modulo circuits
  bool leading = true;  ///< beside it ahead (+1), or behind (-1)
  double turn_deg = 0, length_mm = 0;                ///< of the mandrel and the fibre, by circuit
  double opening_first_mm = 0, opening_last_mm = 0;  ///< radii at which the fibre turns
  double ratio_first = 0, ratio_last = 0;            ///< of steering (SteeredPass); 0 for geodesics
  double overlap = 0;                                ///< of neighbouring tows at the widest place
};

/// All patterns within the tolerance, least error of the angle first. The circuits are those that cover the
/// widest place, N = ceil(2 pi R cos(alpha) / w); for each N and stride the angle solves
///   2 turn(alpha) = 360 (whole + stride / N)   to 1e-10 of a turn.
/// Angles at which no pass turns at both ends within the friction, or one turns nearer to the axis than half
/// a tow, are left out. `query.steering.tow_width_mm` is that of the query.
std::vector<VesselPattern> find_vessel_patterns(const Meridian& meridian, const VesselQuery& query);

/// Why it finds none; what would do.
std::string patterns_refusal(const Meridian& meridian, const VesselQuery& query);

}  // namespace afptraj
