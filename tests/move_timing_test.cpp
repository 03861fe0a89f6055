// Speeds, limits and times of machine moves, against closed forms.
#include "winding/move_timing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "winding/machine_writer.h"

namespace afptraj {
namespace {

using std::numbers::pi;

MachineProfile profile_of(double carriage_speed, double carriage_acceleration) {
  MachineProfile profile;
  profile.axes[0] = MachineAxis{'X', -1000, 1000, carriage_speed, carriage_acceleration};
  profile.axes[1] = MachineAxis{'A', -1e9, 1e9, 720, 1440};
  profile.eye_room.fixed_mm = 100;
  return profile;
}

// A helix at `angle` on a cylinder of radius 50 over 300 mm, in `count` moves.
std::vector<MachineMove> helix(double angle, int count) {
  std::vector<MachineMove> moves;
  for (int k = 1; k <= count; ++k) {
    const double z = 300.0 * k / count;
    moves.push_back({{z, z * std::tan(angle) / 50 * 180 / pi, 0, 0},
                     MovePurpose::lay,
                     300 / std::cos(angle) / count,
                     angle});
  }
  return moves;
}

// d / v + v / a, however the way is cut.
TEST(MoveTiming, TrapezoidOfOneAxis) {
  const MachineProfile profile = profile_of(200, 500);
  for (const int count : {1, 2, 7, 300}) {
    std::vector<MachineMove> moves;
    for (int k = 1; k <= count; ++k) moves.push_back({{400.0 * k / count, 0, 0, 0}, MovePurpose::reposition});
    set_times(moves, {}, profile, 100, OverSpeed::refuse, 1);
    EXPECT_NEAR(trapezoidal_time_s(moves, {}, profile), 400.0 / 200 + 200.0 / 500, 1e-9) << count;
  }
}

// Too short for full speed: up and down only, 2 sqrt(d / a).
TEST(MoveTiming, TriangleOfAShortMove) {
  const MachineProfile profile = profile_of(200, 500);
  std::vector<MachineMove> moves{{{20, 0, 0, 0}, MovePurpose::reposition}};
  set_times(moves, {}, profile, 100, OverSpeed::refuse, 1);
  EXPECT_NEAR(trapezoidal_time_s(moves, {}, profile), 2 * std::sqrt(20.0 / 500), 1e-9);
}

// There and back: the axis stops where it turns.
TEST(MoveTiming, StopsAtAReversal) {
  const MachineProfile profile = profile_of(200, 500);
  std::vector<MachineMove> moves;
  for (int k = 1; k <= 800; ++k)
    moves.push_back({{k <= 400 ? 1.0 * k : 800.0 - k, 0, 0, 0}, MovePurpose::reposition});
  set_times(moves, {}, profile, 100, OverSpeed::refuse, 1);
  // Two trapezoids. The change by 2 v = 400 mm/s is spread over 5 ms of asked time, so that it is passed at
  // f^2 = 500 * 0.005 / 400, which saves both ramps f v / a = 0.0316 s each.
  EXPECT_NEAR(trapezoidal_time_s(moves, {}, profile), 2 * (2.0 + 0.4), 0.064);
}

TEST(MoveTiming, LaysAtTheFeed) {
  std::vector<MachineMove> moves = helix(0.5, 60);
  EXPECT_TRUE(set_times(moves, {}, profile_of(1e4, 1e6), 80, OverSpeed::refuse, 1).empty());
  double time = 0;
  for (const MachineMove& move : moves) time += move.time_s;
  EXPECT_NEAR(time, 300 / std::cos(0.5) / 80, 1e-9);
}

// v_carriage = feed cos a; clamped to v the fibre lies at tan a' = feed sin a / v.
TEST(MoveTiming, ClampsTheCarriage) {
  const double angle = 0.3, feed = 400, limit = 250;
  std::vector<MachineMove> moves = helix(angle, 60);
  const auto clamped = set_times(moves, {}, profile_of(limit, 1e6), feed, OverSpeed::clamp, 1);
  ASSERT_EQ(clamped.size(), 1u);
  EXPECT_EQ(clamped[0].axis, WinderAxis::carriage);
  EXPECT_EQ(clamped[0].moves, 60);
  EXPECT_NEAR(clamped[0].wanted_per_s, feed * std::cos(angle), 1e-9);
  const double expected = std::atan(feed * std::sin(angle) / limit);
  EXPECT_NEAR(clamped[0].loose_angle_rad, expected, 1e-12);
  EXPECT_NEAR(clamped_angle_rad(angle, feed, limit), expected, 1e-12);
  EXPECT_EQ(clamped_angle_rad(angle, 100, limit), angle);
  AxisValues at{};
  for (const MachineMove& move : moves) {
    EXPECT_NEAR((move.to[0] - at[0]) / move.time_s, limit, 1e-6);
    at = move.to;
  }
}

TEST(MoveTiming, OrRefuses) {
  std::vector<MachineMove> moves = helix(0.3, 60);
  try {
    set_times(moves, {}, profile_of(250, 1e6), 400, OverSpeed::refuse, 3);
    FAIL();
  } catch (const FeedRateExceeded& e) {
    EXPECT_EQ(e.axis, WinderAxis::carriage);
    EXPECT_EQ(e.layer, 3u);
    EXPECT_NEAR(e.value, 400 * std::cos(0.3), 1e-9);
    EXPECT_EQ(e.limit, 250);
    // with the feed that it names it runs
    EXPECT_TRUE(
        set_times(moves, {}, profile_of(250, 1e6), 250 / std::cos(0.3) * (1 - 1e-12), OverSpeed::refuse, 3)
            .empty());
  }
}

std::string program(MachineProfile profile, const std::vector<MachineMove>& moves) {
  std::string text;
  MachineWriter writer(profile, [&](std::string_view piece) { text += piece; });
  for (const MachineMove& move : moves) {
    writer.move(move);
    writer.roll_over();
  }
  writer.end();
  return text;
}

TEST(MachineWriter, Dialects) {
  MachineProfile profile = profile_of(100, 100);
  const std::vector<MachineMove> moves{{{25.4, 30, 0, 0}, MovePurpose::lay, 1, 0, 0.5},
                                       {{25.4, 725, 0, 0}, MovePurpose::lay, 1, 0, 2},
                                       {{50.8, 735, 0, 0}, MovePurpose::lay, 1, 0, 1}};
  // sqrt(25.4^2 + 30^2) * 120, 695 * 30, sqrt(25.4^2 + 10^2) * 60
  EXPECT_EQ(program(profile, moves),
            "G1 X25.4 A30 F4717.02279\nG1 A725 F20850\nG92 A5\nG1 X50.8 A15 F1637.857137\n");
  profile.roll_over = false;
  profile.dialect = Dialect::rs274;
  profile.inches = true;
  EXPECT_EQ(program(profile, moves), "G1 X1 A30 F120\nG1 A725 F30\nG1 X2 A735 F60\nM2\n");
}

}  // namespace
}  // namespace afptraj
