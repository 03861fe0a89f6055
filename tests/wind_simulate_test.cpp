// Programs re-read and rebuilt: planning and simulation share no arithmetic but the text of the program.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

#include "geometry/error.h"
#include "io/program_file.h"
#include "tests/winding_text.h"
#include "winding/layer_rules.h"
#include "winding/pattern.h"

namespace afptraj {
namespace {

using test::definition_of;
using test::program_text;
using test::sound_helical;

constexpr WindMode native = WindMode::native;

SimulatedProgram simulated(const WindDefinition& definition, WindMode mode) {
  return simulate_text("program", program_text(definition, mode));
}

// Six decimals of an angle, at the place where it is declared and where it is reached.
constexpr double text_deg = 1e-6;

TEST(WindSimulate, RandomFeasibleLayersCloseAndCover) {
  std::mt19937_64 random(5);
  const auto number = [&](double lo, double hi) {
    return std::uniform_real_distribution<double>(lo, hi)(random);
  };
  int wound = 0;
  while (wound < 1000) {
    WindDefinition definition = definition_of({});
    definition.mandrel = {number(20, 80), number(12, 40), {}};
    if (wound % 4 == 0)
      definition.mandrel.end_diameter_mm = definition.mandrel.diameter_mm * number(0.7, 0.99);
    definition.tow.width_mm = number(3, 8);
    HelicalLayer layer;
    layer.angle_deg = number(3, 85);
    layer.pattern = static_cast<std::int64_t>(number(1, 12));
    layer.skip = static_cast<std::int64_t>(number(1, 12));
    layer.lock_deg = number(200, 800);
    layer.lead_in_mm = number(1, 11);
    layer.lead_out_deg = number(5, 300);
    layer.skip_initial_near_lock = wound % 3 == 0;
    if (std::gcd(layer.pattern, layer.skip) != 1) continue;
    layer.lock_deg = closing_locks(layer.lock_deg, layer.skip, layer.pattern, native).back();
    definition.layers = {layer};
    if (first_fault(definition, native)) continue;
    ++wound;
    const SimulatedProgram program = simulated(definition, native);
    ASSERT_EQ(program.layers.size(), 1u);
    const SimulatedLayer& found = program.layers[0];
    EXPECT_EQ(found.starts, circuits(definition.mandrel, definition.tow, layer, native));
    EXPECT_LE(found.start_error_deg, text_deg);
    EXPECT_EQ(found.idle_moves, 0);
    EXPECT_EQ(found.backward_turns, 0);
    EXPECT_LE(found.coverage->widest_gap_mm, 1e-6)
        << layer.angle_deg << ' ' << layer.pattern << ' ' << found.coverage->gap_z_mm;
  }
}

// Without the rules: circuits on top of each other, and the bare strips that FiberPath's text speaks of.
TEST(WindSimulate, SeesAPatternThatDoesNotClose) {
  HelicalLayer layer = sound_helical();
  layer.lock_deg = 90;
  ASSERT_TRUE(first_fault(definition_of({layer}), native));
  const SimulatedLayer found = simulated(definition_of({layer}), native).layers.at(0);
  EXPECT_GT(found.start_error_deg, 5);
  EXPECT_GT(found.coverage->widest_gap_mm, 3);
  EXPECT_LT(found.coverage->covered_share, 0.99);
}

TEST(WindSimulate, HoopThereAndBackLiesTwice) {
  const SimulatedLayer found = simulated(definition_of({HoopLayer{}}), native).layers.at(0);
  EXPECT_NEAR(found.coverage->covered_share, 1, 1e-12);
  // once more, and at the ends at most a turn and a half of half a tow
  EXPECT_NEAR(found.coverage->overlap_share, 1 + 0.5 * 1.5 * 3.5 / 100, 0.5 * 1.5 * 3.5 / 100);
  EXPECT_EQ(found.starts, 1);
}

TEST(WindSimulate, CountsWhatFiberPathWastes) {
  HelicalLayer back = sound_helical();
  back.lead_out_deg = 400;
  const SimulatedLayer theirs = simulated(definition_of({back}), WindMode::fiberpath).layers.at(0);
  EXPECT_EQ(theirs.backward_turns,
            2 * 26 - 1);  // at each turnaround but the last, whose turn is merged with the lock
  EXPECT_GT(theirs.idle_moves, 0);
}

TEST(WindSimulate, LengthsAndTimesAreThePlans) {
  const WindDefinition definition =
      definition_of({HoopLayer{}, SkipLayer{30}, sound_helical(), HoopLayer{true}});
  std::string text;
  const ProgramReport report =
      write_program(definition, native, [&](std::string_view piece) { text += piece; });
  const SimulatedProgram program = simulate_text("program", text);
  ASSERT_EQ(program.layers.size(), report.layers.size());
  for (std::size_t i = 0; i < report.layers.size(); ++i) {
    const double length = report.layers[i].totals.total_length_mm();
    EXPECT_NEAR(program.layers[i].laid_mm + program.layers[i].turned_mm, length, 1e-8 * length);
    EXPECT_NEAR(program.layers[i].laid_mm, report.layers[i].totals.length_mm[0], 1e-8 * length);
    EXPECT_NEAR(program.layers[i].time_s, report.time_s(report.layers[i].totals), 1e-8 * length);
    EXPECT_EQ(program.layers[i].coverage.has_value(), i != 1);
  }
}

TEST(WindSimulate, RefusesWhatItCannotRead) {
  const std::string header =
      "; Parameters "
      "{\"mandrel\":{\"diameter\":70,\"windLength\":100},\"tow\":{\"width\":7,\"thickness\":1}}\n";
  const auto refusal = [&](const std::string& text) -> std::string {
    try {
      simulate_text("p.gcode", text);
      return "(read)";
    } catch (const Error& e) {
      return e.where() + ": " + e.what();
    }
  };
  const auto expect = [&](const std::string& text, const std::string& words) {
    EXPECT_NE(refusal(text).find(words), std::string::npos) << refusal(text);
  };
  EXPECT_EQ(refusal(header + "G0 F9000\r\n\r\nG1 X1.5 A2 F100 ; a remark\r\n"), "(read)");
  expect("", "p.gcode: Unable to locate Parameters header in program");
  expect(header, "p.gcode: holds no motion");
  expect(header + "G20\n", "p.gcode:2: Unsupported G-code opcode: 'G20'");
  expect(header + "G0 F100\nG0 Q1\n", "p.gcode:3: Unknown axis letter 'Q' in token 'Q1'");
  expect(header + "G0 Y360\n", "p.gcode:2: Detected unsupported XYZ axis program");
  expect(header + "G0 X5\n", "p.gcode:2: Feed rate must be set before moving the machine");
  expect(header + "G0 F100\nG0 X\n", "p.gcode:3: 'X' has no number");
  expect("; Parameters {}\n", "p.gcode:1: the Parameters header lacks a positive mandrel.diameter");
  expect("; Parameters {\n", "p.gcode:1: the Parameters header is not JSON");
}

}  // namespace
}  // namespace afptraj
