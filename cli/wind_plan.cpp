#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "cli/part_file.h"
#include "cli/terminal.h"
#include "cli/wind_commands.h"
#include "io/output_file.h"
#include "winding/plan_program.h"

namespace afptraj::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr double mm_per_m = 1000;

bool is_terminal(const WindLayer& layer) {
  const auto* hoop = std::get_if<HoopLayer>(&layer);
  return hoop != nullptr && hoop->terminal;
}

// The shape of FiberPath's summary, with what it does not tell apart at the end of each layer.
std::string summary_json(const std::string& output, const WindDefinition& definition,
                         const ProgramReport& report) {
  Json layers = Json::array();
  double time = 0, tow = 0;
  for (std::size_t i = 0; i < report.layers.size(); ++i) {
    const LayerReport& layer = report.layers[i];
    const double layer_time = report.time_s(layer.totals),
                 layer_tow = layer.totals.total_length_mm() / mm_per_m;
    time += layer_time;
    tow += layer_tow;
    Json entry = {{"index", i + 1},
                  {"wind_type", layer_name(definition.layers[i])},
                  {"commands", layer.totals.lines},
                  {"time_s", layer_time},
                  {"cumulative_time_s", time},
                  {"tow_m", layer_tow},
                  {"cumulative_tow_m", tow},
                  {"terminal", is_terminal(definition.layers[i])},
                  {"laid_m", layer.totals.length_mm[0] / mm_per_m},
                  {"turned_m", layer.totals.length_mm[1] / mm_per_m},
                  {"repositioned_m", layer.totals.length_mm[2] / mm_per_m}};
    if (layer.circuits > 0) {
      entry["circuits"] = layer.circuits;
      entry["overlap"] = layer.overlap;
    }
    layers.push_back(entry);
  }
  const Json out = {{"output", output},
                    {"commands", report.totals.lines},
                    {"timeSeconds", report.time_s(report.totals)},
                    {"towMeters", report.totals.total_length_mm() / mm_per_m},
                    {"layers", layers}};
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string summary_table(const std::string& output, const WindDefinition& definition,
                          const ProgramReport& report) {
  Table table(
      {"layer", "type", "circuits", "overlap %", "lines", "time s", "laid m", "turned m", "repositioned m"},
      {true, false, true, true, true, true, true, true, true});
  for (std::size_t i = 0; i < report.layers.size(); ++i) {
    const LayerReport& layer = report.layers[i];
    const bool helical = layer.circuits > 0;
    const auto metres = [&](std::size_t purpose) {
      return short_number(layer.totals.length_mm[purpose] / mm_per_m);
    };
    table.add({std::to_string(i + 1), layer_name(definition.layers[i]),
               helical ? std::to_string(layer.circuits) : "",
               helical ? short_number(100 * layer.overlap, 3) : "", std::to_string(layer.totals.lines),
               short_number(report.time_s(layer.totals)), metres(0), metres(1), metres(2)});
  }
  return table.text() + "wrote " + output + ": " + std::to_string(report.totals.lines) + " lines, " +
         short_number(report.time_s(report.totals)) + " s, " +
         short_number(report.totals.total_length_mm() / mm_per_m) + " m of tow\n";
}

std::string output_path(const WindArguments& arguments) {
  if (!arguments.output.empty()) return arguments.output;
  return arguments.fiberpath ? "output.gcode"
                             : std::filesystem::path(arguments.file).stem().string() + ".gcode";
}

}  // namespace

int wind_plan(const Arguments& arguments) {
  const WindArguments& wind = arguments.wind;
  const WindDefinition definition = read_sound_definition(wind);
  const std::string target = output_path(wind);
  // FiberPath's users count on its making directories, and on a second run replacing the first.
  if (wind.fiberpath) {
    std::error_code told_by_the_output;
    std::filesystem::create_directories(std::filesystem::path(target).parent_path(), told_by_the_output);
  }
  OutputFile output(target, arguments.force || wind.fiberpath, {wind.file});
  const ProgramReport report = write_program(definition, wind_mode(wind), [&](std::string_view piece) {
    check_stop();
    output.write(piece);
  });
  output.commit();
  if (arguments.json) {
    print(summary_json(target, definition, report));
  } else if (!arguments.quiet) {
    print(summary_table(target, definition, report));
  }
  return 0;
}

}  // namespace afptraj::cli
