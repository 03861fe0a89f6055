#pragma once

#include <cstdint>
#include <vector>

#include "winding/wind_definition.h"

namespace afptraj {

struct PatternQuery {
  double angle_deg = 0;      ///< asked winding angle, from the axis; on a cone at the large end
  double tolerance_deg = 0;  ///< patterns may be off by so much
  double lock_deg = 180;     ///< the locks offered are the multiple of 180 nearest to it
  std::int64_t largest_pattern = 12;
};

/// A helical layer that closes: every start at its place, no bare strip.
struct FoundPattern {
  std::int64_t circuits = 0, pattern = 1, skip = 1;
  double angle_deg = 0;
  double lock_deg = 180;
  double overlap = 0;          ///< of neighbouring tows, as a share of the tow; never negative
  std::int64_t crossings = 0;  ///< places where a there-pass crosses a back-pass
  bool fiberpath = false;      ///< FiberPath takes it too
};

/// The patterns within the tolerance, best first: least error of the angle, then least overlap, then fewest
/// starts. At the asked angle itself circuits are rounded up to a multiple of each pattern number, as native
/// planning does; beside it, each number of circuits has its own angle, at which its tows just touch (rounded
/// up to angle_step_deg, so that they do).
/// Empty where no angle within the tolerance lies between 0 and the steepest that a geodesic reaches.
std::vector<FoundPattern> find_patterns(const WindMandrel& mandrel, const WindTow& tow,
                                        const PatternQuery& query);
inline constexpr double angle_step_deg = 1e-4;

/// The steepest winding angle at the large end whose geodesic passes the whole mandrel: 90 on a cylinder.
double steepest_angle_deg(const WindMandrel& mandrel);

}  // namespace afptraj
