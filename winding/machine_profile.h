#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>

#include "winding/payout_eye.h"

namespace afptraj {

/// The logical axes of a winder, in the order in which programs write them.
enum class WinderAxis { carriage, mandrel, cross_feed, eye };
inline constexpr std::size_t winder_axes = 4;
inline constexpr std::array<const char*, winder_axes> axis_names{"carriage", "mandrel", "cross_feed", "eye"};

/// Millimetres (carriage, cross-feed) or degrees (mandrel, eye).
using AxisValues = std::array<double, winder_axes>;
inline double& value(AxisValues& axes, WinderAxis axis) { return axes[static_cast<std::size_t>(axis)]; }
inline double value(const AxisValues& axes, WinderAxis axis) { return axes[static_cast<std::size_t>(axis)]; }

struct MachineAxis {
  char letter = 'X';
  double lowest = -std::numeric_limits<double>::infinity();  ///< of its travel
  double highest = std::numeric_limits<double>::infinity();
  double speed_per_s = 0;
  double acceleration_per_s2 = 0;
};

/// How a program is written (docs/winding.md, "Machines").
enum class Dialect {
  xab,    ///< G1 with a feed by the norm of all axes (G94); letters X, A, B and Y for the cross-feed
  xyz,    ///< the same with the older letters X, Y (mandrel), Z (eye) and A for the cross-feed
  rs274,  ///< RS-274 as LinuxCNC reads it, inverse-time feed (G93)
};

/// A winder: carriage and mandrel always, cross-feed and eye rotation where it has them.
struct MachineProfile {
  std::string name;
  Dialect dialect = Dialect::xab;
  bool inches = false;    ///< of its linear axes in programs
  bool roll_over = true;  ///< the mandrel is told to stand whole turns further back after each circuit
  EyeRoom eye_room;
  std::array<std::optional<MachineAxis>, winder_axes> axes;

  const std::optional<MachineAxis>& axis(WinderAxis which) const {
    return axes[static_cast<std::size_t>(which)];
  }
};

}  // namespace afptraj
