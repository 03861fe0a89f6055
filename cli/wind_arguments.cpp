#include "cli/wind_arguments.h"

#include "geometry/error.h"

namespace afptraj::cli {
namespace {

const char* const wind_examples = R"(Examples:
  afptraj wind validate vessel.wind
  afptraj wind plan vessel.wind -o program.gcode
  afptraj wind plan vessel.wind -o program.gcode --fiberpath

--fiberpath reads, judges and plans as FiberPath 0.10 does, byte for byte.)";

CLI::App* add_command(CLI::App& wind, const char* name, const char* what, WindArguments& arguments) {
  CLI::App* command = wind.add_subcommand(name, what);
  command->add_option("file", arguments.file, "the winding: mandrel, tow, layers")->type_name("vessel.wind");
  command->add_flag("--fiberpath", arguments.fiberpath, "by FiberPath's rules, in its words");
  return command;
}

}  // namespace

CLI::App* add_wind_commands(CLI::App& app, WindArguments& arguments, const WindFlags& flags) {
  CLI::App* wind = app.add_subcommand("wind", "Filament winding: machine programs from .wind files.");
  wind->footer(wind_examples);

  CLI::App* validate = add_command(*wind, "validate", "Says whether a .wind file can be wound.", arguments);
  validate->footer(
      "Examples:\n  afptraj wind validate vessel.wind\n"
      "  afptraj wind validate vessel.wind --fiberpath --json");
  validate->add_flag("--json", *flags.json, "for machines");

  CLI::App* plan = add_command(*wind, "plan", "Writes the machine program of a .wind file.", arguments);
  plan->footer(
      "Examples:\n  afptraj wind plan vessel.wind -o program.gcode\n"
      "  afptraj wind plan vessel.wind --fiberpath --json > summary.json");
  plan->add_option("-o,--output", arguments.output, "the program [<file>.gcode]")->type_name("FILE");
  plan->add_flag("--force", *flags.force, "replace an earlier program");
  plan->add_flag("--json", *flags.json, "print a summary for machines instead of a table");
  plan->add_flag("-q,--quiet", *flags.quiet, "print errors only");
  return wind;
}

void finish_wind(const CLI::App& command, WindArguments& arguments) {
  const std::string name = "afptraj wind " + command.get_name();
  if (arguments.file.empty())
    throw Error(ErrorCode::usage, name, "needs a .wind file; see " + name + " --help");
  arguments.command =
      command.get_name() == "plan" ? WindArguments::Command::plan : WindArguments::Command::validate;
}

}  // namespace afptraj::cli
