#pragma once

#include "winding/plan_program.h"

namespace afptraj {

/// The layers of a program: each begins with all axes at 0, and ends so unless the layer is terminal.
void write_hoop(ProgramWriter& writer, const WindDefinition& definition, const HoopLayer& layer);
void write_helical(ProgramWriter& writer, const WindDefinition& definition, const HelicalLayer& layer,
                   LayerReport& report);

/// Turns the mandrel on to a whole turn and declares all axes to stand at 0 there. In FiberPath mode a
/// mandrel that stands at a whole turn makes another one.
void write_zero(ProgramWriter& writer, double mandrel_deg);

}  // namespace afptraj
