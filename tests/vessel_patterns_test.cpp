#include "winding/vessel_patterns.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "tests/meridians.h"
#include "winding/meridian_geodesic.h"

namespace afptraj {
namespace {

double radians_of(double degrees) { return degrees * std::numbers::pi / 180; }

// Winds by counting: the N starts lie 360 / N apart, and after `starts` circuits one lies beside the first.
TEST(VesselPatterns, EveryFindClosesByCounting) {
  const double R = 150, L = 300;
  const Meridian tank = test::vessel(R, L, R);
  const auto found = find_vessel_patterns(tank, {25, 3, 8, 0.1, 12});
  ASSERT_GT(found.size(), 5u);
  for (const VesselPattern& pattern : found) {
    EXPECT_LE(std::abs(pattern.angle_deg - 25), 3);
    // the turn by the closed form of cylinder and hemispheres
    const double turn = 2 * (180 + L * std::tan(radians_of(pattern.angle_deg)) / R * 180 / std::numbers::pi);
    EXPECT_NEAR(pattern.turn_deg, turn, 1e-6);
    const auto N = static_cast<double>(pattern.circuits);
    const double tows = 2 * std::numbers::pi * R * std::cos(radians_of(pattern.angle_deg)) / 8;
    EXPECT_NEAR(pattern.overlap, N / tows - 1, 1e-12);
    EXPECT_GE(pattern.overlap, 0);
    EXPECT_LE(pattern.overlap, 0.1);
    std::vector<double> places;
    for (std::int64_t i = 0; i < pattern.circuits; ++i)
      places.push_back(std::fmod(static_cast<double>(i) * turn + 1e-3, 360));
    const double beside = std::fmod(static_cast<double>(pattern.starts) * turn + 180, 360) - 180;
    EXPECT_NEAR(beside, (pattern.leading ? 1 : -1) * 360 / N, 1e-5);
    std::sort(places.begin(), places.end());
    for (std::size_t i = 0; i < places.size(); ++i)
      EXPECT_NEAR(places[i], 1e-3 + 360 * static_cast<double>(i) / N, 1e-4);
  }
}

// Completeness on the closed form: the turn grows with the angle, so that each N and stride has one angle at
// most.
TEST(VesselPatterns, NoneIsMissed) {
  const double R = 100, L = 200, w = 12;
  const auto found = find_vessel_patterns(test::vessel(R, L, R), {30, 2, w, 0.15, 1000});
  std::size_t expected = 0;
  for (int N = 2; N < 60; ++N) {
    for (int whole = 1; whole < 4; ++whole) {
      for (int k = 1; k < N; ++k) {
        if (std::gcd(k, N) != 1) continue;
        // 2 (pi + L tan(alpha) / R) = 2 pi (whole + k / N)
        const double tangent = std::numbers::pi * (whole - 1 + double(k) / N) * R / L;
        const double alpha = std::atan(tangent);
        const double alpha_deg = alpha * 180 / std::numbers::pi;
        if (std::abs(alpha_deg - 30) > 2) continue;
        const double over = N / (2 * std::numbers::pi * R * std::cos(alpha) / w) - 1;
        if (over >= 0 && over <= 0.15) ++expected;
      }
    }
  }
  EXPECT_GT(expected, 10u);
  EXPECT_EQ(found.size(), expected);
}

TEST(VesselPatterns, NoOpeningIsSmallerThanTheTow) {
  const Meridian tank = test::vessel(100, 200, 100);
  EXPECT_NEAR(PassMaker(tank, {0, {}, {}, 20}).least_angle_deg(), std::asin(0.1) * 180 / std::numbers::pi,
              1e-12);
  const auto found = find_vessel_patterns(tank, {6, 3, 20, 0.5, 1000});
  ASSERT_FALSE(found.empty());
  for (const VesselPattern& pattern : found) EXPECT_GE(pattern.opening_first_mm, 10 - 1e-9);
  EXPECT_TRUE(find_vessel_patterns(tank, {3, 1, 20, 0.5, 1000}).empty());
}

TEST(VesselPatterns, NothingWhereTheFibreRunsOff) {
  EXPECT_TRUE(find_vessel_patterns(meridian_through({{0, 50}, {300, 50}}), {30, 2, 8, 0.1, 12}).empty());
}

}  // namespace
}  // namespace afptraj
