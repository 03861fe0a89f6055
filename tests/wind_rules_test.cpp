// Which definitions can be wound, and what is said of the others.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <set>

#include "tests/winding_text.h"
#include "winding/layer_rules.h"
#include "winding/pattern.h"

namespace afptraj {
namespace {

using test::definition_of;
using test::sound_helical;

std::string fault_of(const WindDefinition& definition, WindMode mode) {
  const auto fault = first_fault(definition, mode);
  return fault ? std::to_string(fault->layer) + ": " + fault->message : "";
}
std::string fault_of(const HelicalLayer& layer, WindMode mode) {
  return fault_of(definition_of({layer}), mode);
}

HelicalLayer changed(void (*change)(HelicalLayer&)) {
  HelicalLayer layer = sound_helical();
  change(layer);
  return layer;
}

constexpr WindMode fiberpath = WindMode::fiberpath, native = WindMode::native;

TEST(WindRules, SoundLayersHaveNoFault) {
  for (const WindMode mode : {fiberpath, native}) {
    EXPECT_EQ(fault_of(definition_of({HoopLayer{}, SkipLayer{-20}, sound_helical(), HoopLayer{true}}), mode),
              "");
    EXPECT_EQ(fault_of(definition_of({}), mode), "");
  }
}

TEST(WindRules, FiberPathTexts) {
  EXPECT_EQ(fault_of(definition_of({HoopLayer{true}, HoopLayer{}}), fiberpath),
            "2: terminal layer must be the final entry in the definition");
  EXPECT_EQ(fault_of(changed([](HelicalLayer& l) { l.angle_deg = 95; }), fiberpath),
            "1: wind angle 95.0° must be between 1.0° and 89.0°");
  EXPECT_EQ(fault_of(changed([](HelicalLayer& l) { l.skip = 2; }), fiberpath),
            "1: skipIndex must be less than patternNumber");
  EXPECT_EQ(fault_of(changed([](HelicalLayer& l) { l.pattern = 6, l.skip = 4; }), fiberpath),
            "1: skipIndex and patternNumber must be coprime for full coverage");
  EXPECT_EQ(
      fault_of(changed([](HelicalLayer& l) { l.lead_in_mm = 600; }), fiberpath),
      "1: leadInMM (600.0mm) must be less than the mandrel windLength (100.0mm); a longer lead-in drives "
      "the carriage off the mandrel into negative coordinates");
  EXPECT_EQ(fault_of(changed([](HelicalLayer& l) { l.pattern = 7, l.skip = 2; }), fiberpath),
            "1: computed circuit count is not divisible by patternNumber (26 % 7 != 0)");
  EXPECT_EQ(
      fault_of(changed([](HelicalLayer& l) { l.lock_deg = 100; }), fiberpath),
      "1: lockDegrees 100.0° produces a per-circuit mandrel advance of 200° (mod 360°), which is not "
      "divisible by the in-pattern slot width of 180° (= 360 / patternNumber 2). Circuits will overlap "
      "and leave bare mandrel strips. lockDegrees must be a multiple of 90°. Nearest valid values: 180°, "
      "360°, 540°");
}

// One fault hides the later ones, in a fixed order.
TEST(WindRules, TheFirstFaultCounts) {
  HelicalLayer all = sound_helical();
  all.angle_deg = 0.5, all.pattern = 4, all.skip = 6, all.lead_in_mm = 600, all.lock_deg = 100;
  const char* order[] = {"wind angle",      "skipIndex must be less",
                         "must be coprime", "leadInMM",
                         "26 % 4 != 0",     "lockDegrees 100.0° produces a per-circuit",
                         "slot stride"};
  void (*const cures[])(HelicalLayer&) = {
      [](HelicalLayer& l) { l.angle_deg = 35; }, [](HelicalLayer& l) { l.skip = 2; },
      [](HelicalLayer& l) { l.skip = 1; },       [](HelicalLayer& l) { l.lead_in_mm = 5; },
      [](HelicalLayer& l) { l.pattern = 2; },    [](HelicalLayer& l) { l.lock_deg = 90; },
      [](HelicalLayer& l) { l.lock_deg = 180; }};
  for (std::size_t i = 0; i < std::size(order); ++i) {
    EXPECT_NE(fault_of(all, fiberpath).find(order[i]), std::string::npos) << fault_of(all, fiberpath);
    cures[i](all);
  }
  EXPECT_EQ(fault_of(all, fiberpath), "");
}

TEST(WindRules, Cones) {
  WindDefinition cone = definition_of({sound_helical()});
  cone.mandrel = {98, 120, 54};
  auto& layer = std::get<HelicalLayer>(cone.layers[0]);
  layer.pattern = 3;
  layer.angle_deg = 40;
  for (const WindMode mode : {fiberpath, native}) {
    EXPECT_EQ(
        fault_of(cone, mode),
        "1: wind angle 40.0° is too steep for the cone: the geodesic (Clairaut C=31.5mm) cannot reach the "
        "small-end radius 27mm. Reduce the wind angle to <= 33.44°");
    EXPECT_EQ(first_fault(cone, mode)->code, ErrorCode::no_path);
  }
  cone.mandrel = {54, 120, 98};
  EXPECT_EQ(
      fault_of(cone, fiberpath),
      "1: cone requires a reducing frustum with r0 > r1 (got r0=27.0, r1=49.0); the wind angle anchors at "
      "the large end r0, so mount the large end at z=0");
  cone.layers = {SkipLayer{90}};
  EXPECT_EQ(fault_of(cone, fiberpath), "");
  cone.layers = {HoopLayer{}};
  EXPECT_EQ(fault_of(cone, fiberpath), "1: hoop layers on a cone are not supported yet");
  cone.mandrel.end_diameter_mm = 54;  // equal ends: a cylinder
  EXPECT_EQ(fault_of(cone, fiberpath), "");
}

// Winds by counting: the places of the p circuits of a pattern, in slots.
std::size_t places(double lock, std::int64_t d, std::int64_t p) {
  std::set<std::int64_t> seen;
  double at = 0;
  for (std::int64_t i = 0; i < p; ++i) {
    seen.insert(std::llround(modulo(at, 360) / 360 * static_cast<double>(p)) % p);
    at += 2 * lock + static_cast<double>(d) * 360 / static_cast<double>(p);
  }
  return seen.size();
}

// In native mode every lock k 180/p typed in full is judged by what it does; FiberPath refuses some whose
// remainder comes out just below a slot.
TEST(WindRules, LocksByBruteForceUpToSixty) {
  int falsely_refused = 0, counted = 0;
  for (std::int64_t p = 2; p <= 60; ++p) {
    for (std::int64_t d = 1; d < p; d += 1 + p / 7) {
      for (std::int64_t k = 1; k <= 2 * p; ++k) {
        const double lock = static_cast<double>(k) * 180 / static_cast<double>(p);
        const bool full = places(lock, d, p) == static_cast<std::size_t>(p);
        ASSERT_EQ(lock_closes(lock, d, p, native), full) << p << ' ' << d << ' ' << k;
        ++counted;
        falsely_refused += full && !lock_closes(lock, d, p, fiberpath) ? 1 : 0;
      }
    }
  }
  EXPECT_GT(falsely_refused, counted / 10);
  EXPECT_FALSE(lock_closes(7 * 180.0 / 13, 5, 13, fiberpath));
  EXPECT_TRUE(lock_closes(7 * 180.0 / 13, 5, 13, native));
}

TEST(WindRules, NativeSuggestionsAreTheNearestAndHold) {
  for (std::int64_t p = 1; p <= 60; ++p) {
    for (const double lock : {0.5, 100.3, 540.5}) {
      const auto found = closing_locks(lock, 1, p, native);
      ASSERT_EQ(found.size(), 3u);
      double nearest = 1e9, farthest = 0;
      for (const double x : found) {
        EXPECT_TRUE(lock_closes(x, 1, p, native));
        nearest = std::min(nearest, std::abs(x - lock));
        farthest = std::max(farthest, std::abs(x - lock));
      }
      for (std::int64_t k = 1; k <= 8 * p; ++k) {
        const double other = static_cast<double>(k) * 180 / static_cast<double>(p);
        if (!lock_closes(other, 1, p, native)) continue;
        EXPECT_GE(std::abs(other - lock), nearest - 1e-9);
        if (std::abs(other - lock) < farthest - 1e-9) {
          EXPECT_TRUE(
              std::any_of(found.begin(), found.end(), [&](double x) { return std::abs(x - other) < 1e-9; }))
              << p << ' ' << other;
        }
      }
    }
  }
}

TEST(WindRules, NativeTextsNameTheCure) {
  const auto text = [](void (*change)(HelicalLayer&)) { return fault_of(changed(change), native); };
  EXPECT_EQ(text([](HelicalLayer& l) { l.angle_deg = 90; }),
            "1: wind angle 90.0° must be between 0° and 90°, from the axis; at 90° use a hoop layer");
  EXPECT_EQ(text([](HelicalLayer& l) { l.pattern = 6, l.skip = 4; }),
            "1: skipIndex 4 and patternNumber 6 have a common divisor, which leaves bare strips; use "
            "skipIndex 1 or 5");
  EXPECT_EQ(text([](HelicalLayer& l) { l.skip = 9; }),
            "1: skipIndex 9 must be less than patternNumber 2; use 1");
  EXPECT_EQ(
      text([](HelicalLayer& l) { l.lock_deg = 190; }),
      "1: lockDegrees 190.0° is not a multiple of 90° (180 / patternNumber), which leaves bare strips; use "
      "180°, 360°, 540°");
  EXPECT_EQ(text([](HelicalLayer& l) { l.pattern = 27, l.lock_deg = 180; }),
            "1: patternNumber 27 is more than the 26 circuits that cover the mandrel; use at most 26");
  EXPECT_EQ(text([](HelicalLayer& l) { l.pattern = 1; }), "");              // one start
  EXPECT_EQ(text([](HelicalLayer& l) { l.pattern = 7, l.skip = 2; }), "");  // 28 circuits
}

}  // namespace
}  // namespace afptraj
