#include "winding/program_writer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "winding/fixed_text.h"

namespace afptraj {
namespace {

constexpr std::size_t piece_bytes = std::size_t{1} << 18;  // fits into the cache of one core
constexpr std::size_t longest_line = 3 * (fixed_room + 2) + 8;

bool same_place(double a, double b) {
  return std::abs(a - b) <= std::max(1e-9 * std::max(std::abs(a), std::abs(b)), 1e-6);
}

// Whether a machine is told the same number.
bool same_text(double a, double b) {
  if (std::abs(a) < fixed_limit && std::abs(b) < fixed_limit) return millionths(a) == millionths(b);
  return a == b;
}

}  // namespace

ProgramWriter::ProgramWriter(double diameter_mm, WindMode mode, Sink sink)
    : circumference_mm_(std::numbers::pi * diameter_mm),
      mode_(mode),
      sink_(std::move(sink)),
      text_(piece_bytes) {}

// Where the next `bytes` characters may be written.
char* ProgramWriter::room(std::size_t bytes) {
  if (filled_ + bytes > text_.size()) flush();
  if (bytes > text_.size()) text_.resize(bytes);
  return text_.data() + filled_;
}

void ProgramWriter::end_line(char* at) {
  *at++ = '\n';
  filled_ = static_cast<std::size_t>(at - text_.data());
  ++totals_.lines;
}

void ProgramWriter::flush() {
  sink_({text_.data(), filled_});
  filled_ = 0;
}

void ProgramWriter::line(std::string_view text) {
  char* at = room(text.size() + 1);
  std::memcpy(at, text.data(), text.size());
  end_line(at + text.size());
}

void ProgramWriter::comment(std::string_view text) { line("; " + std::string(text)); }

char* ProgramWriter::write_axis(char* at, char letter, double value) const {
  *at++ = ' ';
  *at++ = letter;
  return write_fixed(at, value, mode_ == WindMode::fiberpath);
}

void ProgramWriter::point(const AxisPosition& target) {
  if (mode_ == WindMode::native && same_text(target.carriage_mm, position_.carriage_mm) &&
      same_text(target.mandrel_deg, position_.mandrel_deg) &&
      same_text(target.head_deg, position_.head_deg)) {
    return;
  }
  const double dx = target.carriage_mm - position_.carriage_mm;
  const double arc = (target.mandrel_deg - position_.mandrel_deg) / 360 * circumference_mm_;
  totals_.length_mm[static_cast<std::size_t>(purpose_)] += std::sqrt(dx * dx + arc * arc);
  position_ = target;
  char* at = room(longest_line);
  *at++ = 'G';
  *at++ = '0';
  at = write_axis(at, 'X', target.carriage_mm);
  at = write_axis(at, 'A', target.mandrel_deg);
  end_line(write_axis(at, 'B', target.head_deg));
}

void ProgramWriter::move_to(const AxisPosition& target) {
  const AxisPosition start = position_;
  const double dx = target.carriage_mm - start.carriage_mm;
  const double pieces = std::nearbyint(std::abs(dx));
  if (same_place(target.carriage_mm, start.carriage_mm) || pieces == 0) {
    point(target);
    return;
  }
  const auto between = [&](double k, double from, double to) { return from + k * (to - from) / pieces; };
  for (double k = 0; k <= pieces; ++k) {
    point({between(k, start.carriage_mm, target.carriage_mm),
           between(k, start.mandrel_deg, target.mandrel_deg), between(k, start.head_deg, target.head_deg)});
  }
}

void ProgramWriter::set_position(std::optional<double> carriage_mm, std::optional<double> mandrel_deg,
                                 std::optional<double> head_deg) {
  char* at = room(longest_line);
  std::memcpy(at, "G92", 3);
  at += 3;
  if (carriage_mm) at = write_axis(at, 'X', position_.carriage_mm = *carriage_mm);
  if (mandrel_deg) at = write_axis(at, 'A', position_.mandrel_deg = *mandrel_deg);
  if (head_deg) at = write_axis(at, 'B', position_.head_deg = *head_deg);
  end_line(at);
}

}  // namespace afptraj
