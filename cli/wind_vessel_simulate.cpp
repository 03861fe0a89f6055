#include <nlohmann/json.hpp>

#include "cli/terminal.h"
#include "cli/wind_commands.h"
#include "io/machine_toml.h"

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

// Where a program asks an axis for more than the machine can.
struct Violation {
  std::size_t layer = 0, axis = 0;  // from 1; as axis_names
  std::string what;                 // "speed" or "travel"
  double value = 0, limit = 0;      // mm or deg, for speed by second
  std::int64_t line = 0;            // of the speed; 0: unknown
};

std::vector<Violation> violations_of(const SimulatedMachineProgram& program, const std::string& machine) {
  std::vector<Violation> out;
  if (machine.empty()) return out;
  const MachineProfile profile = read_machine(machine);
  constexpr double digits = 1e-3;  // of a speed, by the digits of a short line
  for (std::size_t k = 0; k < program.layers.size(); ++k) {
    for (std::size_t i = 0; i < winder_axes; ++i) {
      const AxisUse& use = program.layers[k].axes[i];
      const auto& axis = profile.axes[i];
      if (!axis) continue;
      if (use.fastest_per_s > axis->speed_per_s * (1 + digits))
        out.push_back({k + 1, i, "speed", use.fastest_per_s, axis->speed_per_s, use.fastest_line});
      if (static_cast<WinderAxis>(i) == WinderAxis::mandrel && profile.roll_over) continue;
      constexpr double rounding = 1e-6;
      if (use.lowest < axis->lowest - rounding)
        out.push_back({k + 1, i, "travel", use.lowest, axis->lowest, 0});
      if (use.highest > axis->highest + rounding)
        out.push_back({k + 1, i, "travel", use.highest, axis->highest, 0});
    }
  }
  return out;
}

Json violations_json(const std::vector<Violation>& violations) {
  Json out = Json::array();
  for (const Violation& at : violations) {
    out.push_back({{"layer", at.layer},
                   {"axis", axis_names[at.axis]},
                   {"what", at.what},
                   {"value", at.value},
                   {"limit", at.limit}});
    if (at.line > 0) out.back()["line"] = at.line;
  }
  return out;
}

std::string violation_text(const Violation& at) {
  const std::string start = "layer " + std::to_string(at.layer) + ": " + axis_names[at.axis];
  if (at.what == "speed") {
    return start + " runs at " + short_number(at.value) + " per s on line " + std::to_string(at.line) +
           ", the machine's does " + short_number(at.limit) + "\n";
  }
  return start + " goes to " + short_number(at.value, 6) + ", the machine's to " + short_number(at.limit, 6) +
         "\n";
}

std::string json_text(const SimulatedMachineProgram& program, const std::vector<Violation>& violations) {
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
    entry["crossings"] = laid.crossings;
    entry["slip_ratio"] = laid.slip_ratio;
    entry["slip_z_mm"] = laid.slip_z_mm;
    Json fastest = Json::object();
    for (std::size_t i = 0; i < winder_axes; ++i)
      if (layer.axes[i].fastest_per_s > 0) fastest[axis_names[i]] = layer.axes[i].fastest_per_s;
    entry["fastest_per_s"] = fastest;
    layers.push_back(entry);
  }
  const double time = time_of(program), length = length_of(program);
  const Json out = {{"commands_executed", program.commands},
                    {"moves", moves_of(program)},
                    {"estimated_time_s", time},
                    {"total_distance_mm", length},
                    {"tow_length_mm", length},
                    {"average_feed_rate_mmpm", time > 0 ? length / time * 60 : 0.0},
                    {"layers", layers},
                    {"violations", violations_json(violations)}};
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string table_text(const SimulatedMachineProgram& program, const std::vector<Violation>& violations) {
  Table table({"layer", "covered %", "one way %", "overlap %", "one-way gap mm", "at z mm", "starts",
               "start error deg", "backward", "idle", "openings mm", "thread mm", "clearance mm", "friction",
               "crossings", "laid m", "time s"},
              {false, true, true, true, true, true, true, true, true, true, true, true, true, true, true,
               true, true});
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
               short_number(laid.least_clearance_mm), short_number(laid.slip_ratio, 2),
               std::to_string(laid.crossings), short_number(laid.laid_mm / 1000),
               short_number(layer.time_s)});
  }
  std::string beyond;
  for (const Violation& at : violations) beyond += violation_text(at);
  return table.text() + beyond + std::to_string(program.commands) + " commands, " +
         short_number(time_of(program)) + " s, " + short_number(length_of(program) / 1000) + " m of tow\n";
}

}  // namespace

int print_simulated(const SimulatedMachineProgram& program, const Arguments& arguments) {
  const std::vector<Violation> violations = violations_of(program, arguments.wind.machine);
  print(arguments.json ? json_text(program, violations) : table_text(program, violations));
  return 0;
}

}  // namespace afptraj::cli
