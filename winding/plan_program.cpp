#include "winding/plan_program.h"

#include <cmath>

#include "geometry/error.h"
#include "winding/fixed_text.h"
#include "winding/layers.h"
#include "winding/number_words.h"
#include "winding/pattern.h"

namespace afptraj {
namespace {

std::string header(const WindDefinition& definition, WindMode mode) {
  const WindMandrel& mandrel = definition.mandrel;
  std::string text =
      R"(Parameters {"irVersion":"1.0","mandrel":{"diameter":)" + header_number(mandrel.diameter_mm);
  text += R"(,"windLength":)" + header_number(mandrel.length_mm);
  if (mode == WindMode::native && mandrel.is_cone())
    text += R"(,"endDiameter":)" + header_number(*mandrel.end_diameter_mm);
  text += R"(},"tow":{"width":)" + header_number(definition.tow.width_mm);
  return text + R"(,"thickness":)" + header_number(definition.tow.thickness_mm) + "}}";
}

// The modal lines. Native programs keep comments on lines of their own: Marlin takes what follows a ';' off
// a numbered line, and its checksum with it.
void write_preamble(ProgramWriter& writer, const WindDefinition& definition) {
  writer.comment(header(definition, writer.mode()));
  constexpr const char* modal[][2] = {
      {"G21", "millimeter units"}, {"G90", "absolute positioning"}, {"G94", "feed rate in units per minute"}};
  for (const auto& [code, meaning] : modal) {
    if (writer.mode() == WindMode::native) {
      writer.comment(meaning);
      writer.line(code);
    } else {
      writer.line(std::string(code) + " ; " + meaning);
    }
  }
  writer.line("G0 X0 A0 B0");
  writer.line("G0 F" + fixed_text(definition.feed_mm_per_min));
}

std::string layer_comment(const WindDefinition& definition, std::size_t index, WindMode mode) {
  const WindLayer& layer = definition.layers[index];
  std::string text = "Layer " + std::to_string(index + 1) + " of " +
                     std::to_string(definition.layers.size()) + ": " + layer_name(layer);
  const auto* helical = std::get_if<HelicalLayer>(&layer);
  if (mode == WindMode::native && helical != nullptr) {
    text += ", angle " + header_number(helical->angle_deg) + ", circuits " +
            std::to_string(circuits(definition.mandrel, definition.tow, *helical, mode)) +
            ", patternNumber " + std::to_string(helical->pattern) + ", skipIndex " +
            std::to_string(helical->skip) + ", lockDegrees " + header_number(helical->lock_deg);
  }
  return text;
}

void write_skip(ProgramWriter& writer, const SkipLayer& layer) {
  double rotation = layer.rotation_deg;
  if (writer.mode() == WindMode::native && rotation < 0) {
    rotation = modulo(rotation, 360);
    writer.comment("turned on to the same place, since a turn back would slacken the tow");
  }
  writer.set_purpose(MovePurpose::reposition);
  writer.move_to({0, rotation, 0});
  writer.set_position({}, 0.0, {});
}

void write_layer(ProgramWriter& writer, const WindDefinition& definition, const WindLayer& layer,
                 LayerReport& report) {
  if (const auto* hoop = std::get_if<HoopLayer>(&layer)) {
    write_hoop(writer, definition, *hoop);
  } else if (const auto* skip = std::get_if<SkipLayer>(&layer)) {
    write_skip(writer, *skip);
  } else {
    write_helical(writer, definition, std::get<HelicalLayer>(layer), report);
  }
}

ProgramTotals difference(const ProgramTotals& after, const ProgramTotals& before) {
  ProgramTotals out = after;
  out.lines -= before.lines;
  for (std::size_t i = 0; i < out.length_mm.size(); ++i) out.length_mm[i] -= before.length_mm[i];
  return out;
}

void require_writable_length(const WindDefinition& definition, WindMode mode) {
  double lines = 0;
  for (const WindLayer& layer : definition.layers) {
    double passes = 2;
    if (const auto* helical = std::get_if<HelicalLayer>(&layer))
      passes *= static_cast<double>(circuits(definition.mandrel, definition.tow, *helical, mode));
    if (!std::holds_alternative<SkipLayer>(layer)) lines += passes * definition.mandrel.length_mm;
  }
  if (lines > longest_program) {
    throw Error(ErrorCode::resource_limit, "program",
                "would have about " + significant_text(lines, 3) +
                    " lines, one per mm of each pass; check the tow width and the length");
  }
}

}  // namespace

ProgramReport write_program(const WindDefinition& definition, WindMode mode,
                            const ProgramWriter::Sink& sink) {
  require_writable_length(definition, mode);
  ProgramWriter writer(definition.mandrel.diameter_mm, mode, sink);
  ProgramReport report;
  report.feed_mm_per_min = definition.feed_mm_per_min;
  write_preamble(writer, definition);
  for (std::size_t i = 0; i < definition.layers.size(); ++i) {
    writer.comment(layer_comment(definition, i, mode));
    const ProgramTotals before = writer.totals();
    LayerReport& layer = report.layers.emplace_back();
    write_layer(writer, definition, definition.layers[i], layer);
    layer.totals = difference(writer.totals(), before);
  }
  writer.flush();
  report.totals = writer.totals();
  return report;
}

}  // namespace afptraj
