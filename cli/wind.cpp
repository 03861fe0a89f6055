#include <filesystem>

#include "cli/commands.h"
#include "cli/wind_commands.h"
#include "geometry/error.h"
#include "io/wind_file.h"
#include "winding/layer_rules.h"

namespace afptraj::cli {

WindMode wind_mode(const WindArguments& arguments) {
  return arguments.fiberpath ? WindMode::fiberpath : WindMode::native;
}

WindDefinition read_sound_definition(const WindArguments& arguments) {
  WindDefinition definition = read_wind_file(arguments.file, wind_mode(arguments));
  if (const auto fault = first_fault(definition, wind_mode(arguments))) {
    throw Error(fault->code, arguments.file, "Layer " + std::to_string(fault->layer) + ": " + fault->message);
  }
  return definition;
}

bool is_vessel(const WindArguments& arguments) {
  return std::filesystem::path(arguments.file).extension() == ".toml" || !arguments.plies.empty();
}

namespace {

void refuse_part_alone(const WindArguments& arguments) {
  const std::string kind = std::filesystem::path(arguments.file).extension().string();
  if (arguments.plies.empty() && (kind == ".step" || kind == ".stp" || kind == ".STEP" || kind == ".STP"))
    throw Error(ErrorCode::usage, arguments.file,
                "is a part; give its ply points after it (plies.csv), or a winding that names it (.toml)");
}

}  // namespace

int wind(const Arguments& arguments) {
  const bool vessel = is_vessel(arguments.wind);
  switch (arguments.wind.command) {
    case WindArguments::Command::validate:
      return vessel ? wind_vessel_validate(arguments) : wind_validate(arguments);
    case WindArguments::Command::plan:
      refuse_part_alone(arguments.wind);
      return vessel ? wind_vessel_plan(arguments) : wind_plan(arguments);
    case WindArguments::Command::simulate:
      return wind_simulate(arguments);
    case WindArguments::Command::plot:
      return wind_plot(arguments);
    case WindArguments::Command::patterns:
      return std::filesystem::path(arguments.wind.file).extension() == ".wind"
                 ? wind_patterns(arguments)
                 : wind_vessel_patterns(arguments);
    case WindArguments::Command::inspect:
      return wind_inspect(arguments);
  }
  return 0;
}

}  // namespace afptraj::cli
