#pragma once

#include <CLI/CLI.hpp>

#include "cli/arguments.h"

namespace afptraj::cli {

/// Adds `wind` and its commands to the program's; they fill `arguments` and the shared flags.
struct WindFlags {
  bool *json, *quiet, *force;
};
CLI::App* add_wind_commands(CLI::App& app, WindArguments& arguments, const WindFlags& flags);

/// Judges what was given after parsing. `command` is the one chosen below `wind`. Throws Error(usage).
void finish_wind(const CLI::App& command, WindArguments& arguments);

}  // namespace afptraj::cli
