#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "winding/machine_writer.h"
#include "winding/vessel_patterns.h"

namespace afptraj {

/// A helical layer between the places of a mandrel with a meridian where its fibre turns, or hoops on its
/// widest stretch.
struct VesselLayer {
  double angle_deg = 0;  ///< at the widest place, from the axis
  double tolerance_deg = 1;
  double most_overlap = 0.1;
  std::optional<std::int64_t> circuits = {}, stride = {};  ///< choose a pattern; otherwise the first is taken
  SteeringRule steering = {};                              ///< without its tow width, which is the winding's
  bool hoop = false;                                       ///< nothing above counts
};

struct VesselWinding {
  Meridian meridian;
  WindTow tow;
  double feed_mm_per_min = 0;
  std::vector<VesselLayer> layers;
  bool growth = true;  ///< each layer is wound on what those before it have left (grown_mandrel)
};

struct VesselLayerReport {
  std::shared_ptr<const Meridian> mandrel;               ///< on which it is wound
  VesselPattern pattern;                                 ///< of hoops: one circuit
  double least_thickness_mm = 0, most_thickness_mm = 0;  ///< of the layer, from turn to turn
  std::int64_t lines = 0;
  double laid_mm = 0, repositioned_mm = 0;  ///< of fibre; of the carriage between layers
  double asked_time_s = 0;                  ///< at the feed, within the axes' speeds
  double time_s = 0;                        ///< with the axes' accelerations
  double least_free_mm = 0, most_free_mm = 0;
  std::int64_t backward_turns = 0;  ///< moves that turn the mandrel back: at hollow edges of a meridian
  std::vector<ClampedAxis> clamped;
};

struct VesselReport {
  std::vector<VesselLayerReport> layers;
  std::int64_t lines = 0;
};

/// The pattern of a layer: of those that close (find_vessel_patterns), the first that fits what is chosen.
/// Throws Error(no_path, "layer N", ...) when none does, naming what would.
VesselPattern layer_pattern(const Meridian& meridian, const WindTow& tow, const VesselLayer& layer,
                            std::size_t number);

/// Hoops, there and back, tow beside tow: a screw of about the tow's width on the widest stretch, that bends
/// to a circle and back within half a turn each at its ends, which takes next to no friction. Throws
/// Error(no_path, "layer N", ...) where that stretch is shorter than two tows.
VesselPattern hoop_pattern(const Meridian& meridian, const WindTow& tow, std::size_t number);
/// How its passes are steered.
SteeringRule hoop_rule(double angle_deg, const WindTow& tow);

/// Writes the program of a winding for a machine. Between layers the tow is cut, the eye goes out to where it
/// is free of the mandrel, along it, and in again. Throws Error(no_path) for a layer without pattern, a
/// thread that would bridge, an eye that is too near, an axis beyond its travel; FeedRateExceeded
/// (set_times).
VesselReport write_vessel_program(const VesselWinding& winding, const MachineProfile& profile,
                                  OverSpeed over_speed, const MachineWriter::Sink& sink);

}  // namespace afptraj
