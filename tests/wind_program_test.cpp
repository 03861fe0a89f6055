// The programs that are written: facts of docs/winding.md, each by itself.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

#include "geometry/error.h"
#include "tests/winding_text.h"
#include "winding/frustum.h"
#include "winding/layer_rules.h"
#include "winding/pattern.h"

namespace afptraj {
namespace {

using test::axis_of;
using test::definition_of;
using test::lines_of;
using test::program_text;
using test::sound_helical;

constexpr WindMode fiberpath = WindMode::fiberpath, native = WindMode::native;

std::vector<std::string> program(const WindDefinition& definition, WindMode mode) {
  return lines_of(program_text(definition, mode));
}
std::vector<std::string> moves(void (*write)(ProgramWriter&), WindMode mode) {
  std::string text;
  ProgramWriter writer(70, mode, [&](std::string_view piece) { text += piece; });
  write(writer);
  writer.flush();
  return lines_of(text);
}

TEST(WindProgram, BeginsWithSixLines) {
  const std::vector<std::string> expected{
      R"(; Parameters {"irVersion":"1.0","mandrel":{"diameter":70,"windLength":100},"tow":{"width":7,"thickness":0.5}})",
      "G21 ; millimeter units",
      "G90 ; absolute positioning",
      "G94 ; feed rate in units per minute",
      "G0 X0 A0 B0",
      "G0 F9000"};
  EXPECT_EQ(program(definition_of({}), fiberpath), expected);
}

// n = round(|dX|) + 1 points, halves to even, the first of them where the axes already are.
TEST(WindProgram, MovesAreCutByHalvesToEven) {
  using Lines = std::vector<std::string>;
  const auto count = [](double dx) {
    std::string text;
    ProgramWriter writer(70, fiberpath, [&](std::string_view piece) { text += piece; });
    writer.move_to({dx, 0, 0});
    writer.flush();
    return lines_of(text).size();
  };
  EXPECT_EQ(count(0.5), 1u);  // 0 pieces: the target alone
  EXPECT_EQ(count(0.51), 2u);
  EXPECT_EQ(count(1.5), 3u);
  EXPECT_EQ(count(2.5), 3u);
  EXPECT_EQ(count(3.5), 5u);
  EXPECT_EQ(count(9e-7), 1u);
  EXPECT_EQ(moves(
                [](ProgramWriter& w) {
                  w.move_to({2, 30, -8});
                },
                fiberpath),
            (Lines{"G0 X0 A0 B0", "G0 X1 A15 B-4", "G0 X2 A30 B-8"}));
  EXPECT_EQ(moves(
                [](ProgramWriter& w) {
                  w.move_to({2, 30, -8});
                },
                native),
            (Lines{"G0 X1 A15 B-4", "G0 X2 A30 B-8"}));
}

TEST(WindProgram, SkipKeepsTheSignOfZeroForFiberPathOnly) {
  const WindDefinition definition = definition_of({SkipLayer{-1e-7}});
  EXPECT_EQ(program(definition, fiberpath)[7], "G0 X0 A-0 B0");
  for (const std::string& line : program(definition, native)) EXPECT_EQ(line.find("-0"), std::string::npos);
}

TEST(WindProgram, ZeroTurnsOnceMoreOnlyForFiberPath) {
  // twice 14.25 turns and three halves end on a whole turn
  WindDefinition definition = definition_of({HoopLayer{}});
  definition.mandrel.length_mm = 99.75;
  const auto theirs = program(definition, fiberpath), ours = program(definition, native);
  EXPECT_EQ(theirs[theirs.size() - 3], "G92 X0 A0 B0");
  EXPECT_EQ(theirs[theirs.size() - 2], "G0 X0 A360 B0");
  EXPECT_EQ(theirs.back(), "G92 A0");
  EXPECT_EQ(ours.back(), "G92 X0 A0 B0");
}

TEST(WindProgram, HoopPitchIsTheTow) {
  for (const WindMode mode : {fiberpath, native}) {
    const auto lines = program(definition_of({HoopLayer{true}}), mode);
    double last_x = 0, last_a = 180;
    for (const std::string& line : lines) {
      if (line.rfind("G0 X", 0) != 0 || axis_of(line, 'X') == last_x) continue;
      const double x = axis_of(line, 'X'), a = axis_of(line, 'A');
      EXPECT_NEAR((a - last_a) / 360 * 7, x - last_x, 1e-6);  // six decimals of an angle
      last_x = x, last_a = a;
    }
    EXPECT_EQ(last_x, 100);
  }
}

TEST(WindProgram, TheHeadLeansWithTheSpiral) {
  const auto lean = [](WindMode mode) {
    return axis_of(program(definition_of({HoopLayer{}}), mode).at(mode == fiberpath ? 8 : 11), 'B');
  };
  EXPECT_NEAR(lean(fiberpath), -std::atan(7 / 70.0) * 180 / std::numbers::pi, 1e-6);
  EXPECT_NEAR(lean(native), -std::atan(7 / (std::numbers::pi * 70)) * 180 / std::numbers::pi, 1e-6);
}

TEST(WindProgram, ConeHeaderIsComplete) {
  WindDefinition cone = definition_of({});
  cone.mandrel.end_diameter_mm = 40.5;
  EXPECT_EQ(program(cone, fiberpath)[0].find("endDiameter"), std::string::npos);
  EXPECT_NE(program(cone, native)[0].find(R"("endDiameter":40.5})"), std::string::npos);
}

// What a controller does with the lines: absolute places of the axes, with G92 as a change of origin.
struct Replay {
  double X = 0, A = 0, B = 0, origin_a = 0;
  bool moved = false;  // by the last line
  void line(const std::string& text) {
    const bool declares = text.rfind("G92", 0) == 0;
    moved = false;
    for (auto [letter, axis] : {std::pair{'X', &X}, {'A', &A}, {'B', &B}}) {
      const double value = axis_of(text, letter);
      if (std::isnan(value)) continue;
      if (declares && letter == 'A') origin_a += A - value;
      moved = moved || (!declares && value != *axis);
      *axis = value;
    }
  }
  double turned() const { return origin_a + A; }
};

std::vector<WindDefinition> various() {
  std::vector<WindDefinition> out{
      definition_of({HoopLayer{}, SkipLayer{-45.5}, sound_helical(), HoopLayer{true}})};
  HelicalLayer back = sound_helical();
  back.lead_out_deg = 400;
  back.pattern = 7;
  back.skip = 3;
  back.lock_deg = 3 * 180.0 / 7;
  out.push_back(definition_of({back, back}));
  back.pattern = 1;
  back.lock_deg = 180;
  out.push_back(definition_of({back, SkipLayer{0}}));
  WindDefinition cone = definition_of({sound_helical()});
  cone.mandrel.end_diameter_mm = 45;
  out.push_back(cone);
  return out;
}

// The laws of native programs: every line moves something, the mandrel never turns back, no comment stands
// behind a command, no number grows beyond what single precision holds to 1e-3 degrees.
TEST(WindProgram, NativeLaws) {
  for (const WindDefinition& definition : various()) {
    ASSERT_FALSE(first_fault(definition, native)) << first_fault(definition, native)->message;
    Replay replay;
    double before = 0;
    int first_moves = 2;  // "G0 X0 A0 B0" says where the axes are, "G0 F" how fast
    for (const std::string& line : program(definition, native)) {
      if (line[0] == ';') continue;
      EXPECT_EQ(line.find(';'), std::string::npos) << line;
      replay.line(line);
      const bool is_move = line.rfind("G0 ", 0) == 0 && first_moves-- <= 0;
      EXPECT_TRUE(replay.moved || !is_move) << line;
      EXPECT_GE(replay.turned(), before - 1e-9) << line;
      before = replay.turned();
      EXPECT_LT(std::abs(replay.A), 16384) << line;
    }
  }
}

TEST(WindProgram, FiberPathTurnsBackWhereTheLeadOutIsLongerThanTheLock) {
  bool back = false;
  Replay replay;
  double before = 0;
  for (const std::string& line : program(various()[1], fiberpath)) {
    if (line[0] == ';') continue;
    replay.line(line);
    back = back || replay.turned() < before - 1;
    before = replay.turned();
  }
  EXPECT_TRUE(back);
}

// The N circuits begin at N places, 360 / N apart.
void expect_even_starts(const WindDefinition& definition, WindMode mode, std::int64_t N) {
  Replay replay;
  std::set<std::int64_t> slots;
  std::int64_t circuits = 0;
  double worst = 0, first = 0;
  bool circuit = false;
  for (const std::string& line : program(definition, mode)) {
    circuit = circuit || line.find("Circuit:") != std::string::npos;
    if (line[0] == ';') continue;
    replay.line(line);
    if (!circuit || line.rfind("G0", 0) != 0 || replay.X != 0) continue;
    if (axis_of(line, 'B') != -10) continue;  // the head is ready to lay
    circuit = false;
    if (circuits++ == 0) first = replay.turned();
    const double slot = modulo(replay.turned() - first, 360) / 360 * static_cast<double>(N);
    worst = std::max(worst, std::abs(slot - std::round(slot)));
    slots.insert(std::llround(slot) % N);
  }
  EXPECT_EQ(circuits, N);
  EXPECT_EQ(slots.size(), static_cast<std::size_t>(N));
  EXPECT_LT(worst / static_cast<double>(N) * 360, 2e-6);  // two numbers of six decimals
}

TEST(WindProgram, StartsAreEven) {
  expect_even_starts(definition_of({sound_helical()}), fiberpath, 26);
  expect_even_starts(definition_of({sound_helical()}), native, 26);
  HelicalLayer layer = sound_helical();
  for (const std::int64_t p : {1, 3, 5, 7, 11, 13}) {
    layer.pattern = p;
    layer.skip = p > 2 ? 2 : 1;
    layer.lock_deg = closing_locks(150, layer.skip, p, native).front();
    expect_even_starts(definition_of({layer}), native, (26 + p - 1) / p * p);
  }
}

// Between the leads the fibre lies at the angle: circumference turned by axial way is tan(alpha).
TEST(WindProgram, TheAngleIsFromTheAxis) {
  for (const double angle : {10.0, 35.0, 54.7, 80.0}) {
    HelicalLayer layer = sound_helical();
    layer.angle_deg = angle;
    layer.pattern = 1;
    const auto lines = program(definition_of({layer}), native);
    std::size_t i = 0;
    while (axis_of(lines[i], 'X') != 50) ++i;
    const double arc = (axis_of(lines[i + 1], 'A') - axis_of(lines[i], 'A')) / 360 * std::numbers::pi * 70;
    const double way = axis_of(lines[i + 1], 'X') - axis_of(lines[i], 'X');
    EXPECT_NEAR(std::atan2(arc, way) * 180 / std::numbers::pi, angle, 1e-5);
    EXPECT_NEAR(axis_of(lines[i], 'B'), -(90 - angle), 1e-6);
  }
}

// A cone unrolls into a plane, where a geodesic is a straight line: in polar coordinates about the apex,
// s cos(theta sin(phi) - c) is constant with s the slant distance.
TEST(WindProgram, ConeGeodesicIsStraightWhenUnrolled) {
  const WindMandrel cone{98, 120, 54};
  const double phi = std::atan((49.0 - 27.0) / 120);
  for (const double angle : {5.0, 20.0, 33.0}) {
    const ConeGeodesic geodesic(cone, angle);
    const auto point = [&](double z) {
      const double slant = (49 - 22 * z / 120) / std::sin(phi);
      const double turned = geodesic.turn_deg(z) * std::numbers::pi / 180 * std::sin(phi);
      return std::pair{slant * std::cos(turned), slant * std::sin(turned)};
    };
    const auto [x0, y0] = point(0);
    const auto [x1, y1] = point(120);
    for (double z = 10; z < 120; z += 10) {
      const auto [x, y] = point(z);
      const double off = ((x1 - x0) * (y - y0) - (y1 - y0) * (x - x0)) / std::hypot(x1 - x0, y1 - y0);
      EXPECT_NEAR(off, 0, 1e-10);
      EXPECT_NEAR((49 - 22 * z / 120) * std::sin(geodesic.angle_deg(z) * std::numbers::pi / 180),
                  geodesic.clairaut_mm(), 1e-12);
    }
  }
}

TEST(WindProgram, TotalsAreTheSumOverTheLines) {
  for (const WindMode mode : {fiberpath, native}) {
    for (const WindDefinition& definition : various()) {
      if (first_fault(definition, mode)) continue;
      std::string text;
      const ProgramReport report =
          write_program(definition, mode, [&](std::string_view piece) { text += piece; });
      const auto lines = lines_of(text);
      EXPECT_EQ(report.totals.lines, static_cast<std::int64_t>(lines.size()));
      double length = 0;
      Replay replay;
      for (const std::string& line : lines) {
        if (line[0] == ';') continue;
        const Replay before = replay;
        replay.line(line);
        length += std::hypot(line[1] == '9' ? 0 : replay.X - before.X,
                             (replay.turned() - before.turned()) / 360 * std::numbers::pi * 70);
      }
      // each line is off by the rounding of six decimals at most
      EXPECT_NEAR(report.totals.total_length_mm(), length, 1e-6 * static_cast<double>(lines.size()));
    }
  }
}

TEST(WindProgram, RefusesAProgramWithoutEnd) {
  WindDefinition definition = definition_of({sound_helical()});
  definition.tow.width_mm = 1e-7;
  try {
    program(definition, fiberpath);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::resource_limit);
  }
}

}  // namespace
}  // namespace afptraj
