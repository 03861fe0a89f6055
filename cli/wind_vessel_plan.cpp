#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "cli/mandrel_file.h"
#include "cli/part_file.h"
#include "cli/ply_winding.h"
#include "cli/terminal.h"
#include "cli/wind_commands.h"
#include "geometry/error.h"
#include "io/machine_toml.h"
#include "io/output_file.h"
#include "io/vessel_toml.h"
#include "winding/frustum.h"
#include "winding/vessel_program.h"

namespace afptraj::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr double mm_per_m = 1000;

std::string axis_name(WinderAxis axis) { return axis_names[static_cast<std::size_t>(axis)]; }

struct VesselJob {
  VesselWinding winding;
  MachineProfile machine;
  std::vector<std::filesystem::path> inputs;    // beside the file itself
  std::vector<std::vector<std::string>> plies;  // of each layer, where it comes from plies
  std::string notes;
};

VesselJob ply_job(const WindArguments& arguments) {
  PlyWinding plies = read_ply_winding(arguments);
  if (arguments.machine.empty())
    throw Error(ErrorCode::usage, "--machine", "is missing; give the machine's file");
  return {std::move(plies.winding),
          read_machine(arguments.machine),
          {arguments.plies, arguments.machine},
          std::move(plies.plies),
          plies.notes};
}

VesselJob read_job(const WindArguments& arguments) {
  if (!arguments.plies.empty()) return ply_job(arguments);
  VesselFile file = read_vessel(arguments.file);
  const std::string machine = arguments.machine.empty() ? file.machine : arguments.machine;
  if (machine.empty())
    throw Error(ErrorCode::usage, arguments.file,
                "names no machine; write machine = \"...\", or give --machine");
  MachineProfile profile = read_machine(machine);
  MandrelFile mandrel = read_mandrel(file);
  VesselWinding winding{std::move(mandrel.meridian), file.tow, file.feed_mm_per_min, file.layers,
                        file.growth};
  return {std::move(winding), std::move(profile), {file.mandrel, machine}, {}, {}};
}

VesselReport write_job(const VesselJob& job, const WindArguments& arguments,
                       const MachineWriter::Sink& sink) {
  const OverSpeed over_speed = arguments.over_speed == "refuse" ? OverSpeed::refuse : OverSpeed::clamp;
  try {
    return write_vessel_program(job.winding, job.machine, over_speed, sink);
  } catch (const Error& e) {
    if (e.code() != ErrorCode::no_path) throw;
    throw Error(e.code(), arguments.file, e.where() + ": " + e.what());
  }
}

Json clamped_json(const ClampedAxis& axis) {
  return {{"axis", axis_name(axis.axis)},         {"moves", axis.moves},
          {"wanted_per_s", axis.wanted_per_s},    {"limit_per_s", axis.limit_per_s},
          {"angle_deg", degrees(axis.angle_rad)}, {"loose_angle_deg", degrees(axis.loose_angle_rad)}};
}

std::string layer_type(const VesselJob& job, std::size_t i) {
  return job.winding.layers[i].hoop ? "hoop" : "helical";
}

std::string summary_json(const std::string& output, const VesselReport& report, const VesselJob& job) {
  Json layers = Json::array();
  double time = 0, tow = 0;
  for (std::size_t i = 0; i < report.layers.size(); ++i) {
    const VesselLayerReport& layer = report.layers[i];
    const VesselPattern& pattern = layer.pattern;
    time += layer.time_s;
    tow += layer.laid_mm / mm_per_m;
    Json clamped = Json::array();
    for (const ClampedAxis& axis : layer.clamped) clamped.push_back(clamped_json(axis));
    layers.push_back({{"index", i + 1},
                      {"wind_type", layer_type(job, i)},
                      {"commands", layer.lines},
                      {"time_s", layer.time_s},
                      {"cumulative_time_s", time},
                      {"tow_m", layer.laid_mm / mm_per_m},
                      {"cumulative_tow_m", tow},
                      {"laid_m", layer.laid_mm / mm_per_m},
                      {"repositioned_m", layer.repositioned_mm / mm_per_m},
                      {"time_at_feed_s", layer.asked_time_s},
                      {"angle_deg", pattern.angle_deg},
                      {"circuits", pattern.circuits},
                      {"stride", pattern.stride},
                      {"starts", pattern.starts},
                      {"leading", pattern.leading},
                      {"overlap", pattern.overlap},
                      {"openings_mm", {pattern.opening_first_mm, pattern.opening_last_mm}},
                      {"steering", {pattern.ratio_first, pattern.ratio_last}},
                      {"thickness_mm", {layer.least_thickness_mm, layer.most_thickness_mm}},
                      {"free_length_mm", {layer.least_free_mm, layer.most_free_mm}},
                      {"backward_turns", layer.backward_turns},
                      {"clamped", clamped}});
    if (!job.plies.empty()) layers.back()["plies"] = job.plies[i];
  }
  const Json out = {{"output", output},
                    {"commands", report.lines},
                    {"timeSeconds", time},
                    {"towMeters", tow},
                    {"layers", layers}};
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string clamped_text(std::size_t layer, const ClampedAxis& axis) {
  std::string text = "layer " + std::to_string(layer) + ": " + axis_name(axis.axis) + " held at " +
                     short_number(axis.limit_per_s) + " per s in " + std::to_string(axis.moves) +
                     " moves, where the feed asks for " + short_number(axis.wanted_per_s);
  if (axis.loose_angle_rad != axis.angle_rad) {
    text += "; a mandrel that kept its speed would lay " + short_number(degrees(axis.loose_angle_rad)) +
            " deg instead of " + short_number(degrees(axis.angle_rad));
  }
  return text + "\n";
}

std::string summary_table(const std::string& output, const VesselReport& report, const VesselJob& job) {
  Table table({"layer", "type", "angle deg", "circuits", "starts", "", "overlap %", "openings mm", "friction",
               "thread mm", "lines", "time s", "laid m"},
              {true, false, true, true, true, true, true, false, true, true, true, true, true, true});
  std::string held;
  double time = 0, tow = 0;
  for (std::size_t i = 0; i < report.layers.size(); ++i) {
    const VesselLayerReport& layer = report.layers[i];
    const VesselPattern& pattern = layer.pattern;
    time += layer.time_s;
    tow += layer.laid_mm / mm_per_m;
    table.add({std::to_string(i + 1), layer_type(job, i), short_number(pattern.angle_deg, 8),
               std::to_string(pattern.circuits), std::to_string(pattern.starts),
               job.winding.layers[i].hoop ? ""
               : pattern.leading          ? "leading"
                                          : "lagging",
               short_number(100 * pattern.overlap, 3),
               short_number(pattern.opening_first_mm) + ", " + short_number(pattern.opening_last_mm),
               short_number(std::max(std::abs(pattern.ratio_first), std::abs(pattern.ratio_last)), 3),
               short_number(layer.least_free_mm) + " ... " + short_number(layer.most_free_mm),
               std::to_string(layer.lines), short_number(layer.time_s),
               short_number(layer.laid_mm / mm_per_m)});
    for (const ClampedAxis& axis : layer.clamped) held += clamped_text(i + 1, axis);
    if (layer.backward_turns > 0) {
      held += "layer " + std::to_string(i + 1) + ": " + std::to_string(layer.backward_turns) +
              " moves turn the mandrel back, over hollow edges of the meridian\n";
    }
  }
  return table.text() + held + "wrote " + output + ": " + std::to_string(report.lines) + " lines, " +
         short_number(time) + " s, " + short_number(tow) + " m of tow\n";
}

std::vector<std::filesystem::path> inputs_of(const VesselJob& job, const WindArguments& arguments) {
  std::vector<std::filesystem::path> inputs{arguments.file};
  inputs.insert(inputs.end(), job.inputs.begin(), job.inputs.end());
  return inputs;
}

}  // namespace

int wind_vessel_plan(const Arguments& arguments) {
  const WindArguments& wind = arguments.wind;
  const VesselJob job = read_job(wind);
  const std::string target =
      wind.output.empty() ? std::filesystem::path(wind.file).stem().string() + ".gcode" : wind.output;
  OutputFile output(target, arguments.force, inputs_of(job, wind));
  const VesselReport report = write_job(job, wind, [&](std::string_view piece) {
    check_stop();
    output.write(piece);
  });
  output.commit();
  if (arguments.json) {
    print(summary_json(target, report, job));
  } else if (!arguments.quiet) {
    print(job.notes + summary_table(target, report, job));
  }
  return 0;
}

int wind_vessel_validate(const Arguments& arguments) {
  const std::string& file = arguments.wind.file;
  const auto line = [](const Json& json) {
    return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
  };
  try {
    write_job(read_job(arguments.wind), arguments.wind, [](std::string_view) { check_stop(); });
  } catch (const Error& e) {
    if (arguments.json) print(line({{"status", "error"}, {"path", file}, {"message", e.what()}}));
    throw;
  }
  print(arguments.json ? line({{"status", "ok"}, {"path", file}}) : file + " is valid.\n");
  return 0;
}

}  // namespace afptraj::cli
