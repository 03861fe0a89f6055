#include <nlohmann/json.hpp>

#include "cli/terminal.h"
#include "cli/wind_commands.h"
#include "geometry/error.h"
#include "io/wind_file.h"
#include "winding/number_words.h"
#include "winding/pattern_search.h"

namespace afptraj::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t shown_rows = 20;

const HelicalLayer* first_helical(const WindDefinition& definition) {
  for (const WindLayer& layer : definition.layers) {
    if (const auto* helical = std::get_if<HelicalLayer>(&layer)) return helical;
  }
  return nullptr;
}

PatternQuery query_of(const WindArguments& arguments, const WindDefinition& definition) {
  const HelicalLayer* helical = first_helical(definition);
  PatternQuery query;
  if (arguments.angle_deg) {
    query.angle_deg = *arguments.angle_deg;
  } else if (helical != nullptr) {
    query.angle_deg = helical->angle_deg;
  } else {
    throw Error(ErrorCode::usage, "--angle",
                "is missing, and the file has no helical layer; give the winding angle");
  }
  query.tolerance_deg = arguments.tolerance_deg;
  if (helical != nullptr) query.lock_deg = helical->lock_deg;
  return query;
}

std::string json_text(const PatternQuery& query, const std::vector<FoundPattern>& found) {
  Json rows = Json::array();
  for (const FoundPattern& pattern : found) {
    rows.push_back({{"windAngle", pattern.angle_deg},
                    {"angle_error_deg", pattern.angle_deg - query.angle_deg},
                    {"circuits", pattern.circuits},
                    {"patternNumber", pattern.pattern},
                    {"skipIndex", pattern.skip},
                    {"lockDegrees", pattern.lock_deg},
                    {"overlap", pattern.overlap},
                    {"coverage", 1 + pattern.overlap},
                    {"crossings", pattern.crossings},
                    {"fiberpath", pattern.fiberpath}});
  }
  const Json out = {
      {"angle_deg", query.angle_deg}, {"tolerance_deg", query.tolerance_deg}, {"patterns", rows}};
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string table_text(const PatternQuery& query, const std::vector<FoundPattern>& found) {
  Table table({"windAngle", "error deg", "circuits", "patternNumber", "skipIndex", "lockDegrees", "overlap %",
               "crossings", "FiberPath"},
              {true, true, true, true, true, true, true, true, false});
  for (std::size_t i = 0; i < std::min(found.size(), shown_rows); ++i) {
    const FoundPattern& pattern = found[i];
    table.add({short_number(pattern.angle_deg, 6), short_number(pattern.angle_deg - query.angle_deg, 4),
               std::to_string(pattern.circuits), std::to_string(pattern.pattern),
               std::to_string(pattern.skip), short_number(pattern.lock_deg),
               short_number(100 * pattern.overlap, 3), std::to_string(pattern.crossings),
               pattern.fiberpath ? "yes" : "no"});
  }
  std::string text = table.text();
  if (found.size() > shown_rows)
    text += "and " + std::to_string(found.size() - shown_rows) + " more; --json lists all\n";
  return text;
}

}  // namespace

int wind_patterns(const Arguments& arguments) {
  // the file says it, or native planning does
  for (const auto& [flag, text] : {std::pair{"--tow-width", &arguments.wind.tow_width},
                                   {"--overlap", &arguments.wind.overlap},
                                   {"--face", &arguments.wind.faces}}) {
    if (!text->empty())
      throw Error(ErrorCode::usage, flag, "is for mandrels without a .wind file; leave it out");
  }
  const WindDefinition definition = read_wind_file(arguments.wind.file, wind_mode(arguments.wind));
  const PatternQuery query = query_of(arguments.wind, definition);
  const double steepest = steepest_angle_deg(definition.mandrel);
  if (query.angle_deg - query.tolerance_deg > steepest) {
    throw Error(ErrorCode::no_path, arguments.wind.file,
                "a winding angle of " + shortest_text(query.angle_deg) +
                    "° does not reach the small end of the cone; the steepest possible is " +
                    significant_text(steepest, 6) + "°");
  }
  const std::vector<FoundPattern> found = find_patterns(definition.mandrel, definition.tow, query);
  if (found.empty()) {
    throw Error(ErrorCode::no_path, arguments.wind.file,
                "no pattern closes within the tolerance; give a larger --tolerance");
  }
  print(arguments.json ? json_text(query, found) : table_text(query, found));
  return 0;
}

}  // namespace afptraj::cli
