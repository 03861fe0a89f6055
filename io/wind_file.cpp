#include "io/wind_file.h"

#include <filesystem>
#include <system_error>

#include "geometry/error.h"
#include "io/text_file.h"
#include "io/wind_schema.h"

namespace afptraj {
namespace {

constexpr std::size_t largest_file = 50'000'000;

// The bytes of a file, what is wrong with it in FiberPath's words.
std::string read_for_fiberpath(const std::string& path) {
  std::error_code problem;
  if (!std::filesystem::exists(path, problem))
    throw Error(ErrorCode::bad_input, path, "No wind definition found at " + path);
  try {
    return read_file(path, largest_file);
  } catch (const Error& e) {
    throw Error(e.code(), path, "Could not read wind definition at " + path + ": " + e.what());
  }
}

}  // namespace

WindDefinition read_wind_file(const std::string& path, WindMode mode) {
  if (mode == WindMode::fiberpath) return read_fiberpath_wind(path, read_for_fiberpath(path));
  return read_native_wind(path, read_text_file(path, largest_file));
}

}  // namespace afptraj
