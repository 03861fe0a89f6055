#include <nlohmann/json.hpp>

#include "cli/terminal.h"
#include "cli/wind_commands.h"

namespace afptraj::cli {
namespace {

using Json = nlohmann::ordered_json;

double time_of(const SimulatedMachineProgram& program) {
  double time = 0;
  for (const SimulatedMachineLayer& layer : program.layers) time += layer.time_s;
  return time;
}

double length_of(const SimulatedMachineProgram& program) {
  double length = 0;
  for (const SimulatedMachineLayer& layer : program.layers) length += layer.laid.laid_mm;
  return length;
}

std::int64_t moves_of(const SimulatedMachineProgram& program) {
  std::int64_t moves = 0;
  for (const SimulatedMachineLayer& layer : program.layers) moves += layer.moves;
  return moves;
}

std::string json_text(const SimulatedMachineProgram& program) {
  Json layers = Json::array();
  for (const SimulatedMachineLayer& layer : program.layers) {
    const LaidTravel& laid = layer.laid;
    Json entry = {{"layer", layer.name},
                  {"moves", layer.moves},
                  {"idle_moves", layer.idle_moves},
                  {"backward_turns", layer.backward_turns},
                  {"time_s", layer.time_s},
                  {"laid_m", laid.laid_mm / 1000},
                  {"starts", laid.starts},
                  {"start_error_deg", laid.start_error_deg},
                  {"covered_share", laid.coverage.covered_share},
                  {"overlap_share", laid.coverage.overlap_share},
                  {"widest_gap_mm", laid.coverage.widest_gap_mm}};
    if (laid.coverage.widest_gap_mm > 0)
      entry["widest_gap_at"] = {{"z_mm", laid.coverage.gap_z_mm}, {"mandrel_deg", laid.coverage.gap_deg}};
    entry["one_way_covered_share"] = laid.one_way.covered_share;
    entry["one_way_gap_mm"] = laid.one_way.widest_gap_mm;
    entry["openings_mm"] = {laid.least_r_first_mm, laid.least_r_last_mm};
    entry["free_length_mm"] = {laid.least_free_mm, laid.most_free_mm};
    entry["clearance_mm"] = laid.least_clearance_mm;
    layers.push_back(entry);
  }
  const double time = time_of(program), length = length_of(program);
  const Json out = {{"commands_executed", program.commands},
                    {"moves", moves_of(program)},
                    {"estimated_time_s", time},
                    {"total_distance_mm", length},
                    {"tow_length_mm", length},
                    {"average_feed_rate_mmpm", time > 0 ? length / time * 60 : 0.0},
                    {"layers", layers}};
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string table_text(const SimulatedMachineProgram& program) {
  Table table(
      {"layer", "covered %", "one way %", "overlap %", "one-way gap mm", "at z mm", "starts",
       "start error deg", "backward", "idle", "openings mm", "thread mm", "clearance mm", "laid m", "time s"},
      {false, true, true, true, true, true, true, true, true, true, true, true, true, true, true});
  for (const SimulatedMachineLayer& layer : program.layers) {
    const LaidTravel& laid = layer.laid;
    table.add({layer.name, short_number(100 * laid.coverage.covered_share),
               short_number(100 * laid.one_way.covered_share),
               short_number(100 * laid.coverage.overlap_share), short_number(laid.one_way.widest_gap_mm),
               laid.one_way.widest_gap_mm > 0 ? short_number(laid.one_way.gap_z_mm) : "",
               std::to_string(laid.starts), short_number(laid.start_error_deg, 2),
               std::to_string(layer.backward_turns), std::to_string(layer.idle_moves),
               short_number(laid.least_r_first_mm) + ", " + short_number(laid.least_r_last_mm),
               short_number(laid.least_free_mm) + " ... " + short_number(laid.most_free_mm),
               short_number(laid.least_clearance_mm), short_number(laid.laid_mm / 1000),
               short_number(layer.time_s)});
  }
  return table.text() + std::to_string(program.commands) + " commands, " + short_number(time_of(program)) +
         " s, " + short_number(length_of(program) / 1000) + " m of tow\n";
}

}  // namespace

int print_simulated(const SimulatedMachineProgram& program, const Arguments& arguments) {
  print(arguments.json ? json_text(program) : table_text(program));
  return 0;
}

}  // namespace afptraj::cli
