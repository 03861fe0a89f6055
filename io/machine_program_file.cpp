#include "io/machine_program_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "geometry/error.h"
#include "io/text_file.h"
#include "winding/frustum.h"
#include "winding/machine_profile.h"

namespace afptraj {
namespace {

constexpr std::string_view machine_mark = "; Machine carriage ";
constexpr double mm_per_inch = 25.4;

std::string_view stripped(std::string_view text) {
  constexpr std::string_view blanks = " \t\r";
  const std::size_t first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

std::string_view next_word(std::string_view& line) {
  const std::size_t end = line.find_first_of(" \t");
  const std::string_view word = line.substr(0, end);
  line = end == std::string_view::npos ? std::string_view() : stripped(line.substr(end));
  return word;
}

bool takes(std::string_view& line, std::string_view words) {
  if (line.substr(0, words.size()) != words) return false;
  line = stripped(line.substr(words.size()));
  return true;
}

class MachineReader {
 public:
  MachineReader(const std::string& path, const std::function<void()>& between)
      : path_(path), between_(between) {}

  SimulatedMachineProgram read(std::string_view text) {
    while (!text.empty()) {
      const std::size_t end = text.find('\n');
      ++line_;
      const std::string_view line = stripped(text.substr(0, end));
      if (!line.empty()) read_line(line);
      if (end == std::string_view::npos) break;
      text.remove_prefix(end + 1);
    }
    end_travel();
    if (!laid_) fail("the program lays nothing; plan it again");
    return std::move(result_);
  }

 private:
  [[noreturn]] void fail(const std::string& message) const {
    throw Error(ErrorCode::bad_input, file_line(path_, line_), message);
  }

  double number(std::string_view word) const {
    double value = 0;
    const auto result = std::from_chars(word.data(), word.data() + word.size(), value);
    if (word.empty() || result.ec != std::errc() || result.ptr != word.data() + word.size() ||
        !std::isfinite(value))
      fail("'" + printable(std::string(word)) + "' is no number; plan the program again");
    return value;
  }
  double number_after(std::string_view& line, std::string_view word) const {
    if (!takes(line, word)) fail("lacks '" + std::string(word) + "'; plan the program again");
    return number(next_word(line));
  }

  void read_line(std::string_view line) {
    if (line.front() == ';') {
      read_comment(stripped(line.substr(1)));
      return;
    }
    ++result_.commands;
    line = stripped(line.substr(0, line.find(';')));
    const std::string_view code = next_word(line);
    if (code == "G90" || code == "M2") return;
    if (code == "G20" || code == "G21") {
      linear_mm_ = code == "G20" ? mm_per_inch : 1;
    } else if (code == "G93" || code == "G94") {
      inverse_time_ = code == "G93";
    } else if (code == "G0" || code == "G1") {
      move(line);
    } else if (code == "G92") {
      declare(line);
    } else {
      fail("'" + printable(std::string(code)) + "' is unknown; use G0, G1, G20, G21, G90, G92, G93, G94, M2");
    }
  }

  void read_comment(std::string_view text) {
    if (takes(text, "Tow width ")) {
      result_.tow.width_mm = number(next_word(text));
      result_.tow.thickness_mm = number_after(text, "thickness ");
      if (!(result_.tow.width_mm > 0)) fail("the tow's width is not positive; plan the program again");
    } else if (takes(text, "Meridian degree ")) {
      pieces_.emplace_back().degree = static_cast<int>(number(text));
      if (pieces_.back().degree < 1 || pieces_.back().degree > max_degree)
        fail("the meridian's degree is out of range; plan the program again");
    } else if (!pieces_.empty() && takes(text, "Knots ")) {
      while (!text.empty()) pieces_.back().knots.push_back(number(next_word(text)));
    } else if (!pieces_.empty() && takes(text, "Pole ")) {
      const double z = number(next_word(text)), r = number(next_word(text));
      pieces_.back().poles.emplace_back(z, r);
      pieces_.back().weights.push_back(number(next_word(text)));
    } else if (takes(text, "Machine ")) {
      read_axes(text);
      make_meridian();
    } else if (text == "Mandrel grown") {
      end_travel();
      make_meridian();
    } else if (takes(text, "Layer ")) {
      end_travel();
      result_.layers.emplace_back().name = std::string(text);
    } else if (takes(text, "Tow fixed at ")) {
      begin_travel(text);
    } else if (text == "Tow cut") {
      end_travel();
    }
  }

  void read_axes(std::string_view text) {
    while (!text.empty()) {
      const std::string_view name = next_word(text), value = next_word(text);
      if (name == "distance") {
        axes_[static_cast<std::size_t>(WinderAxis::cross_feed)] = number(value);
        continue;
      }
      std::size_t i = 0;
      while (i < winder_axes && name != axis_names[i]) ++i;
      if (i == winder_axes || value.size() != 1)
        fail("'" + printable(std::string(name)) + "' is no axis; plan the program again");
      letters_[i] = value.front();
    }
  }

  void make_meridian() {
    for (BSplineCurve2& piece : pieces_) {
      if (piece.knots.size() != piece.poles.size() + static_cast<std::size_t>(piece.degree) + 1 ||
          piece.poles.size() <= static_cast<std::size_t>(piece.degree))
        fail("the meridian's knots and poles do not match; plan the program again");
    }
    if (pieces_.empty()) fail("the header has no meridian; plan the program again");
    if (!(result_.tow.width_mm > 0)) fail("the header has no tow; plan the program again");
    try {
      meridian_ = std::make_shared<const Meridian>(std::move(pieces_));
      pieces_.clear();
    } catch (const Error& e) {
      fail(std::string("the meridian ") + e.what());
    }
  }

  SimulatedMachineLayer& layer() {
    if (!meridian_) fail("moves before the header's end; plan the program again");
    if (result_.layers.empty()) result_.layers.emplace_back();
    return result_.layers.back();
  }

  // The axes that a line names, and its feed.
  AxisValues named(std::string_view line, const AxisValues& otherwise) {
    AxisValues to = otherwise;
    while (!line.empty()) {
      const std::string_view word = next_word(line);
      const double value = number(word.substr(1));
      std::size_t i = 0;
      while (i < winder_axes && letters_[i] != word.front()) ++i;
      if (i < winder_axes) {
        const bool linear = i == 0 || i == static_cast<std::size_t>(WinderAxis::cross_feed);
        to[i] = linear ? value * linear_mm_ : value;
      } else if (word.front() == 'F') {
        feed_ = value;
      } else {
        fail("'" + printable(std::string(word)) + "' names no axis of the header");
      }
    }
    return to;
  }

  void move(std::string_view line) {
    SimulatedMachineLayer& now = layer();
    const AxisValues to = named(line, axes_);
    double square = 0;
    for (std::size_t i = 0; i < winder_axes; ++i) {
      const bool linear = i == 0 || i == static_cast<std::size_t>(WinderAxis::cross_feed);
      const double way = (to[i] - axes_[i]) / (linear ? linear_mm_ : 1);
      square += way * way;
    }
    if (square == 0) {
      ++now.idle_moves;
      return;
    }
    if (!(feed_ > 0)) fail("moves without a feed; write F");
    const double seconds = 60 * (inverse_time_ ? 1 : std::sqrt(square)) / feed_;
    use_axes(now, to, seconds);
    ++now.moves;
    now.time_s += seconds;
    if (laying_ && value(to, WinderAxis::mandrel) < value(axes_, WinderAxis::mandrel)) ++now.backward_turns;
    axes_ = to;
    if (laying_) travel_.eyes.push_back(eye());
    if (between_ && now.moves % 10000 == 0) between_();
  }

  void use_axes(SimulatedMachineLayer& now, const AxisValues& to, double seconds) {
    for (std::size_t i = 0; i < winder_axes; ++i) {
      AxisUse& use = now.axes[i];
      use.lowest = now.moves == 0 ? to[i] : std::min(use.lowest, to[i]);
      use.highest = now.moves == 0 ? to[i] : std::max(use.highest, to[i]);
      // what is shorter than the text's digits tells no speed
      constexpr double digits = 1e-5;
      const double way = std::abs(to[i] - axes_[i]);
      if (way < digits || way / seconds <= use.fastest_per_s) continue;
      use.fastest_per_s = way / seconds;
      use.fastest_line = line_;
    }
  }

  void declare(std::string_view line) {
    const AxisValues told = named(line, axes_);
    for (const WinderAxis axis : {WinderAxis::carriage, WinderAxis::cross_feed}) {
      if (value(told, axis) != value(axes_, axis))
        fail("G92 moves the origin of a linear axis, and the mandrel with it; declare the mandrel only");
    }
    origin_deg_ += value(axes_, WinderAxis::mandrel) - value(told, WinderAxis::mandrel);
    axes_ = told;
  }

  EyePlace eye() const {
    return {value(axes_, WinderAxis::carriage), value(axes_, WinderAxis::cross_feed),
            radians(value(axes_, WinderAxis::mandrel) + origin_deg_)};
  }

  void begin_travel(std::string_view text) {
    layer();
    end_travel();
    laying_ = true;
    travel_ = {};
    travel_.start_z_mm = number_after(text, "z ");
    travel_.start_r_mm = number_after(text, "r ");
    const double turn = number_after(text, "turn ");
    travel_.eyes.push_back(eye());
    // The mandrel has turned before; the place where the tow is fixed lies up to one turn behind the eye.
    const double azimuth = degrees(travel_.eyes.front().azimuth_rad);
    travel_.start_turn_rad = radians(turn + 360 * std::floor((azimuth - turn) / 360));
  }

  void end_travel() {
    if (laying_ && travel_.eyes.size() > 1) {
      if (between_) between_();
      laid_ = true;
      layer().mandrel = meridian_;
      layer().laid = simulate_travel(*meridian_, result_.tow, travel_);
    }
    laying_ = false;
  }

  const std::string& path_;
  const std::function<void()>& between_;
  int line_ = 0;
  SimulatedMachineProgram result_;
  std::vector<BSplineCurve2> pieces_;
  std::shared_ptr<const Meridian> meridian_;
  std::array<char, winder_axes> letters_{};
  AxisValues axes_{};
  double origin_deg_ = 0;  // of the mandrel's axis
  double linear_mm_ = 1, feed_ = 0;
  bool inverse_time_ = false, laying_ = false, laid_ = false;
  EyeTravel travel_;
};

}  // namespace

bool is_machine_program(std::string_view text) {
  while (!text.empty() && text.front() == ';') {
    if (text.substr(0, machine_mark.size()) == machine_mark) return true;
    text.remove_prefix(std::min(text.find('\n'), text.size() - 1) + 1);
  }
  return false;
}

SimulatedMachineProgram simulate_machine_text(const std::string& name, std::string_view text,
                                              const std::function<void()>& between) {
  return MachineReader(name, between).read(text);
}

}  // namespace afptraj
