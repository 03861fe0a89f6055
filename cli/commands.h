#pragma once

#include "cli/arguments.h"

namespace afptraj::cli {

/// The commands; each returns its exit code, 0 or (run --strict) 1, and throws for everything else.
int run(const Arguments& arguments);
int inspect(const Arguments& arguments);
int wind(const Arguments& arguments);
int fill(const Arguments& arguments);
int doctor(const Arguments& arguments);

}  // namespace afptraj::cli
