#pragma once

#include <CLI/CLI.hpp>

#include "cli/arguments.h"
#include "cli/wind_arguments.h"

namespace afptraj::cli {

/// Adds `fill` to the program's commands; it fills `arguments` and the shared flags.
CLI::App* add_fill_command(CLI::App& app, FillArguments& arguments, const WindFlags& flags);

/// Judges what was given after parsing. Throws Error(usage).
void finish_fill(FillArguments& arguments);

}  // namespace afptraj::cli
