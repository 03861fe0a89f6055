#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "winding/simulate_program.h"

namespace afptraj {

/// Reads a winding program (G0, G1, G92, G21, G90, G94; axes X, A, B; F; comments) and simulates it. The
/// mandrel and the tow are taken from the first line that begins with "; Parameters ".
/// Throws Error(bad_input, "file:line", what is wrong; what to do). `between` is called now and then.
SimulatedProgram simulate_file(const std::string& path, const std::function<void()>& between = {});
/// The same for a text; `name` is for messages.
SimulatedProgram simulate_text(const std::string& name, std::string_view text,
                               const std::function<void()>& between = {}, KeepPieces keep = KeepPieces::no);

}  // namespace afptraj
