// Programs for domed mandrels, re-read: the path that the axes lay is the planned geodesic.
#include "winding/vessel_program.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <sstream>
#include <string>

#include "geometry/error.h"
#include "io/machine_program_file.h"
#include "tests/meridians.h"
#include "winding/pass_maker.h"

namespace afptraj {
namespace {

using std::numbers::pi;
using Vec3 = Eigen::Vector3d;

constexpr double promised_mm = 0.01;

MachineProfile machine() {
  MachineProfile profile;
  profile.axes[0] = MachineAxis{'X', -1000, 2000, 2000, 10000};
  profile.axes[1] = MachineAxis{'A', -1e9, 1e9, 3600, 20000};
  profile.axes[2] = MachineAxis{'Y', 0, 1000, 2000, 10000};
  profile.axes[3] = MachineAxis{'B', -180, 180, 3600, 20000};
  return profile;
}

MachineProfile two_axes(double eye_distance_mm) {
  MachineProfile profile = machine();
  profile.axes[2].reset();
  profile.axes[3].reset();
  profile.eye_room.fixed_mm = eye_distance_mm;
  return profile;
}

VesselWinding winding_of(const Meridian& meridian, const std::vector<VesselLayer>& layers,
                         double tow_mm = 25) {
  return {meridian, {tow_mm, 0.3}, 6000, layers};
}

struct Written {
  std::string text;
  VesselReport report;
  SimulatedMachineProgram simulated;
};

Written written(const VesselWinding& winding, const MachineProfile& profile) {
  Written out;
  out.report = write_vessel_program(winding, profile, OverSpeed::clamp,
                                    [&](std::string_view piece) { out.text += piece; });
  out.simulated = simulate_machine_text("program", out.text);
  return out;
}

Vec3 place(double r, double turn, double z) { return {r * std::cos(turn), r * std::sin(turn), z}; }

double distance(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 e = b - a;
  const double share = e.squaredNorm() > 0 ? std::clamp((p - a).dot(e) / e.squaredNorm(), 0.0, 1.0) : 0;
  return (p - a - share * e).norm();
}

// The planned path of a whole layer, from its integrals alone: from a turn at the first end on.
struct PlannedPath {
  std::vector<Vec3> points;
  std::vector<double> lengths;

  PlannedPath(const Meridian& meridian, const VesselPattern& pattern, const SteeringRule& rule = {}) {
    const FibrePass pass = PassMaker(meridian, rule).at(pattern.angle_deg).value().pass;
    const std::vector<FibrePoint> fibre = pass.points(rule.on_widest ? 6000 : 1000);
    for (std::int64_t k = 0; k < pattern.circuits; ++k) {
      const double turn = 2 * static_cast<double>(k) * pass.turn_rad(),
                   length = 2 * static_cast<double>(k) * pass.length_mm();
      for (const FibrePoint& at : fibre) add(at, turn + at.turn_rad, length + at.length_mm);
      for (std::size_t i = fibre.size(); i-- > 0;)
        add(fibre[i], turn + 2 * pass.turn_rad() - fibre[i].turn_rad,
            length + 2 * pass.length_mm() - fibre[i].length_mm);
    }
  }

  // From a place that lies some `length` along it.
  double distance_to(const Vec3& p, double length) const {
    const double window = 3;
    auto i = static_cast<std::size_t>(std::lower_bound(lengths.begin(), lengths.end(), length - window) -
                                      lengths.begin());
    double least = 1e300;
    for (i = i > 0 ? i - 1 : 0; i + 1 < points.size() && lengths[i] < length + window; ++i)
      least = std::min(least, distance(p, points[i], points[i + 1]));
    return least;
  }

 private:
  void add(const FibrePoint& at, double turn, double length) {
    points.push_back(place(at.r_mm, turn, at.z_mm));
    lengths.push_back(length);
  }
};

// Friction is told from the axes alone; what the eye's straight pieces add is within 0.0025 mm over a thread
// of 30 mm by turns of a path that presses on with 1 / 100 mm.
void expect_slip(const VesselPattern& pattern, const LaidTravel& laid) {
  const double needed = std::max(std::abs(pattern.ratio_first), std::abs(pattern.ratio_last));
  EXPECT_GT(laid.slip_ratio, needed - 0.02);
  EXPECT_LT(laid.slip_ratio, needed + 0.02);
}

// What was laid, turned back to where the planner counts from.
void expect_rebuilt(const Meridian& meridian, const VesselLayerReport& planned, const LaidTravel& laid,
                    const SteeringRule& rule = {}) {
  const PlannedPath path(meridian, planned.pattern, rule);
  ASSERT_GT(laid.path.size(), 100u);
  const double turned = laid.path.front().turn_rad;
  EXPECT_NEAR(std::remainder(turned, 2 * pi), 0, 1e-9);
  double worst = 0;
  for (const ContactPoint& at : laid.path)
    worst = std::max(worst, path.distance_to(place(at.r_mm, at.turn_rad - turned, at.z_mm), at.length_mm));
  EXPECT_LT(worst, promised_mm);
  // to the end: steps of the simulation stop less than one before it
  EXPECT_NEAR(laid.laid_mm, planned.laid_mm, simulation_step_mm + promised_mm);
  EXPECT_NEAR(planned.laid_mm, path.lengths.back(), 1e-6 * path.lengths.back());
  EXPECT_EQ(laid.starts, planned.pattern.circuits);
  // Each of N passes there crosses each of N back as often as a circuit turns the mandrel; all meet at the
  // turns of one end, where the layer begins, and of the other, which is no crossing.
  if (rule.on_widest) return;
  const auto N = static_cast<double>(planned.pattern.circuits);
  EXPECT_EQ(laid.crossings, std::llround(N * N * planned.pattern.turn_deg / 360 - N));
  expect_slip(planned.pattern, laid);
}

Written expect_rebuilt(const VesselWinding& winding, const MachineProfile& profile) {
  Written program = written(winding, profile);
  EXPECT_EQ(program.simulated.layers.size(), winding.layers.size());
  for (std::size_t i = 0; i < program.simulated.layers.size(); ++i) {
    SteeringRule rule = winding.layers[i].steering;
    rule.tow_width_mm = winding.tow.width_mm;
    if (winding.layers[i].hoop) rule = hoop_rule(program.report.layers[i].pattern.angle_deg, winding.tow);
    expect_rebuilt(*program.report.layers[i].mandrel, program.report.layers[i],
                   program.simulated.layers[i].laid, rule);
    EXPECT_EQ(program.simulated.layers[i].backward_turns, 0);
    EXPECT_EQ(program.simulated.layers[i].idle_moves, 0);
  }
  return program;
}

TEST(VesselProgram, IsRebuiltOnVessels) {
  for (const double height : {60.0, 21.0}) {
    VesselWinding winding = winding_of(test::vessel(60, 90, height), {{37, 9, 0.3}, {54, 6, 0.3}}, 25);
    winding.growth = false;
    expect_rebuilt(winding, height > 30 ? machine() : two_axes(100));
  }
}

TEST(VesselProgram, IsRebuiltOnUnequalDomes) {
  std::vector<BSplineCurve2> pieces{test::quarter_ellipse(-80, 0, 0, 100, false),
                                    line_segment({0, 100}, {200, 100}),
                                    test::quarter_ellipse(200, 100, 240, 0, true)};
  expect_rebuilt(winding_of(Meridian(std::move(pieces)), {{35, 5, 0.2}}, 50), machine());
}

// Between openings of unlike radii, and on a tube between lock turns.
TEST(VesselProgram, IsRebuiltWhenSteered) {
  VesselLayer unlike{30, 5, 0.3};
  unlike.steering = {0.3, 40, 65, 0};
  const Written program = expect_rebuilt(winding_of(test::vessel(100, 150, 60), {unlike}, 40), machine());
  EXPECT_NEAR(program.simulated.layers[0].laid.least_r_first_mm, 40, 0.01);
  EXPECT_NEAR(program.simulated.layers[0].laid.least_r_last_mm, 65, 0.01);
  VesselLayer locked{50, 4, 0.3};
  locked.steering.friction = 0.25;
  const Meridian tube = meridian_through({{0, 50}, {260, 50}});
  const Written on_tube = expect_rebuilt(winding_of(tube, {locked}, 30), two_axes(90));
  EXPECT_EQ(on_tube.simulated.layers[0].laid.coverage.covered_share, 1);
  // what runs one way touches side by side where the angle stays, and hardly parts where it changes
  EXPECT_GT(on_tube.simulated.layers[0].laid.one_way.covered_share, 0.999);
}

// Each layer on what those before it have left, hoops among them.
TEST(VesselProgram, IsRebuiltOnGrownMandrels) {
  VesselLayer hoop, helical{35, 6, 0.3};
  hoop.hoop = true;
  const Meridian tank = test::vessel(60, 130, 40);
  VesselWinding winding = winding_of(tank, {helical, hoop, helical}, 30);
  const Written program = expect_rebuilt(winding, machine());
  ASSERT_EQ(program.report.layers.size(), 3u);
  const auto radius = [&](std::size_t i) {
    const Meridian& mandrel = *program.report.layers[i].mandrel;
    return mandrel.at(mandrel.nearest(60, 62)).r_mm;
  };
  // two tows and their overlap; two tows
  EXPECT_NEAR(radius(1), 60 + 0.6 * (1 + program.report.layers[0].pattern.overlap), 1e-9);
  EXPECT_NEAR(radius(2), radius(1) + 0.6, 1e-9);
  // the simulation stops a step before the last turn of the hoops is round
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_GT(program.simulated.layers[i].laid.coverage.covered_share, 0.9999);
  // a screw each way, one turn by tow's width between the last tows' middles, but for its four ends, where
  // half a turn takes (nearly) half the way that it has on the screw
  const double turns = std::ceil((130 - 30) / 30.0);
  EXPECT_NEAR(program.report.layers[1].pattern.turn_deg, 2 * 360 * turns + 4 * 90, 1);
  winding.growth = false;
  const Written still = written(winding, machine());
  EXPECT_EQ(still.report.layers[2].mandrel->at(1.5).r_mm, 60);
  EXPECT_EQ(still.text.find("Mandrel grown"), std::string::npos);
}

// Domes from a table, whose splines meet the cylinder in a slight edge. `slant` sharpens it.
Meridian tabulated(int rows, double slant) {
  std::vector<MeridianRow> dome;
  for (int k = 1; k <= rows; ++k) {
    const double a = pi / 2 * (0.1 + 0.9 * k / rows);
    dome.push_back({-70 * std::cos(a), 100 * std::sin(a) - slant * 70 * std::cos(a)});
  }
  std::vector<MeridianRow> all = dome;
  all.push_back(dome.back());
  all.push_back({250, 100});
  for (auto row = dome.rbegin(); row != dome.rend(); ++row) all.push_back({250 - row->z_mm, row->r_mm});
  return meridian_through(all);
}

TEST(VesselProgram, IsRebuiltOnTables) {
  expect_rebuilt(winding_of(tabulated(50, 0), {{30, 4, 0.3}}, 60), machine());    // -3e-5 rad
  expect_rebuilt(winding_of(tabulated(10, 0.1), {{30, 4, 0.3}}, 60), machine());  // 0.098 rad
  // hollow by 0.0029 rad: the eye goes back, which the report says
  const VesselWinding hollow = winding_of(tabulated(10, 0), {{30, 4, 0.3}}, 60);
  const Written program = written(hollow, machine());
  expect_rebuilt(hollow.meridian, program.report.layers[0], program.simulated.layers[0].laid);
  EXPECT_GT(program.report.layers[0].backward_turns, 0);
  EXPECT_EQ(program.report.layers[0].backward_turns, program.simulated.layers[0].backward_turns);
}

std::string refusal(const VesselWinding& winding, const MachineProfile& profile,
                    OverSpeed over_speed = OverSpeed::clamp) {
  try {
    write_vessel_program(winding, profile, over_speed, [](std::string_view) {});
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::no_path);
    return e.where() + ": " + e.what();
  }
  return "";
}

TEST(VesselProgram, RefusesWhatCannotBeWound) {
  const auto expect_has = [](const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  const Meridian tank = test::vessel(100, 250, 60);
  expect_has(refusal(winding_of(tabulated(10, 0.3), {{30, 2, 0.1}}), machine()),
             "mandrel: has an edge of 16.7 deg at z = ");
  expect_has(refusal(winding_of(tabulated(10, -0.02), {{30, 2, 0.1}}), machine()),
             "where the thread would bridge");
  expect_has(refusal(winding_of(tank, {{2, 1, 0.1}}), machine()), "layer 1: the polar opening at this angle");
  expect_has(refusal(winding_of(tank, {{20, 2, 0.1}, {40, 0, 0.1}}), machine()),
             "layer 2: no pattern closes");
  expect_has(refusal(winding_of(tank, {{20, 2, 0.1, 7, 3}}), machine()), "the first that does has ");
  VesselLayer hoop;
  hoop.hoop = true;
  expect_has(refusal(winding_of(test::vessel(100, 40, 60), {hoop}), machine()),
             "layer 1: the mandrel's cylinder is shorter than two tows");
  expect_has(refusal(winding_of(tank, {{20, 2, 0.1}}), two_axes(110)), "machine: its eye stands 110 mm");
  MachineProfile small = machine();
  small.axes[0]->lowest = 0;
  expect_has(refusal(winding_of(tank, {{20, 2, 0.1}}), small), "layer 1: carriage would travel from ");
  MachineProfile slow = machine();
  slow.axes[0]->speed_per_s = 50;
  expect_has(refusal(winding_of(tank, {{20, 2, 0.1}}), slow, OverSpeed::refuse),
             "FeedRateExceeded: layer 1: carriage would run at ");
}

TEST(VesselProgram, TakesTheChosenPattern) {
  const Meridian tank = test::vessel(100, 250, 60);
  const auto found = find_vessel_patterns(tank, {20, 2, 12, 0.1, 1'000'000});
  ASSERT_GT(found.size(), 3u);
  const VesselPattern& last = found.back();
  const VesselPattern chosen = layer_pattern(tank, {12, 0.3}, {20, 2, 0.1, last.circuits, last.stride}, 1);
  EXPECT_EQ(chosen.circuits, last.circuits);
  EXPECT_EQ(chosen.stride, last.stride);
  const VesselPattern first = layer_pattern(tank, {12, 0.3}, {20, 2, 0.1}, 1);
  EXPECT_EQ(first.angle_deg, find_vessel_patterns(tank, {20, 2, 12, 0.1, 12}).front().angle_deg);
}

// One line's axes by letter, by its own reading.
std::map<char, double> words_of(const std::string& line) {
  std::istringstream in(line);
  std::map<char, double> out;
  std::string word;
  while (in >> word) out[word[0]] = std::stod(word.substr(1));
  return out;
}

// By the written feeds no axis is faster than it can.
TEST(VesselProgram, KeepsTheAxesToTheirSpeeds) {
  MachineProfile profile = machine();
  profile.roll_over = false;
  profile.axes[0]->speed_per_s = 300;
  profile.axes[3]->speed_per_s = 90;
  std::string text;
  const VesselReport report =
      write_vessel_program(winding_of(test::vessel(100, 250, 60), {{20, 5, 0.3}}, 60), profile,
                           OverSpeed::clamp, [&](std::string_view piece) { text += piece; });
  EXPECT_FALSE(report.layers[0].clamped.empty());
  std::istringstream lines(text);
  std::map<char, double> at{{'X', 0}, {'A', 0}, {'Y', 0}, {'B', 0}};
  std::string line;
  double fastest = 0;
  std::int64_t moves = 0;
  while (std::getline(lines, line)) {
    if (line.substr(0, 2) != "G1") continue;
    std::map<char, double> words = words_of(line.substr(3)), delta;
    double square = 0;
    for (auto& [letter, place] : at) {
      if (words.count(letter) == 0) continue;
      delta[letter] = words[letter] - place;
      place = words[letter];
      square += delta[letter] * delta[letter];
    }
    const double seconds = std::sqrt(square) / words['F'] * 60;
    // texts are off by 1e-6 at most
    const double rounding = 2e-6 / seconds;
    EXPECT_LE(std::abs(delta['X']) / seconds, 300 * (1 + 1e-6) + rounding);
    EXPECT_LE(std::abs(delta['B']) / seconds, 90 * (1 + 1e-6) + rounding);
    fastest = std::max(fastest, std::abs(delta['X']) / seconds);
    ++moves;
  }
  EXPECT_GT(moves, 1000);
  EXPECT_NEAR(fastest, 300, 1);
}

// The same path by any dialect, unit, and count of the mandrel.
TEST(VesselProgram, SaysTheSameInAllDialects) {
  const VesselWinding winding = winding_of(test::vessel(60, 90, 40), {{25, 5, 0.3}}, 30);
  for (const Dialect dialect : {Dialect::xab, Dialect::xyz, Dialect::rs274}) {
    MachineProfile profile = machine();
    profile.dialect = dialect;
    profile.inches = dialect != Dialect::xab;
    profile.roll_over = dialect != Dialect::rs274;
    if (dialect == Dialect::xyz)
      profile.axes[1]->letter = 'Y', profile.axes[2]->letter = 'Z', profile.axes[3]->letter = 'A';
    const Written program = expect_rebuilt(winding, profile);
    EXPECT_NEAR(program.simulated.layers[0].time_s, program.report.layers[0].asked_time_s,
                1e-3 * program.report.layers[0].asked_time_s);
    EXPECT_EQ(program.text.find("G92") != std::string::npos, profile.roll_over);
  }
}

// What lies on the mandrel is seen, not what was planned: a circuit that is cut out leaves its strip bare,
// and an eye that is pushed aside lays aside.
TEST(VesselProgram, SimulationSeesWhatIsWrong) {
  const VesselWinding winding = winding_of(test::vessel(100, 150, 60), {{30, 3, 0.2}}, 30);
  const Written program = written(winding, machine());
  EXPECT_EQ(program.simulated.layers[0].laid.coverage.covered_share, 1);
  EXPECT_EQ(program.simulated.layers[0].laid.one_way.covered_share, 1);
  EXPECT_LT(program.simulated.layers[0].laid.start_error_deg, 0.01);
  const std::string mark = "; Circuit ";
  const std::size_t last = program.text.rfind(mark), end = program.text.find("; Tow cut");
  const std::string shorter = program.text.substr(0, last) + program.text.substr(end);
  const LaidTravel bare = simulate_machine_text("program", shorter).layers[0].laid;
  EXPECT_EQ(bare.coverage.covered_share, 1);  // by what runs the other way
  EXPECT_LT(bare.one_way.covered_share, 1);
  const VesselPattern& pattern = program.report.layers[0].pattern;
  // a tow and its overlap with both neighbours are missing, across at the widest place
  const double spacing = 2 * pi * 100 / static_cast<double>(program.report.layers[0].pattern.circuits);
  EXPECT_NEAR(bare.one_way.widest_gap_mm, 2 * spacing - 30 / std::cos(pattern.angle_deg * pi / 180), 1);
  EXPECT_EQ(bare.starts, pattern.circuits - 1);
  std::string pushed = program.text;
  const std::size_t x = pushed.find(" X", last + 2000) + 2;
  const double at = std::stod(pushed.substr(x));
  pushed.replace(x, pushed.find(' ', x) - x, std::to_string(at + 5));
  const PlannedPath path(winding.meridian, pattern);
  const LaidTravel aside = simulate_machine_text("program", pushed).layers[0].laid;
  double worst = 0;
  for (const ContactPoint& point : aside.path)
    worst = std::max(
        worst, path.distance_to(place(point.r_mm, point.turn_rad - aside.path.front().turn_rad, point.z_mm),
                                point.length_mm));
  EXPECT_GT(worst, promised_mm);
}

VesselWinding small_winding() { return winding_of(test::vessel(60, 90, 40), {{35, 8, 0.3}}, 40); }

std::string text_of(const VesselWinding& winding) {
  std::string text;
  write_vessel_program(winding, machine(), OverSpeed::clamp, [&](std::string_view piece) { text += piece; });
  return text;
}

std::string reading(const std::string& text) {
  try {
    simulate_machine_text("program", text);
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::bad_input);
    return e.where() + ": " + e.what();
  }
  return "";
}

TEST(VesselProgram, DefectsOfProgramsAreNamed) {
  const std::string text = text_of(small_winding());
  ASSERT_TRUE(is_machine_program(text));
  EXPECT_FALSE(is_machine_program("; Parameters {}\nG21\n; Machine carriage X\n"));
  const auto with = [&](const std::string& what, const std::string& instead) {
    std::string out = text;
    const std::size_t at = out.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return reading(out.replace(at, what.size(), instead));
  };
  const auto expect_has = [](const std::string& found, const std::string& part) {
    EXPECT_NE(found.find(part), std::string::npos) << found;
  };
  expect_has(with("G21", "G17"), "'G17' is unknown; use G0, G1");
  expect_has(with("; Tow width", "; Tow"), "the header has no tow");
  expect_has(with("; Meridian degree 2", "; Meridian degree 0"), "degree is out of range");
  expect_has(with("; Knots", "; Knot"), "knots and poles do not match");
  expect_has(with(" X", " Q"), "names no axis of the header");
  expect_has(with("; Tow fixed at z", "; Tow fixed at"), "lacks 'z ");
  expect_has(with("G1 Y", "G1 Yx"), "is no number");
  expect_has(with("; Tow fixed", "; Tow fxied"), "the program lays nothing");
}

TEST(VesselProgram, SameInputSameBytes) { EXPECT_EQ(text_of(small_winding()), text_of(small_winding())); }

}  // namespace
}  // namespace afptraj
