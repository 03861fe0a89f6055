#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace afptraj {

/// Whose rules a definition is read, judged and planned by (docs/winding.md, "Two modes").
enum class WindMode {
  native,     ///< ours: nothing silent, nothing wasted
  fiberpath,  ///< FiberPath 0.10: same defaults, verdicts, messages and programs
};

/// The mandrel of a `.wind` file: a cylinder, or a straight cone with its first end at z = 0.
struct WindMandrel {
  double diameter_mm = 0;                 ///< at z = 0
  double length_mm = 0;                   ///< that is wound, along the axis
  std::optional<double> end_diameter_mm;  ///< at z = length; none, or equal to the other: a cylinder

  bool is_cone() const { return end_diameter_mm && *end_diameter_mm != diameter_mm; }
};

struct WindTow {
  double width_mm = 0, thickness_mm = 0;
};

/// One turn beside the other, there and back; `terminal`: there only, as the last layer.
struct HoopLayer {
  bool terminal = false;
};

/// A turn of the bare mandrel.
struct SkipLayer {
  double rotation_deg = 0;
};

/// Circuits there and back at an angle. A pattern is `pattern` circuits, each `skip` slots of 360/pattern
/// further than the ends alone would put it; the next pattern begins one tow further.
struct HelicalLayer {
  double angle_deg = 0;  ///< winding angle, from the axis; on a cone at z = 0
  std::int64_t pattern = 1, skip = 1;
  double lock_deg = 0;      ///< turn of the mandrel at each end
  double lead_in_mm = 0;    ///< over which the head swings to its laying angle
  double lead_out_deg = 0;  ///< turn of the mandrel in which it swings back
  bool skip_initial_near_lock = false;
};

using WindLayer = std::variant<HoopLayer, SkipLayer, HelicalLayer>;

/// A `.wind` file. Lengths are positive and all numbers finite: the readers see to that.
struct WindDefinition {
  std::string schema_version = "1.0";
  WindMandrel mandrel;
  WindTow tow;
  double feed_mm_per_min = 0;
  std::vector<WindLayer> layers;
};

/// "hoop", "skip" or "helical".
inline const char* layer_name(const WindLayer& layer) {
  constexpr const char* names[] = {"hoop", "skip", "helical"};
  return names[layer.index()];
}

}  // namespace afptraj
