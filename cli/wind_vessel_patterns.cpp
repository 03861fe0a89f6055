#include <algorithm>
#include <cmath>

#include "cli/mandrel_file.h"
#include "cli/terminal.h"
#include "cli/wind_commands.h"
#include "geometry/error.h"
#include "winding/vessel_patterns.h"

namespace afptraj::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t shown_rows = 20;

// The flags; what they do not say is that of a vessel's file and its first layer.
VesselQuery query_of(const WindArguments& arguments) {
  VesselQuery query;
  query.tolerance_deg = arguments.tolerance_deg;
  query.most_overlap = arguments.most_overlap;
  std::optional<double> angle_deg = arguments.angle_deg, tow_width_mm = arguments.tow_width_mm;
  if (is_vessel(arguments)) {
    const VesselFile vessel = read_vessel(arguments.file);
    const auto helical = std::find_if(vessel.layers.begin(), vessel.layers.end(),
                                      [](const VesselLayer& layer) { return !layer.hoop; });
    const VesselLayer layer = helical == vessel.layers.end() ? VesselLayer{} : *helical;
    if (helical == vessel.layers.end() && !angle_deg)
      throw Error(ErrorCode::usage, arguments.file, "has no helical layer; give --angle");
    if (!angle_deg) angle_deg = layer.angle_deg;
    if (!tow_width_mm) tow_width_mm = vessel.tow.width_mm;
    query.steering = layer.steering;
  }
  if (!angle_deg)
    throw Error(ErrorCode::usage, "--angle", "is missing; give the winding angle at the widest place");
  if (!tow_width_mm) throw Error(ErrorCode::usage, "--tow-width", "is missing; give the width of the tow");
  query.angle_deg = *angle_deg;
  query.tow_width_mm = *tow_width_mm;
  return query;
}

double friction_of(const VesselPattern& pattern) {
  return std::max(std::abs(pattern.ratio_first), std::abs(pattern.ratio_last));
}

std::string json_text(const VesselQuery& query, const std::vector<VesselPattern>& found) {
  Json rows = Json::array();
  for (const VesselPattern& pattern : found) {
    rows.push_back({{"windAngle", pattern.angle_deg},
                    {"angle_error_deg", pattern.angle_deg - query.angle_deg},
                    {"circuits", pattern.circuits},
                    {"starts", pattern.starts},
                    {"leading", pattern.leading},
                    {"stride", pattern.stride},
                    {"turn_deg", pattern.turn_deg},
                    {"length_mm", pattern.length_mm},
                    {"openings_mm", {pattern.opening_first_mm, pattern.opening_last_mm}},
                    {"friction", friction_of(pattern)},
                    {"overlap", pattern.overlap}});
  }
  const Json out = {{"angle_deg", query.angle_deg},
                    {"tolerance_deg", query.tolerance_deg},
                    {"tow_width_mm", query.tow_width_mm},
                    {"patterns", rows}};
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string table_text(const VesselQuery& query, const std::vector<VesselPattern>& found) {
  Table table({"windAngle", "error deg", "circuits", "starts", "", "turn deg", "tow m", "openings mm",
               "friction", "overlap %"},
              {true, true, true, true, false, true, true, true, true, true});
  for (std::size_t i = 0; i < std::min(found.size(), shown_rows); ++i) {
    const VesselPattern& pattern = found[i];
    table.add({short_number(pattern.angle_deg, 8), short_number(pattern.angle_deg - query.angle_deg, 4),
               std::to_string(pattern.circuits), std::to_string(pattern.starts),
               pattern.leading ? "leading" : "lagging", short_number(pattern.turn_deg, 8),
               short_number(pattern.length_mm * static_cast<double>(pattern.circuits) / 1000),
               short_number(pattern.opening_first_mm) + ", " + short_number(pattern.opening_last_mm),
               short_number(friction_of(pattern), 3), short_number(100 * pattern.overlap, 3)});
  }
  std::string text = table.text();
  if (found.size() > shown_rows)
    text += "and " + std::to_string(found.size() - shown_rows) + " more; --json lists all\n";
  return text;
}

}  // namespace

int wind_vessel_patterns(const Arguments& arguments) {
  const VesselQuery query = query_of(arguments.wind);
  const MandrelFile mandrel = read_mandrel(arguments.wind);
  const std::vector<VesselPattern> found = find_vessel_patterns(mandrel.meridian, query);
  if (found.empty())
    throw Error(ErrorCode::no_path, arguments.wind.file, patterns_refusal(mandrel.meridian, query));
  print(arguments.json ? json_text(query, found) : table_text(query, found));
  return 0;
}

}  // namespace afptraj::cli
