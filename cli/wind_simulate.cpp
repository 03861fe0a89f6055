#include <nlohmann/json.hpp>

#include "cli/part_file.h"
#include "cli/terminal.h"
#include "cli/wind_commands.h"
#include "geometry/error.h"
#include "io/program_file.h"
#include "io/text_file.h"

namespace afptraj::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t largest_program = 4'000'000'000;  // bytes

std::string json_text(const SimulatedProgram& program) {
  Json layers = Json::array();
  for (const SimulatedLayer& layer : program.layers) {
    Json entry = {{"layer", layer.name},
                  {"moves", layer.moves},
                  {"idle_moves", layer.idle_moves},
                  {"backward_turns", layer.backward_turns},
                  {"time_s", layer.time_s},
                  {"laid_m", layer.laid_mm / 1000},
                  {"turned_m", layer.turned_mm / 1000},
                  {"starts", layer.starts},
                  {"start_error_deg", layer.start_error_deg}};
    if (layer.coverage) {
      entry["covered_share"] = layer.coverage->covered_share;
      entry["overlap_share"] = layer.coverage->overlap_share;
      entry["widest_gap_mm"] = layer.coverage->widest_gap_mm;
      if (layer.coverage->widest_gap_mm > 0)
        entry["widest_gap_at"] = {{"z_mm", layer.coverage->gap_z_mm},
                                  {"mandrel_deg", layer.coverage->gap_deg}};
    }
    layers.push_back(entry);
  }
  const double time = program.time_s(), length = program.length_mm();
  const Json out = {{"commands_executed", program.commands},
                    {"moves", program.moves()},
                    {"estimated_time_s", time},
                    {"total_distance_mm", length},
                    {"tow_length_mm", length},
                    {"average_feed_rate_mmpm", time > 0 ? length / time * 60 : 0.0},
                    {"layers", layers}};
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string table_text(const SimulatedProgram& program) {
  Table table({"layer", "covered %", "overlap %", "widest gap mm", "at z mm", "starts", "start error deg",
               "backward", "idle", "laid m", "turned m", "time s"},
              {false, true, true, true, true, true, true, true, true, true, true, true});
  for (const SimulatedLayer& layer : program.layers) {
    const auto& coverage = layer.coverage;
    const auto of_coverage = [&](double BandCoverage::*member, double scale) {
      return coverage ? short_number((*coverage).*member * scale) : "";
    };
    const bool gap = coverage && coverage->widest_gap_mm > 0;
    table.add({layer.name, of_coverage(&BandCoverage::covered_share, 100),
               of_coverage(&BandCoverage::overlap_share, 100), of_coverage(&BandCoverage::widest_gap_mm, 1),
               gap ? short_number(coverage->gap_z_mm) : "", std::to_string(layer.starts),
               short_number(layer.start_error_deg, 2), std::to_string(layer.backward_turns),
               std::to_string(layer.idle_moves), short_number(layer.laid_mm / 1000),
               short_number(layer.turned_mm / 1000), short_number(layer.time_s)});
  }
  return table.text() + std::to_string(program.commands) + " commands, " + short_number(program.time_s()) +
         " s, " + short_number(program.length_mm() / 1000) + " m of tow\n";
}

}  // namespace

int wind_simulate(const Arguments& arguments) {
  const std::string& file = arguments.wind.file;
  const std::string text = read_file(file, largest_program);
  if (is_machine_program(text))
    return print_simulated(simulate_machine_text(file, text, check_stop), arguments);
  if (!arguments.wind.machine.empty())
    throw Error(ErrorCode::usage, "--machine", "is for programs of vessels (.toml); leave it out");
  const SimulatedProgram program = simulate_text(file, text, check_stop);
  print(arguments.json ? json_text(program) : table_text(program));
  return 0;
}

}  // namespace afptraj::cli
