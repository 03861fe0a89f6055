#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "winding/wind_definition.h"

namespace afptraj {

/// Where the three axes of the machine stand.
struct AxisPosition {
  double carriage_mm = 0, mandrel_deg = 0, head_deg = 0;
};

/// What a move is for.
enum class MovePurpose { lay, turn_around, reposition };

/// What a program, or a part of it, amounts to. A move's length is that of its path on the mandrel's
/// greatest cylinder: sqrt(dX^2 + (dA/360 pi D)^2); its time that length by the feed.
struct ProgramTotals {
  std::int64_t lines = 0;
  std::array<double, 3> length_mm{};  ///< by MovePurpose
  double total_length_mm() const { return length_mm[0] + length_mm[1] + length_mm[2]; }
};

/// Writes the lines of a machine program, letters X (carriage), A (mandrel), B (head), and remembers where
/// the axes stand. Text goes to the sink in pieces, so a program of any length takes little memory.
///
/// A move in which the carriage travels is cut into pieces of about one millimetre: n - 1 pieces,
/// n = round(|dX|) + 1, halves to even. In FiberPath mode each such move begins with a line that repeats
/// the place where it starts, and every move is written; in native mode a line on which no number changes
/// is left out.
class ProgramWriter {
 public:
  using Sink = std::function<void(std::string_view)>;
  ProgramWriter(double diameter_mm, WindMode mode, Sink sink);

  void line(std::string_view text);
  void comment(std::string_view text);
  void move_to(const AxisPosition& target);
  /// Declares the given axes to stand at these values ("G92").
  void set_position(std::optional<double> carriage_mm, std::optional<double> mandrel_deg,
                    std::optional<double> head_deg);
  void set_purpose(MovePurpose purpose) { purpose_ = purpose; }
  /// Hands the rest to the sink.
  void flush();

  const AxisPosition& position() const { return position_; }
  const ProgramTotals& totals() const { return totals_; }
  WindMode mode() const { return mode_; }

 private:
  void point(const AxisPosition& target);
  char* write_axis(char* at, char letter, double value) const;
  char* room(std::size_t bytes);
  void end_line(char* at);

  double circumference_mm_;
  WindMode mode_;
  Sink sink_;
  std::vector<char> text_;
  std::size_t filled_ = 0;
  AxisPosition position_;
  ProgramTotals totals_;
  MovePurpose purpose_ = MovePurpose::reposition;
};

}  // namespace afptraj
