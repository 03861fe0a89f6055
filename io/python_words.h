#pragma once

#include <string>

#include "io/json_reader.h"

namespace afptraj {

/// A JSON value as Python prints it, and the name of its Python type: FiberPath's messages show both.
std::string python_text(const JsonValue& value);
const char* python_type(const JsonValue& value);

/// The first 25 and the last 24 bytes of a long text, whole characters, with "..." between.
std::string python_excerpt(const std::string& text);

}  // namespace afptraj
