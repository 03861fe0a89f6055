#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "winding/machine_profile.h"
#include "winding/vessel_simulation.h"

namespace afptraj {

/// What an axis does in a layer.
struct AxisUse {
  double fastest_per_s = 0;        ///< by the lines' feeds; mm or degrees
  std::int64_t fastest_line = 0;   ///< of the program, from 1
  double lowest = 0, highest = 0;  ///< as lines name it, in mm or degrees
};

struct SimulatedMachineLayer {
  std::string name;                 ///< the comment without "Layer "
  std::int64_t moves = 0;           ///< lines on which an axis moves
  std::int64_t idle_moves = 0;      ///< lines on which none does
  std::int64_t backward_turns = 0;  ///< lines on which the mandrel turns back while the tow is fixed
  double time_s = 0;                ///< by the lines' feeds
  std::array<AxisUse, winder_axes> axes{};
  std::shared_ptr<const Meridian> mandrel;  ///< on which it is laid
  LaidTravel laid;
};

struct SimulatedMachineProgram {
  WindTow tow;
  std::int64_t commands = 0;  ///< lines without comments
  std::vector<SimulatedMachineLayer> layers;
};

/// Whether a text is a program of MachineWriter, by its header.
bool is_machine_program(std::string_view text);

/// Does what a controller does with the lines of such a program (G0, G1, G92; G20, G21; G90; G93, G94; M2)
/// and rebuilds what it lays from the places of the eye. Mandrel, tow and axes are those of the header;
/// comments say where the tow is fixed and cut. Throws Error(bad_input, "file:line", what is wrong; what to
/// do). `between` is called now and then.
SimulatedMachineProgram simulate_machine_text(const std::string& name, std::string_view text,
                                              const std::function<void()>& between = {});

}  // namespace afptraj
