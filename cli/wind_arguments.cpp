#include "cli/wind_arguments.h"

#include <filesystem>
#include <map>

#include "cli/wind_commands.h"
#include "geometry/error.h"
#include "io/text_file.h"

namespace afptraj::cli {
namespace {

const char* const wind_examples = R"(Examples:
  afptraj wind validate vessel.wind
  afptraj wind plan vessel.wind -o program.gcode
  afptraj wind plan vessel.wind -o program.gcode --fiberpath
  afptraj wind plan vessel.toml -o program.gcode
  afptraj wind plan part.step plies.csv --machine winder.toml --tow-width 8 --thickness 0.3 --feed 12000
  afptraj wind simulate program.gcode
  afptraj wind plot program.gcode
  afptraj wind patterns vessel.wind --angle 54.7 --tolerance 2
  afptraj wind inspect meridian.csv --angle 20

--fiberpath reads, judges and plans as FiberPath 0.10 does, byte for byte.)";

CLI::App* add_command(CLI::App& wind, const char* name, const char* what, WindArguments& arguments) {
  CLI::App* command = wind.add_subcommand(name, what);
  command->add_option("file", arguments.file, "the winding: mandrel, tow, layers")->type_name("vessel.wind");
  command->add_flag("--fiberpath", arguments.fiberpath, "by FiberPath's rules, in its words");
  return command;
}

void add_angle(CLI::App& command, WindArguments& arguments, const char* what) {
  command.add_option("--angle", arguments.angle, what)->type_name("DEG");
  command.add_option("--angle-from", arguments.angle_from, "where --angle counts from: axis or hoop [axis]")
      ->type_name("FROM");
}

void add_machine(CLI::App& command, WindArguments& arguments) {
  command.add_option("--machine", arguments.machine, "of a vessel.toml: the machine [the one that it names]")
      ->type_name("machine.toml");
  command
      .add_option("--over-speed", arguments.over_speed,
                  "of a vessel.toml: where an axis is too slow, clamp or refuse [clamp]")
      ->type_name("HOW");
}

// Of a plan of a part by its ply points.
void add_plies(CLI::App& plan, WindArguments& arguments) {
  plan.add_option("plies", arguments.plies, "of a part: its ply points, ply,x,y,z,dx,dy,dz")
      ->type_name("plies.csv");
  plan.add_option("--tow-width", arguments.tow_width, "of a part: width of the tow")->type_name("MM");
  plan.add_option("--thickness", arguments.thickness, "of a part: thickness of the tow")->type_name("MM");
  plan.add_option("--feed", arguments.feed, "of a part: fibre by minute")->type_name("MM");
  plan.add_option("--tolerance", arguments.tolerance, "of a part: angles may be off by so much [2]")
      ->type_name("DEG");
  plan.add_option("--overlap", arguments.overlap, "of a part: most overlap of tows [10]")
      ->type_name("PERCENT");
  plan.add_option("--friction", arguments.friction, "of a part: what keeps the tow beside geodesics [0]")
      ->type_name("MU");
  plan.add_option("--face", arguments.faces,
                  "of a part: the faces of the mandrel, by number [all but planes]")
      ->type_name("LIST");
}

void check_plies(WindArguments& arguments) {
  if (arguments.command != WindArguments::Command::plan) return;
  if (arguments.plies.empty()) {
    for (const auto& [flag, text] : {std::pair{"--tow-width", &arguments.tow_width},
                                     {"--thickness", &arguments.thickness},
                                     {"--feed", &arguments.feed},
                                     {"--tolerance", &arguments.tolerance},
                                     {"--overlap", &arguments.overlap},
                                     {"--friction", &arguments.friction},
                                     {"--face", &arguments.faces}}) {
      if (!text->empty())
        throw Error(ErrorCode::usage, flag, "is for a part and plies.csv; write it in the winding's file");
    }
    return;
  }
  const std::string kind = std::filesystem::path(arguments.file).extension().string();
  if (kind == ".wind" || kind == ".toml")
    throw Error(ErrorCode::usage, arguments.plies,
                "is one argument too many; a " + kind + " file has its angles, plies.csv is for parts");
  if (!arguments.thickness.empty())
    arguments.thickness_mm = bounded("--thickness", arguments.thickness, 1e-4, 100, false);
  if (!arguments.feed.empty())
    arguments.feed_mm_per_min = bounded("--feed", arguments.feed, 1e-3, 1e7, false);
  if (!arguments.friction.empty())
    arguments.friction_ratio = bounded("--friction", arguments.friction, 0, 1, false);
}

void check_machine(const WindArguments& arguments) {
  const std::string& how = arguments.over_speed;
  if (!how.empty() && how != "refuse" && how != "clamp")
    throw Error(ErrorCode::usage, "--over-speed", "'" + printable(how) + "' is unknown; use clamp or refuse");
  if (arguments.command == WindArguments::Command::simulate) return;
  const bool vessel = is_vessel(arguments);
  for (const auto& [flag, text] :
       {std::pair{"--machine", &arguments.machine}, {"--over-speed", &arguments.over_speed}}) {
    if (!vessel && !text->empty())
      throw Error(ErrorCode::usage, flag, "is for windings of a vessel (.toml); leave it out");
  }
  if (vessel && arguments.fiberpath)
    throw Error(ErrorCode::usage, "--fiberpath", "is for .wind files; leave it out");
}

// The asked angle from the axis.
std::optional<double> asked_angle(const WindArguments& arguments) {
  const std::string& from = arguments.angle_from;
  if (!from.empty() && from != "axis" && from != "hoop")
    throw Error(ErrorCode::usage, "--angle-from", "'" + printable(from) + "' is unknown; use axis or hoop");
  if (arguments.angle.empty()) {
    if (!from.empty()) throw Error(ErrorCode::usage, "--angle-from", "needs --angle; give the winding angle");
    return std::nullopt;
  }
  const double angle = bounded("--angle", arguments.angle, 0.1, 89.9, false);
  return from == "hoop" ? 90 - angle : angle;
}

}  // namespace

CLI::App* add_wind_commands(CLI::App& app, WindArguments& arguments, const WindFlags& flags) {
  CLI::App* wind =
      app.add_subcommand("wind", "Filament winding: machine programs for tubes (.wind) and vessels (.toml).");
  wind->footer(wind_examples);

  CLI::App* validate =
      add_command(*wind, "validate", "Says whether a .wind or vessel file can be wound.", arguments);
  validate->footer(
      "Examples:\n  afptraj wind validate vessel.wind\n"
      "  afptraj wind validate vessel.wind --fiberpath --json");
  add_machine(*validate, arguments);
  validate->add_flag("--json", *flags.json, "for machines");

  CLI::App* plan =
      add_command(*wind, "plan", "Writes the machine program of a .wind or vessel file.", arguments);
  plan->footer(
      "Examples:\n  afptraj wind plan vessel.wind -o program.gcode\n"
      "  afptraj wind plan vessel.wind --fiberpath --json > summary.json\n"
      "  afptraj wind plan vessel.toml --machine winder.toml --over-speed refuse");
  add_machine(*plan, arguments);
  add_plies(*plan, arguments);
  plan->add_option("-o,--output", arguments.output, "the program [<file>.gcode]")->type_name("FILE");
  plan->add_flag("--force", *flags.force, "replace an earlier program");
  plan->add_flag("--json", *flags.json, "print a summary for machines instead of a table");
  plan->add_flag("-q,--quiet", *flags.quiet, "print errors only");

  CLI::App* simulate =
      wind->add_subcommand("simulate", "Rebuilds what a program lays: coverage, gaps, lengths, time.");
  simulate->footer(
      "Examples:\n  afptraj wind simulate program.gcode\n  afptraj wind simulate program.gcode --json");
  simulate->add_option("file", arguments.file, "the program")->type_name("program.gcode");
  simulate
      ->add_option(
          "--machine", arguments.machine,
          "of a vessel's program: tell where an axis is too fast for this machine, or leaves its travel")
      ->type_name("machine.toml");
  simulate->add_flag("--json", *flags.json, "for machines");

  CLI::App* plot = wind->add_subcommand("plot", "Draws what a program lays, on the unrolled mandrel (SVG).");
  plot->footer(
      "Examples:\n  afptraj wind plot program.gcode\n  afptraj wind plot program.gcode --layer 2 -o "
      "layer2.svg");
  plot->add_option("file", arguments.file, "the program")->type_name("program.gcode");
  plot->add_option("--layer", arguments.layer_text, "draw this layer only, from 1 [all]")->type_name("N");
  plot->add_option("-o,--output", arguments.output, "the picture [<file>.svg]")->type_name("FILE");
  plot->add_flag("--force", *flags.force, "replace an earlier picture");
  plot->add_flag("-q,--quiet", *flags.quiet, "print errors only");

  CLI::App* patterns =
      add_command(*wind, "patterns", "Lists helical patterns that close, best first.", arguments);
  patterns->footer(
      "Examples:\n  afptraj wind patterns vessel.wind --angle 54.7 --tolerance 2\n"
      "  afptraj wind patterns meridian.csv --angle 20 --tow-width 8\n\n"
      "Angles are listed from the axis. A closing pattern puts every start at its place and\n"
      "leaves no bare strip.");
  add_angle(*patterns, arguments, "winding angle [that of the first helical layer]");
  patterns->add_option("--tolerance", arguments.tolerance, "angles may be off by so much [2]")
      ->type_name("DEG");
  patterns
      ->add_option("--overlap", arguments.overlap,
                   "of a mandrel without .wind file: most overlap of tows [10]")
      ->type_name("PERCENT");
  patterns
      ->add_option("--tow-width", arguments.tow_width, "of a mandrel without .wind file: width of the tow")
      ->type_name("MM");
  patterns
      ->add_option("--face", arguments.faces,
                   "of a part: the faces of the mandrel, by number [all but planes]")
      ->type_name("LIST");
  patterns->add_flag("--json", *flags.json, "for machines");

  CLI::App* inspect =
      wind->add_subcommand("inspect", "Tells a mandrel's measures, and how a geodesic runs on it.");
  inspect->footer(
      "Examples:\n  afptraj wind inspect meridian.csv --angle 20\n"
      "  afptraj wind inspect part.step --face 2-4 --angle 20\n"
      "  afptraj wind inspect meridian.csv --angle 20 --points 200 --json\n\n"
      "A meridian is a table with the columns z and r; a row that stands twice is a corner.\n"
      "The angle is that at the widest place, measured from the axis.");
  inspect
      ->add_option("file", arguments.file, "the mandrel: meridian.csv, vessel.wind, vessel.toml or part.step")
      ->type_name("meridian.csv");
  add_angle(*inspect, arguments, "winding angle of a geodesic");
  inspect->add_option("--points", arguments.point_count, "with --json: list its path in so many pieces")
      ->type_name("N");
  inspect
      ->add_option("--face", arguments.faces,
                   "of a part: the faces of the mandrel, by number [all but planes]")
      ->type_name("LIST");
  inspect->add_flag("--json", *flags.json, "for machines");
  return wind;
}

void finish_wind(const CLI::App& command, WindArguments& arguments) {
  using Command = WindArguments::Command;
  static const std::map<std::string, Command> commands{
      {"validate", Command::validate}, {"plan", Command::plan},         {"simulate", Command::simulate},
      {"plot", Command::plot},         {"patterns", Command::patterns}, {"inspect", Command::inspect}};
  arguments.command = commands.at(command.get_name());
  const std::string name = "afptraj wind " + command.get_name();
  if (arguments.file.empty()) {
    const char* wanted = arguments.command == Command::simulate || arguments.command == Command::plot
                             ? "program"
                         : arguments.command == Command::inspect ? "mandrel"
                                                                 : ".wind file";
    throw Error(ErrorCode::usage, name, std::string("needs a ") + wanted + "; see " + name + " --help");
  }
  check_machine(arguments);
  check_plies(arguments);
  arguments.angle_deg = asked_angle(arguments);
  if (!arguments.overlap.empty())
    arguments.most_overlap = bounded("--overlap", arguments.overlap, 0, 100, false) / 100;
  if (!arguments.tow_width.empty())
    arguments.tow_width_mm = bounded("--tow-width", arguments.tow_width, 0.01, 1000, false);
  if (!arguments.tolerance.empty())
    arguments.tolerance_deg = bounded("--tolerance", arguments.tolerance, 0, 45, false);
  if (!arguments.layer_text.empty())
    arguments.layer = static_cast<int>(bounded("--layer", arguments.layer_text, 1, 1000000, true));
  if (!arguments.point_count.empty())
    arguments.points = static_cast<int>(bounded("--points", arguments.point_count, 1, 1000000, true));
  if (arguments.points > 0 && !arguments.angle_deg)
    throw Error(ErrorCode::usage, "--points", "needs --angle; give the winding angle");
}

}  // namespace afptraj::cli
