#include "cli/arguments.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <list>

#include "cli/fill_arguments.h"
#include "cli/wind_arguments.h"
#include "geometry/error.h"
#include "io/nearest_name.h"
#include "io/number_text.h"
#include "io/text_file.h"

namespace afptraj::cli {
namespace {

constexpr int greatest_threads = 1024;

[[noreturn]] void wrong(const std::string& where, const std::string& message) {
  throw Error(ErrorCode::usage, where, message);
}

// The flags that set a key of the job.
struct FlagSpec {
  const char* flag;
  const char* key;
  const char* value;
  const char* help;
};
constexpr FlagSpec output_flag{"-o,--output", "output.directory", "DIR", "result directory [<part>-afptraj]"};
constexpr FlagSpec unit_flag{"--unit", "input.unit", "UNIT",
                             "unit of the STEP file's numbers, whatever it declares: mm cm m in ft"};
constexpr FlagSpec sew_flag{"--sew", "input.sew_tolerance", "MM",
                            "join loose edges nearer than this; 0: none [1e-4 of the part]"};
constexpr FlagSpec run_flags[] = {
    {"--face", "faces.list", "LIST", "faces to lay on, by number: 3,5-9"},
    {"--face-name", "faces.name", "NAME", "faces to lay on, by name"},
    {"--tangent-from", "faces.tangent_from", "LIST", "these faces and what is reached over smooth edges"},
    {"--tangent-angle", "faces.tangent_angle", "DEG", "an edge is smooth below this angle [5]"},
    {"--tow-width", "material.tow_width", "MM", "width of one tow [6.35]"},
    {"--tows", "head.tows", "N", "tows side by side [8]"},
    {"--min-cut-length", "head.min_cut_length", "MM", "shortest piece of a tow [101.6]"},
    {"--short-tows", "head.short_tows", "HOW", "shorter pieces: symmetric, forward, backward, drop [symmetric]"},
    {"--min-gap", "head.min_gap", "MM", "shortest gap in a tow; shorter ones are laid through [25]"},
    {"--coverage-rule", "planning.coverage_rule", "%", "a tow is cut when so much of its width has left the skin [50]"},
    {"--step", "planning.step", "MM", "greatest step of the reference path [2]"},
    {"--range", "planning.range", "MM", "reach of a ply point [one band width]"},
};

const char* const run_examples = R"(Examples:
  afptraj run panel.step plies.csv
  afptraj run part.step plies.csv -o result --face 3,5-9 --force
  afptraj run part.step plies.csv --tangent-from 3 --tow-width 12.7 --tows 4
  afptraj run part.step plies.csv --job job.toml --strict --json > summary.json

Faces are numbered as 'afptraj inspect' lists them. Without a choice, the tangent-connected
group of faces nearest to the ply points is laid on. A flag overrides the job file.
Exit codes: 0 done, 1 a limit is violated (--strict), 2 usage or job file, 3 bad input,
4 no feasible path, 5 cannot write, 6 resource limit, 70 a bug, 130 interrupted, 143 terminated.)";

const char* const main_examples = R"(Examples:
  afptraj run panel.step plies.csv      plan courses, write paths.csv, tows.csv, paths.step, summary.json
  afptraj inspect part.step             list the faces of a part
  afptraj wind plan vessel.wind         write the program of a filament winder
  afptraj fill slice.csv                fill a planar slice with paths
  afptraj doctor                        versions, processor, limits
  afptraj run --help                    all flags of a command)";

// The parser, with the texts that CLI11 fills in.
class Parser {
 public:
  Parser() : app_("afptraj plans automated fibre placement, filament winding and fills.", "afptraj") {
    app_.footer(main_examples);
    app_.allow_extras();
    app_.set_help_flag("-h,--help", "show this help");
    app_.add_flag("--version", version_, "show the version");
    add_run();
    add_inspect();
    doctor_ = app_.add_subcommand("doctor", "Versions, processor features, memory and limits.");
    doctor_->add_flag("--json", arguments_.json, "for machines");
    wind_ =
        add_wind_commands(app_, arguments_.wind, {&arguments_.json, &arguments_.quiet, &arguments_.force});
    fill_ = add_fill_command(app_, arguments_.fill, {&arguments_.json, &arguments_.quiet, &arguments_.force});
    configure(app_);
  }

  Arguments parse(int count, const char* const* words) {
    try {
      app_.parse(count, words);
    } catch (const CLI::CallForHelp&) {
      return help_of(chosen(app_));
    } catch (const CLI::ParseError& e) {
      refuse(e);
    }
    if (version_) {
      arguments_.command = Arguments::Command::version;
      return arguments_;
    }
    refuse_extras(app_);
    CLI::App* command = chosen(app_);
    if (command == nullptr)
      wrong("command line", "names no command; use " + commands_of(app_) + " (afptraj --help)");
    refuse_extras(*command);
    if (command == wind_) {
      command = chosen(*wind_);
      if (command == nullptr)
        wrong("afptraj wind", "names no command; use " + commands_of(*wind_) + " (afptraj wind --help)");
      refuse_extras(*command);
      arguments_.command = Arguments::Command::wind;
      finish_wind(*command, arguments_.wind);
    } else if (command == fill_) {
      arguments_.command = Arguments::Command::fill;
      finish_fill(arguments_.fill);
    } else {
      finish(command);
    }
    return arguments_;
  }

 private:
  void add_run() {
    run_ = app_.add_subcommand("run", "Plans courses on a surface from ply orientation points.");
    run_->footer(run_examples);
    run_->add_option("surface", arguments_.part, "STEP file: the part")->type_name("surface.step");
    run_->add_option("plies", arguments_.plies, "CSV file: ply,x,y,z,dx,dy,dz[,start]")
        ->type_name("plies.csv");
    add_job_flag(run_, output_flag);
    run_->add_option("--job", arguments_.job, "job file")->type_name("job.toml");
    for (const FlagSpec& flag : run_flags) add_job_flag(run_, flag);
    add_job_flag(run_, unit_flag);
    add_job_flag(run_, sew_flag);
    run_->add_option("--threads", threads_, "threads [all cores]")->type_name("N");
    run_->add_option("--timeout", timeout_, "stop after this time [never]")->type_name("S");
    run_->add_flag("--force", arguments_.force, "replace an earlier result");
    run_->add_flag("--coverage", arguments_.coverage, "find gaps and overlaps of the tows, write coverage.csv");
    run_->add_flag("--strict", arguments_.strict, "exit with 1 when a limit is violated");
    run_->add_flag("--json", arguments_.json, "print summary.json instead of a table");
    run_->add_flag("-q,--quiet", arguments_.quiet, "print errors only");
    run_->add_flag("-v,--verbose", arguments_.verbose, "print what is done, and its time");
  }

  void add_inspect() {
    inspect_ = app_.add_subcommand("inspect", "Lists the faces of a part.");
    inspect_->footer("Examples:\n  afptraj inspect part.step\n  afptraj inspect part.step --unit m --json");
    inspect_->add_option("part", arguments_.part, "STEP file")->type_name("part.step");
    inspect_->add_flag("--json", arguments_.json, "for machines");
    add_job_flag(inspect_, unit_flag);
    add_job_flag(inspect_, sew_flag);
    inspect_->add_option("--tangent-angle", tangent_angle_, "an edge is smooth below this angle [5]")
        ->type_name("DEG");
    inspect_->add_option("--timeout", timeout_, "stop after this time [never]")->type_name("S");
  }

  void add_job_flag(CLI::App* command, const FlagSpec& spec) {
    JobFlag& slot = slots_.emplace_back(JobFlag{long_name(spec.flag), spec.key, {}});
    CLI::Option* option = command->add_option(spec.flag, slot.text, spec.help)->type_name(spec.value);
    given_.emplace_back(option, &slot);
  }

  static std::string long_name(const std::string& flag) {
    const std::size_t comma = flag.find(',');
    return comma == std::string::npos ? flag : flag.substr(0, comma);
  }

  // The same habits for all commands, however deep.
  static void configure(CLI::App& parent) {
    for (CLI::App* command : all_commands(parent)) {
      command->allow_extras();
      command->fallthrough(false);
      command->set_help_flag("-h,--help", "show this help");
      configure(*command);
    }
  }

  static std::vector<CLI::App*> all_commands(CLI::App& parent) { return parent.get_subcommands({}); }
  static std::vector<std::string> command_names(const CLI::App& parent) {
    std::vector<std::string> names;
    for (const CLI::App* known : parent.get_subcommands([](const CLI::App*) { return true; }))
      names.push_back(known->get_name());
    return names;
  }

  // "run, inspect or doctor"
  static std::string commands_of(const CLI::App& parent) {
    const std::vector<std::string> names = command_names(parent);
    std::string text;
    for (std::size_t i = 0; i < names.size(); ++i)
      text += (i == 0 ? "" : i + 1 < names.size() ? ", " : " or ") + names[i];
    return text;
  }

  static CLI::App* chosen(const CLI::App& parent) {
    const auto commands = parent.get_subcommands();
    return commands.empty() ? nullptr : commands.front();
  }

  // What is typed to reach a command: "afptraj wind plan".
  static std::string full_name(const CLI::App& app) {
    const CLI::App* parent = app.get_parent();
    return parent == nullptr ? app.get_name() : full_name(*parent) + " " + app.get_name();
  }

  Arguments help_of(const CLI::App* command) {
    arguments_.command = Arguments::Command::help;
    if (command == wind_ && chosen(*wind_) != nullptr) command = chosen(*wind_);
    arguments_.help = (command == nullptr ? &app_ : command)->help();
    return arguments_;
  }

  static std::vector<std::string> flags_of(const CLI::App* command) {
    std::vector<std::string> names;
    for (const CLI::Option* option : command->get_options()) {
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
      for (const std::string& name : option->get_snames()) names.push_back("-" + name);
    }
    return names;
  }

  // What nothing took: an unknown command, an unknown flag, or one argument too many.
  static void refuse_extras(const CLI::App& app) {
    const std::vector<std::string> extras = app.remaining();
    if (extras.empty()) return;
    std::string extra = extras.front();
    const std::string help = full_name(app) + " --help";
    if (extra.size() > 1 && extra.front() == '-') {
      extra = extra.substr(0, extra.find('='));
      const std::string hint = did_you_mean(extra, flags_of(&app));
      wrong(printable(extra), "unknown flag" + (hint.empty() ? "; see " + help : hint));
    }
    const std::vector<std::string> names = command_names(app);
    if (names.empty()) wrong(printable(extra), "is one argument too many; see " + help);
    const std::string hint = did_you_mean(extra, names);
    wrong(printable(extra),
          "unknown command" + (hint.empty() ? "; use " + commands_of(app) + " (" + help + ")" : hint));
  }

  [[noreturn]] void refuse(const CLI::ParseError& e) const {
    std::string message = e.what();
    std::string where = "command line";
    const std::size_t colon = message.find(": ");
    if (colon != std::string::npos && message.rfind("-", 0) == 0) {
      where = message.substr(0, colon);
      message = message.substr(colon + 2);
    }
    if (dynamic_cast<const CLI::ArgumentMismatch*>(&e) != nullptr) {
      wrong(where, given_twice(message) ? "is given twice; give it once"
                                        : "needs a value; write " + where + " VALUE");
    }
    wrong(where, printable(message, 200) + "; see afptraj --help");
  }
  static bool given_twice(const std::string& message) {
    return message.find("at most") != std::string::npos || message.find("exactly 1") != std::string::npos ||
           message.find("Expected 1") != std::string::npos;
  }

  void finish(const CLI::App* command) {
    if (command == doctor_) {
      arguments_.command = Arguments::Command::doctor;
      return;
    }
    const bool run = command == run_;
    arguments_.command = run ? Arguments::Command::run : Arguments::Command::inspect;
    if (arguments_.part.empty()) {
      wrong("afptraj " + command->get_name(), run ? "needs surface.step and plies.csv; see afptraj run --help"
                                                  : "needs a STEP file; see afptraj inspect --help");
    }
    if (run && arguments_.plies.empty())
      wrong("afptraj run", "needs plies.csv after the STEP file; see afptraj run --help");
    if (arguments_.quiet && arguments_.verbose) wrong("-q", "contradicts -v; keep one");
    for (const auto& [option, slot] : given_) {
      if (option->count() > 0) arguments_.job_flags.push_back(*slot);
    }
    if (!threads_.empty())
      arguments_.threads = static_cast<int>(bounded("--threads", threads_, 1, greatest_threads, true));
    if (!timeout_.empty()) arguments_.timeout_s = bounded("--timeout", timeout_, 0.001, 1e6, false);
    if (!run && !tangent_angle_.empty())
      arguments_.tangent_angle_deg = bounded("--tangent-angle", tangent_angle_, 0, 180, false);
  }

  CLI::App app_;
  CLI::App *run_ = nullptr, *inspect_ = nullptr, *wind_ = nullptr, *fill_ = nullptr, *doctor_ = nullptr;
  Arguments arguments_;
  bool version_ = false;
  std::string threads_, timeout_, tangent_angle_;
  std::list<JobFlag> slots_;  // a list: CLI11 keeps references to the texts
  std::vector<std::pair<const CLI::Option*, const JobFlag*>> given_;
};

}  // namespace

double bounded(const std::string& flag, const std::string& text, double lo, double hi, bool whole) {
  const auto x = parse_number(text);
  const std::string range = number_text(lo) + " ... " + number_text(hi);
  if (!x || (whole && *x != std::floor(*x))) {
    wrong(flag, "'" + printable(text) + "' is not a " + (whole ? "whole " : "") + "number; it must lie in " +
                    range);
  }
  if (*x < lo || *x > hi) wrong(flag, printable(text) + " is out of range; it must lie in " + range);
  return *x;
}

Arguments parse_arguments(int count, const char* const* words) { return Parser().parse(count, words); }

}  // namespace afptraj::cli
