#include <nlohmann/json.hpp>

#include "cli/terminal.h"
#include "cli/wind_commands.h"
#include "geometry/error.h"

namespace afptraj::cli {
namespace {

std::string json_line(const nlohmann::ordered_json& json) {
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace

int wind_validate(const Arguments& arguments) {
  const std::string& file = arguments.wind.file;
  try {
    read_sound_definition(arguments.wind);
  } catch (const Error& e) {
    // the whole message, which on stderr stands on one line
    if (arguments.json) print(json_line({{"status", "error"}, {"path", file}, {"message", e.what()}}));
    throw;
  }
  print(arguments.json ? json_line({{"status", "ok"}, {"path", file}}) : file + " is valid.\n");
  return 0;
}

}  // namespace afptraj::cli
