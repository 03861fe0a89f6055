#pragma once

#include <string>
#include <utility>
#include <vector>

namespace afptraj::cli {

/// afptraj's own version, "0.1.0".
const char* version();

/// afptraj and the libraries it was built with: name, version.
std::vector<std::pair<std::string, std::string>> versions();

/// Compiler and kind of build, for people.
std::string compiler();

}  // namespace afptraj::cli
