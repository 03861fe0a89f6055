#pragma once

#include <sstream>
#include <string>
#include <vector>

#include "winding/plan_program.h"

namespace afptraj::test {

inline std::string program_text(const WindDefinition& definition, WindMode mode) {
  std::string text;
  write_program(definition, mode, [&](std::string_view piece) { text += piece; });
  return text;
}

inline std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

/// The number behind a letter of a program line; NaN when the line has none.
inline double axis_of(const std::string& line, char letter) {
  const std::size_t at = line.find(std::string(" ") + letter);
  return at == std::string::npos ? std::nan("") : std::stod(line.substr(at + 2));
}

inline WindDefinition definition_of(std::vector<WindLayer> layers) {
  WindDefinition definition;
  definition.mandrel = {70, 100, {}};
  definition.tow = {7, 0.5};
  definition.feed_mm_per_min = 9000;
  definition.layers = std::move(layers);
  return definition;
}

/// 35 degrees on the mandrel above: 26 circuits.
inline HelicalLayer sound_helical() {
  HelicalLayer layer;
  layer.angle_deg = 35;
  layer.pattern = 2;
  layer.skip = 1;
  layer.lock_deg = 180;
  layer.lead_in_mm = 5;
  layer.lead_out_deg = 15;
  return layer;
}

}  // namespace afptraj::test
