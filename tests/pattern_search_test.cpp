#include "winding/pattern_search.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <numbers>

#include "tests/winding_text.h"
#include "winding/layer_rules.h"
#include "winding/pattern.h"

namespace afptraj {
namespace {

HelicalLayer layer_of(const FoundPattern& found) {
  HelicalLayer layer = test::sound_helical();
  layer.angle_deg = found.angle_deg;
  layer.pattern = found.pattern;
  layer.skip = found.skip;
  layer.lock_deg = found.lock_deg;
  return layer;
}

// What is offered can be planned as it stands, and is what it says.
TEST(PatternSearch, EveryFindHolds) {
  WindDefinition definition = test::definition_of({});
  for (const double end : {70.0, 50.0}) {
    definition.mandrel.end_diameter_mm = end;
    for (const double angle : {8.0, 30.0, 44.0, 54.7, 85.0}) {
      if (angle - 2 > steepest_angle_deg(definition.mandrel)) continue;
      const auto found = find_patterns(definition.mandrel, definition.tow, {angle, 2});
      ASSERT_FALSE(found.empty()) << angle;
      for (const FoundPattern& pattern : found) {
        const HelicalLayer layer = layer_of(pattern);
        definition.layers = {layer};
        const auto fault = first_fault(definition, WindMode::native);
        ASSERT_FALSE(fault) << fault->message;
        EXPECT_EQ(circuits(definition.mandrel, definition.tow, layer, WindMode::native), pattern.circuits);
        EXPECT_EQ(pattern.fiberpath, !first_fault(definition, WindMode::fiberpath).has_value());
        EXPECT_LE(std::abs(pattern.angle_deg - angle), 2 + 1e-9);
        EXPECT_GE(pattern.overlap, 0);
        // Only the asked angle itself may overlap; the others just touch.
        EXPECT_TRUE(pattern.overlap < 1e-3 || pattern.angle_deg == angle);
      }
      for (std::size_t i = 1; i < found.size(); ++i) {
        EXPECT_GE(std::abs(found[i].angle_deg - angle), std::abs(found[i - 1].angle_deg - angle));
      }
    }
  }
}

// FiberPath's "26 % 7 != 0": within a degree and a half there is an angle that seven starts divide.
TEST(PatternSearch, FindsTheAngleThatFits) {
  const WindDefinition definition = test::definition_of({});
  bool seven = false;
  for (const FoundPattern& found : find_patterns(definition.mandrel, definition.tow, {28, 2}))
    seven = seven || (found.fiberpath && found.pattern == 7 && found.circuits == 28);
  EXPECT_TRUE(seven);
}

// A pass there and a pass back cross wherever together they have turned once more: counted on one pair.
TEST(PatternSearch, CrossingsByCounting) {
  const WindMandrel mandrel{70, 100, {}};
  const auto found = find_patterns(mandrel, {7, 0.5}, {60, 0});
  const double turns = 100 * std::tan(std::numbers::pi / 3) / (std::numbers::pi * 70);
  const double N = static_cast<double>(found.front().circuits);
  EXPECT_NEAR(static_cast<double>(found.front().crossings), N * N * 2 * turns, 1);
}

TEST(PatternSearch, NothingBeyondTheSteepest) {
  EXPECT_TRUE(find_patterns({98, 120, 54}, {7, 0.5}, {40, 2}).empty());
  EXPECT_NEAR(steepest_angle_deg({98, 120, 54}), std::asin(27 / 49.0) * 180 / std::numbers::pi, 1e-12);
  for (const FoundPattern& found : find_patterns({98, 120, 54}, {7, 0.5}, {34, 2}))
    EXPECT_LE(found.angle_deg, steepest_angle_deg({98, 120, 54}));
}

}  // namespace
}  // namespace afptraj
