#pragma once

#include "cli/arguments.h"
#include "io/machine_program_file.h"
#include "winding/wind_definition.h"

namespace afptraj::cli {

/// The commands below `afptraj wind`; as those of commands.h.
int wind_validate(const Arguments& arguments);
int wind_plan(const Arguments& arguments);
int wind_vessel_plan(const Arguments& arguments);
int wind_vessel_validate(const Arguments& arguments);
int wind_simulate(const Arguments& arguments);
int wind_plot(const Arguments& arguments);
int wind_patterns(const Arguments& arguments);
int wind_vessel_patterns(const Arguments& arguments);
int wind_inspect(const Arguments& arguments);
int print_simulated(const SimulatedMachineProgram& program, const Arguments& arguments);

/// Whether it is a winding of a mandrel with a meridian: a .toml file, or a part and plies.
bool is_vessel(const WindArguments& arguments);

WindMode wind_mode(const WindArguments& arguments);

/// The definition of the file; throws Error for one that cannot be read or wound.
WindDefinition read_sound_definition(const WindArguments& arguments);

}  // namespace afptraj::cli
