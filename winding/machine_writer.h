#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "winding/meridian.h"
#include "winding/move_timing.h"
#include "winding/wind_definition.h"

namespace afptraj {

/// Writes a program for a machine: the header, from which `wind simulate` knows mandrel, tow and axes, then
/// moves as the profile's dialect has them. Lines keep below 255 characters, as LinuxCNC wants them.
class MachineWriter {
 public:
  using Sink = std::function<void(std::string_view)>;
  MachineWriter(const MachineProfile& profile, Sink sink) : profile_(profile), sink_(std::move(sink)) {}

  void header(const Meridian& meridian, const WindTow& tow);
  /// The mandrel from here on, where layers have made it another one.
  void mandrel(const Meridian& meridian);
  void comment(const std::string& text) { line("; " + text); }
  /// Names the axes that move; writes nothing where none does.
  void move(const MachineMove& move) { write(move, false); }
  /// Names all axes, for a machine that may stand anywhere.
  void place(const MachineMove& move) { write(move, true); }
  /// With roll-over: declares the mandrel to stand whole turns further back, in [0, 360). Targets of moves
  /// are given as if it did not.
  void roll_over();
  void end();

  std::int64_t lines() const { return lines_; }

 private:
  void write(const MachineMove& move, bool all_axes);
  void line(const std::string& text);
  void meridian_lines(const Meridian& meridian);
  void number_lines(const char* word, const std::vector<double>& numbers);
  double written(std::size_t axis, double value) const;

  const MachineProfile& profile_;
  Sink sink_;
  std::int64_t lines_ = 0;
  AxisValues at_{};
  double turned_back_deg_ = 0;
};

}  // namespace afptraj
