#include "analysis/judge_fill.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "analysis/region_areas.h"
#include "tests/slices.h"

namespace afptraj {
namespace {

using namespace test;

const std::filesystem::path cases = std::filesystem::path(AFPTRAJ_SHARED_DIR) / "reference/fill_cases";

ArcRing full_circle(const Vec2& centre, double r) {
  return {{{centre + Vec2(r, 0), centre, 1}, {centre - Vec2(r, 0), centre, 1}}};
}

TEST(RegionAreas, CirclesInClosedForm) {
  // two circles of radius 1 at distance 1 share a lens of 2 pi / 3 - sqrt(3) / 2
  const RegionAreas areas = region_areas({full_circle({0, 0}, 1)}, {full_circle({1, 0}, 1)});
  const double lens = 2 * pi / 3 - std::sqrt(3.0) / 2;
  EXPECT_NEAR(areas.both, lens, 1e-8);  // 1e-9 along boundaries of 4 pi
  EXPECT_NEAR(areas.only_first, pi - lens, 1e-8);
  EXPECT_NEAR(areas.only_second, pi - lens, 1e-8);
}

TEST(RegionAreas, BoundariesThatLieOnEachOther) {
  const RegionAreas same = region_areas({full_circle({0, 0}, 1)}, {full_circle({0, 1e-13}, 1)});
  EXPECT_NEAR(same.both, pi, 1e-8);
  EXPECT_NEAR(same.only_first + same.only_second, 0, 1e-8);
}

std::vector<FillPath> as_fill(const std::vector<Polyline>& lines) {
  std::vector<FillPath> out;
  for (const Polyline& line : lines) out.push_back({line, PathKind::ring, 0});
  return out;
}

TEST(JudgeFill, OneBeadInClosedForm) {
  const FillReport report =
      judge_fill(slice_of({rectangle(0, 0, 10, 4)}), as_fill({{{{1, 2}, {9, 2}}, false}}), 1);
  EXPECT_NEAR(report.covered_mm2, 8 + pi / 4, 1e-7);
  EXPECT_NEAR(report.underfill, 1 - (8 + pi / 4) / 40, 1e-8);
  EXPECT_NEAR(report.outside, 0, 1e-9);
  EXPECT_NEAR(report.overfill, -(pi / 4) / 40, 1e-8);        // its two round ends
  EXPECT_NEAR(report.unreachable, (1 - pi / 4) / 40, 1e-5);  // the tips of four corners
}

// A grid of points, each asked for its distance to all paths: knows nothing of diagrams or arcs.
TEST(JudgeFill, RasterCheck) {
  const Slice slice = slice_of({flower(0.15, 200)});
  std::vector<Polyline> lines;
  for (const double scale : {0.95, 0.85, 0.74, 0.5, 0.2}) {
    Polyline line{flower(0.15, 200), true};
    for (Vec2& p : line.points) p *= scale;
    lines.push_back(line);
  }
  const FillReport report = judge_fill(slice, as_fill(lines), 1);
  constexpr double step = 0.1;
  long inside = 0, bare = 0, outside = 0;
  for (double x = -18; x < 18; x += step) {
    for (double y = -18; y < 18; y += step) {
      const bool in = contains(slice, {x, y}), filled = distance_to(lines, {x, y}) <= 0.5;
      inside += in;
      bare += in && !filled;
      outside += !in && filled;
    }
  }
  // boundaries of some 700 mm pass through 7000 cells, each off by at most 0.5 of one of 71 000, as a random
  // walk
  const double tolerance = 3 * 0.5 * std::sqrt(7000.0) / 71000;
  EXPECT_NEAR(report.underfill, static_cast<double>(bare) / static_cast<double>(inside), tolerance);
  EXPECT_NEAR(report.outside, static_cast<double>(outside) / static_cast<double>(inside), tolerance);
}

// What others measured of NEPath's own paths.
TEST(JudgeFill, KnownFiguresOfNepath) {
  if (!std::filesystem::exists(cases)) GTEST_SKIP() << "no fill cases here";
  const auto outline = read_paths(cases / "contour_flower_r15_a0.15_k10_n1000.csv", true);
  const Slice slice = slice_of({outline.at(0).points});
  const FillReport rings = judge_fill(slice, as_fill(read_paths(cases / "cp_a0.15.csv", true)), 1);
  EXPECT_NEAR(100 * rings.underfill, 1.2511, 0.0005);
  EXPECT_EQ(rings.sharp_corners, 44);
  EXPECT_EQ(rings.paths, 13);
  EXPECT_NEAR(rings.length_mm, 711.482, 0.001);
  const FillReport raster = judge_fill(slice, as_fill(read_paths(cases / "raster_a0.15.csv", false)), 1);
  EXPECT_NEAR(100 * raster.underfill, 0.353, 0.001);
  EXPECT_NEAR(100 * raster.outside, 5.68, 0.005);
  const FillReport zigzag = judge_fill(slice, as_fill(read_paths(cases / "zigzag_a0.15.csv", false)), 1);
  EXPECT_NEAR(100 * zigzag.underfill, 0.152, 0.0005);
  EXPECT_NEAR(100 * zigzag.outside, 7.67, 0.01);
}

TEST(SharpCorners, AreaInvariantOfACorner) {
  for (const double phi : {0.3, 1.0, 1.8, 2.5, pi}) {
    const Polyline corner{{{5, 0}, {0, 0}, {5 * std::cos(phi), 5 * std::sin(phi)}}, false};
    EXPECT_NEAR(area_invariants(corner, 1)[1], 1 - phi / (2 * pi), 1e-12);
  }
}

// On a circle of radius r the disc of radius R is cut into a lens and the rest.
TEST(SharpCorners, AreaInvariantOfACircle) {
  const double r = 3, R = 1;
  const double lens = R * R * std::acos(R / (2 * r)) + r * r * std::acos(1 - R * R / (2 * r * r)) -
                      R / 2 * std::sqrt(4 * r * r - R * R);
  const auto shares = area_invariants({circle(r, 20000), true}, R);
  for (std::size_t i = 0; i < shares.size(); i += 999)
    EXPECT_NEAR(shares[i], 1 - lens / (pi * R * R),
                1e-6);  // sagitta 4e-9 along the arc; sums of 20 000 terms
  EXPECT_LT(area_invariants({circle(0.4, 100), true}, R)[0], 0);  // never leaves the disc
}

TEST(SharpCorners, Counts) {
  EXPECT_EQ(sharp_corners({star(), true}).size(), 5u + 0u);  // the tips; the notches are blunt
  EXPECT_EQ(sharp_corners({rectangle(0, 0, 10, 10), true}).size(), 4u);
  EXPECT_EQ(sharp_corners({rectangle(0, 0, 10, 10), false}).size(), 2u);  // its ends are none
  EXPECT_EQ(sharp_corners({circle(5, 100), true}).size(), 0u);
}

}  // namespace
}  // namespace afptraj
