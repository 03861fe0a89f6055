// The band on the mandrel, where its area is known.
#include "winding/laid_band.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace afptraj {
namespace {

constexpr double D = 70, L = 100, w = 7;
constexpr double degrees_per_mm = 360 / (std::numbers::pi * D);

// Turn of the mandrel over `way` along the axis at a winding angle.
double turn(double angle_deg, double way) {
  return way * std::tan(angle_deg * std::numbers::pi / 180) * degrees_per_mm;
}

// A pass that begins and ends beyond the mandrel, so that its square ends do not show.
void pass(LaidBand& band, double angle_deg, double start_deg) {
  const double from = -200, to = 300;
  for (double z = from; z < to; z += 10) {
    band.lay(z, start_deg + turn(angle_deg, z), z + 10, start_deg + turn(angle_deg, z + 10));
  }
}

// A circle is cut over w / cos(alpha), whatever its place.
TEST(LaidBand, OneBandCoversItsWidth) {
  for (const double angle : {0.0, 5.0, 35.0, 60.0, 80.0}) {
    LaidBand band({D, L, {}}, w, 64);
    pass(band, angle, 17);
    const double arc = w / std::cos(angle * std::numbers::pi / 180);
    const BandCoverage coverage = band.coverage();
    EXPECT_NEAR(coverage.covered_share, arc / (std::numbers::pi * D), 1e-12);
    EXPECT_NEAR(coverage.widest_gap_mm, std::numbers::pi * D - arc, 1e-9);
    EXPECT_NEAR(coverage.overlap_share, 0, 1e-12);
  }
}

TEST(LaidBand, GapsAndOverlapsOfTwoBands) {
  const double angle = 30, arc_deg = w / std::cos(angle * std::numbers::pi / 180) * degrees_per_mm;
  LaidBand apart({D, L, {}}, w, 64);
  pass(apart, angle, 0);
  pass(apart, angle, arc_deg + 1);
  EXPECT_NEAR(apart.coverage().covered_share, 2 * arc_deg / 360, 1e-12);
  LaidBand over({D, L, {}}, w, 64);
  pass(over, angle, 0);
  pass(over, angle, arc_deg - 1);
  EXPECT_NEAR(over.coverage().covered_share, (2 * arc_deg - 1) / 360, 1e-12);
  EXPECT_NEAR(over.coverage().overlap_share, 1 / (2 * arc_deg - 1), 1e-12);
}

TEST(LaidBand, BandsSideBySideLeaveNothing) {
  const int N = 20;  // bands of exactly 1/N of the circle
  const double angle = std::acos(N * w / (std::numbers::pi * D)) * 180 / std::numbers::pi;
  LaidBand band({D, L, {}}, w + 1e-9, 64);
  for (int i = 0; i < N; ++i) pass(band, angle, 360.0 * (i * 7 % N) / N);
  EXPECT_EQ(band.coverage().widest_gap_mm, 0);
  EXPECT_NEAR(band.coverage().covered_share, 1, 1e-12);
  EXPECT_NEAR(band.coverage().overlap_share, 0, 1e-9);
}

TEST(LaidBand, ABareMandrelIsAllGap) {
  const BandCoverage coverage = LaidBand({D, L, {}}, w, 64).coverage();
  EXPECT_EQ(coverage.covered_share, 0);
  EXPECT_NEAR(coverage.widest_gap_mm, std::numbers::pi * D, 1e-9);
}

// Along the lines of a cone a band is w wide on every circle.
TEST(LaidBand, AxialBandOnACone) {
  const double end = 50;
  LaidBand band({D, L, end}, w, 200);
  for (double z = -20; z < 120; z += 0.5) band.lay(z, 5, z + 0.5, 5);
  // mean of w / (2 pi r) weighted by r
  EXPECT_NEAR(band.coverage().covered_share, w / (std::numbers::pi * (D + end) / 2), 1e-4);
}

}  // namespace
}  // namespace afptraj
