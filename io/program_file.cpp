#include "io/program_file.h"

#include <array>
#include <charconv>
#include <cmath>

#include "geometry/error.h"
#include "io/json_reader.h"
#include "io/text_file.h"

namespace afptraj {
namespace {

constexpr std::size_t largest_file = 4'000'000'000;
constexpr std::string_view header_mark = "; Parameters ";
constexpr int lines_between = 100000;

std::string_view stripped(std::string_view text) {
  constexpr std::string_view blanks = " \t\r";
  const std::size_t first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

// Calls `each(line, number)` for the lines of a text, blanks around them taken off.
template <typename Each>
void for_each_line(std::string_view text, const Each& each) {
  int number = 0;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    each(stripped(text.substr(0, end)), ++number);
    if (end == std::string_view::npos) break;
    text.remove_prefix(end + 1);
  }
}

class ProgramReader {
 public:
  ProgramReader(const std::string& path, KeepPieces keep) : path_(path), keep_(keep) {}

  SimulatedProgram read(std::string_view text, const std::function<void()>& between) {
    read_header(text);
    ProgramSimulator simulator(mandrel_, tow_, keep_);
    for_each_line(text, [&](std::string_view line, int number) {
      line_ = number;
      if (between && number % lines_between == 0) between();
      if (!line.empty()) read_line(line, simulator);
    });
    if (!moved_) fail_whole("holds no motion; give a program with G0 lines");
    return simulator.finish();
  }

 private:
  [[noreturn]] void fail(const std::string& message) const {
    throw Error(ErrorCode::bad_input, file_line(path_, line_), message);
  }
  [[noreturn]] void fail_whole(const std::string& message) const {
    throw Error(ErrorCode::bad_input, path_, message);
  }

  void read_header(std::string_view text) {
    bool found = false;
    for_each_line(text, [&](std::string_view line, int number) {
      if (found || line.substr(0, header_mark.size()) != header_mark) return;
      found = true;
      line_ = number;
      read_parameters(line.substr(header_mark.size()));
    });
    if (!found)
      fail_whole(
          "Unable to locate Parameters header in program; it names mandrel and tow, plan the program again");
  }

  void read_parameters(std::string_view text) {
    JsonValue json;
    try {
      json = read_json(text);
    } catch (const JsonProblem& problem) {
      fail(std::string("the Parameters header is not JSON: ") + problem.what() + "; plan the program again");
    }
    mandrel_.diameter_mm = parameter(json, "mandrel", "diameter").value();
    mandrel_.length_mm = parameter(json, "mandrel", "windLength").value();
    mandrel_.end_diameter_mm = parameter(json, "mandrel", "endDiameter", false);
    tow_.width_mm = parameter(json, "tow", "width").value();
    tow_.thickness_mm = parameter(json, "tow", "thickness").value();
  }

  std::optional<double> parameter(const JsonValue& json, const char* group, const char* name,
                                  bool required = true) const {
    const JsonValue* in = json.find(group);
    const JsonValue* value = in == nullptr ? nullptr : in->find(name);
    if (value == nullptr && !required) return std::nullopt;
    if (value == nullptr || !(value->number > 0) || !std::isfinite(value->number)) {
      fail(std::string("the Parameters header lacks a positive ") + group + "." + name +
           "; plan the program again");
    }
    return value->number;
  }

  void read_line(std::string_view line, ProgramSimulator& simulator) {
    if (line.front() == ';') {
      simulator.count_command();
      const std::string_view comment = stripped(line.substr(1));
      if (comment.substr(0, 6) == "Layer ") simulator.begin_layer(std::string(comment.substr(6)));
      return;
    }
    line = stripped(line.substr(0, line.find(';')));
    const std::string_view opcode = next_word(line);
    if (opcode == "G21" || opcode == "G90" || opcode == "G94") return;
    if (opcode != "G0" && opcode != "G1" && opcode != "G92") {
      fail("Unsupported G-code opcode: '" + printable(std::string(opcode)) +
           "'; use G0, G1, G92, G21, G90, G94");
    }
    simulator.count_command();
    std::array<std::optional<double>, 3> axes;
    while (!line.empty()) read_word(next_word(line), axes, simulator);
    if (opcode == "G92") {
      simulator.declare(axes[0], axes[1], axes[2]);
      return;
    }
    moved_ = true;
    if (!simulator.move(axes[0], axes[1], axes[2]))
      fail("Feed rate must be set before moving the machine; write G0 F... before it");
  }

  static std::string_view next_word(std::string_view& line) {
    const std::size_t end = line.find_first_of(" \t");
    const std::string_view word = line.substr(0, end);
    line = end == std::string_view::npos ? std::string_view() : stripped(line.substr(end));
    return word;
  }

  void read_word(std::string_view word, std::array<std::optional<double>, 3>& axes,
                 ProgramSimulator& simulator) {
    double value = 0;
    const auto result = std::from_chars(word.data() + 1, word.data() + word.size(), value);
    if (result.ec != std::errc() || result.ptr != word.data() + word.size() || !std::isfinite(value))
      fail("'" + printable(std::string(word)) + "' has no number; write a letter and a number, as X12.5");
    constexpr std::string_view letters = "XAB";
    const std::size_t axis = letters.find(word.front());
    if (axis != std::string_view::npos) {
      axes[axis] = value;
    } else if (word.front() == 'F') {
      simulator.set_feed(value);
    } else if (!moved_ && (word.front() == 'Y' || word.front() == 'Z')) {
      fail("Detected unsupported XYZ axis program; re-generate using XAB format.");
    } else {
      fail("Unknown axis letter '" + printable(std::string(1, word.front())) + "' in token '" +
           printable(std::string(word)) + "'; use X, A and B");
    }
  }

  const std::string& path_;
  const KeepPieces keep_;
  int line_ = 0;
  bool moved_ = false;
  WindMandrel mandrel_;
  WindTow tow_;
};

}  // namespace

SimulatedProgram simulate_text(const std::string& name, std::string_view text,
                               const std::function<void()>& between, KeepPieces keep) {
  return ProgramReader(name, keep).read(text, between);
}

SimulatedProgram simulate_file(const std::string& path, const std::function<void()>& between) {
  return simulate_text(path, read_file(path, largest_file), between);
}

}  // namespace afptraj
