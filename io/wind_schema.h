#pragma once

#include <string>
#include <string_view>

#include "winding/wind_definition.h"

namespace afptraj {

/// The two readings of a `.wind` text; `path` is for messages.
WindDefinition read_native_wind(const std::string& path, const std::string& text);
WindDefinition read_fiberpath_wind(const std::string& path, const std::string& text);

/// Whether a schema version is one of ours: "1." and digits.
bool is_known_schema(std::string_view version);

}  // namespace afptraj
