#pragma once

#include <optional>
#include <string>
#include <vector>

#include "winding/band_arcs.h"
#include "winding/meridian.h"
#include "winding/thread_contact.h"
#include "winding/wind_definition.h"

namespace afptraj {

/// What the eye does between the lines that say that the tow is fixed and cut.
struct EyeTravel {
  double start_z_mm = 0, start_r_mm = 0, start_turn_rad = 0;  ///< where the tow is fixed to the mandrel
  std::vector<EyePlace> eyes;
};

/// What lies on the mandrel after it.
struct LaidTravel {
  std::vector<ContactPoint> path;
  BandCoverage coverage;  ///< between the turns next to the ends
  BandCoverage one_way;   ///< by what runs there alone, or back, whichever leaves the wider gap
  double laid_mm = 0;
  double least_r_first_mm = 0, least_r_last_mm = 0;  ///< where the path turns next to either end
  std::int64_t starts = 0;                           ///< passes that leave the first end
  double start_error_deg = 0;  ///< greatest distance of a start from its place among 360 / starts
  std::int64_t crossings = 0;  ///< of the path's middle: of what runs there and back
  /// Greatest ratio of the path's geodesic to its normal curvature, each as the mean over `slip_window_mm`:
  /// the friction that holds it, and where along the axis.
  double slip_ratio = 0, slip_z_mm = 0;
  double least_free_mm = 0, most_free_mm = 0;
  double least_clearance_mm = 0;  ///< of the eye from the mandrel's hull
};

/// Rebuilds the path from the eye alone (follow_thread) in steps of `simulation_step_mm`, and what it covers.
LaidTravel simulate_travel(const Meridian& meridian, const WindTow& tow, const EyeTravel& travel);
inline constexpr double simulation_step_mm = 1;
inline constexpr double slip_window_mm = 12;  ///< the eye's straight pieces let the path waver over less

}  // namespace afptraj
