#include "winding/machine_writer.h"

#include <algorithm>
#include <cmath>

#include "winding/fixed_text.h"
#include "winding/number_words.h"

namespace afptraj {
namespace {

constexpr double mm_per_inch = 25.4;

bool is_linear(std::size_t axis) {
  return axis == static_cast<std::size_t>(WinderAxis::carriage) ||
         axis == static_cast<std::size_t>(WinderAxis::cross_feed);
}

}  // namespace

void MachineWriter::line(const std::string& text) {
  sink_(text + "\n");
  ++lines_;
}

// Numbers that read back as they are, some on each line.
void MachineWriter::number_lines(const char* word, const std::vector<double>& numbers) {
  constexpr std::size_t by_line = 8;
  for (std::size_t i = 0; i < numbers.size(); i += by_line) {
    std::string text = word;
    for (std::size_t k = i; k < std::min(numbers.size(), i + by_line); ++k)
      text += " " + header_number(numbers[k]);
    comment(text);
  }
}

void MachineWriter::meridian_lines(const Meridian& meridian) {
  for (const BSplineCurve2& piece : meridian.pieces()) {
    comment("Meridian degree " + std::to_string(piece.degree));
    number_lines("Knots", piece.knots);
    for (std::size_t i = 0; i < piece.poles.size(); ++i) {
      const double weight = piece.weights.empty() ? 1 : piece.weights[i];
      number_lines("Pole", {piece.poles[i].x(), piece.poles[i].y(), weight});
    }
  }
}

void MachineWriter::mandrel(const Meridian& meridian) {
  meridian_lines(meridian);
  comment("Mandrel grown");
}

void MachineWriter::header(const Meridian& meridian, const WindTow& tow) {
  comment("Tow width " + header_number(tow.width_mm) + " thickness " + header_number(tow.thickness_mm));
  meridian_lines(meridian);
  std::string axes = "Machine";
  for (std::size_t i = 0; i < winder_axes; ++i) {
    if (profile_.axes[i]) axes += std::string(" ") + axis_names[i] + " " + profile_.axes[i]->letter;
  }
  if (profile_.eye_room.fixed_mm) axes += " distance " + header_number(*profile_.eye_room.fixed_mm);
  comment(axes);
  line(profile_.inches ? "G20" : "G21");
  line("G90");
  line(profile_.dialect == Dialect::rs274 ? "G93" : "G94");
}

double MachineWriter::written(std::size_t axis, double value) const {
  if (axis == static_cast<std::size_t>(WinderAxis::mandrel)) return value - turned_back_deg_;
  return profile_.inches && is_linear(axis) ? value / mm_per_inch : value;
}

void MachineWriter::write(const MachineMove& move, bool all_axes) {
  std::string text = "G1";
  double square = 0;
  for (std::size_t i = 0; i < winder_axes; ++i) {
    if (!profile_.axes[i]) continue;
    const double to = written(i, move.to[i]), from = written(i, at_[i]);
    square += (to - from) * (to - from);
    if (!all_axes && millionths(to) == millionths(from)) continue;
    text += std::string(" ") + profile_.axes[i]->letter + fixed_text(to);
    at_[i] = move.to[i];
  }
  if (text.size() == 2) return;
  const double by_minute = move.time_s > 0 ? 60 / move.time_s : 60;  // where all are named, and none moves
  const double way = square > 0 ? std::sqrt(square) : 1;
  line(text + " F" + fixed_text(profile_.dialect == Dialect::rs274 ? by_minute : way * by_minute));
}

void MachineWriter::roll_over() {
  if (!profile_.roll_over) return;
  constexpr auto mandrel = static_cast<std::size_t>(WinderAxis::mandrel);
  const double turns = 360 * std::floor((at_[mandrel] - turned_back_deg_) / 360);
  if (turns == 0) return;
  turned_back_deg_ += turns;
  line(std::string("G92 ") + profile_.axes[mandrel]->letter + fixed_text(written(mandrel, at_[mandrel])));
}

void MachineWriter::end() {
  if (profile_.dialect == Dialect::rs274) line("M2");
}

}  // namespace afptraj
