#pragma once

#include <string>

#include "winding/wind_definition.h"

namespace afptraj {

/// Reads a `.wind` file (docs/winding.md, "The .wind file").
///
/// Native: every key must be known and stand once, numbers must be numbers. Throws Error(bad_input,
/// "file:line:column", what is wrong; what to do), naming the nearest key for an unknown one.
///
/// FiberPath mode: names in camelCase or snake_case, unknown keys ignored, the last of repeated keys wins,
/// numbers and truth values also as text. Throws Error(bad_input, file, FiberPath's message), which
/// may have several lines.
WindDefinition read_wind_file(const std::string& path, WindMode mode);

}  // namespace afptraj
