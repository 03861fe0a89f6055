#pragma once

#include "cli/arguments.h"
#include "winding/wind_definition.h"

namespace afptraj::cli {

/// The commands below `afptraj wind`; as those of commands.h.
int wind_validate(const Arguments& arguments);
int wind_plan(const Arguments& arguments);
int wind_simulate(const Arguments& arguments);
int wind_patterns(const Arguments& arguments);
int wind_vessel_patterns(const Arguments& arguments);
int wind_inspect(const Arguments& arguments);

WindMode wind_mode(const WindArguments& arguments);

/// The definition of the file; throws Error for one that cannot be read or wound.
WindDefinition read_sound_definition(const WindArguments& arguments);

}  // namespace afptraj::cli
