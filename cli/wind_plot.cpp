#include <algorithm>
#include <cmath>
#include <filesystem>

#include "cli/part_file.h"
#include "cli/terminal.h"
#include "cli/wind_commands.h"
#include "geometry/error.h"
#include "io/output_file.h"
#include "io/program_file.h"
#include "io/text_file.h"
#include "io/winding_svg.h"

namespace afptraj::cli {
namespace {

constexpr std::size_t largest_program = 4'000'000'000;  // bytes

UnrolledBand machine_band(const std::string& file, const std::string& text) {
  const SimulatedMachineProgram program = simulate_machine_text(file, text, check_stop);
  UnrolledBand band;
  for (const SimulatedMachineLayer& layer : program.layers) {
    if (!layer.mandrel) continue;
    const Meridian& mandrel = *layer.mandrel;
    band.length_mm = std::max(band.length_mm, mandrel.length_mm());
    band.radius_mm = std::max(band.radius_mm, mandrel.at(mandrel.widest()).r_mm);
    band.layers.push_back(unrolled_layer(layer.name, mandrel, program.tow, layer.laid.path));
  }
  return band;
}

UnrolledBand tube_band(const std::string& file, const std::string& text) {
  const SimulatedProgram program = simulate_text(file, text, check_stop, KeepPieces::yes);
  const WindMandrel& mandrel = program.mandrel;
  const double lean = (mandrel.end_diameter_mm.value_or(mandrel.diameter_mm) - mandrel.diameter_mm) / 2;
  UnrolledBand band{std::hypot(mandrel.length_mm, lean), mandrel.diameter_mm / 2, {}};
  for (const SimulatedLayer& layer : program.layers)
    band.layers.push_back(unrolled_layer(layer.name, mandrel, program.tow, layer.pieces));
  return band;
}

void choose_layer(UnrolledBand& band, int layer) {
  if (layer == 0) return;
  if (static_cast<std::size_t>(layer) > band.layers.size())
    throw Error(ErrorCode::usage, "--layer",
                "is " + std::to_string(layer) + "; the program has " + std::to_string(band.layers.size()));
  band.layers = {band.layers[static_cast<std::size_t>(layer) - 1]};
}

}  // namespace

int wind_plot(const Arguments& arguments) {
  const WindArguments& wind = arguments.wind;
  const std::string target =
      wind.output.empty() ? std::filesystem::path(wind.file).stem().string() + ".svg" : wind.output;
  const std::string text = read_file(wind.file, largest_program);
  OutputFile output(target, arguments.force, {wind.file});
  UnrolledBand band = is_machine_program(text) ? machine_band(wind.file, text) : tube_band(wind.file, text);
  choose_layer(band, wind.layer);
  output.write(winding_svg(band));
  output.commit();
  if (!arguments.quiet) print("wrote " + target + "\n");
  return 0;
}

}  // namespace afptraj::cli
