#pragma once

#include <string>

#include "winding/meridian.h"

namespace afptraj {

/// Reads a meridian: a CSV table with the columns z and r (mm), z growing; a row that stands twice is a
/// corner (winding/meridian.h). Throws Error(bad_input, "file:line" or file, what is wrong; what to do).
Meridian read_meridian(const std::string& path);

}  // namespace afptraj
