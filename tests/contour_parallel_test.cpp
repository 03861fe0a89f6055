#include "fill/contour_parallel.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "analysis/judge_fill.h"
#include "tests/slices.h"

namespace afptraj {
namespace {

using namespace test;

long rings_of(const Fill& fill) {
  return std::count_if(fill.paths.begin(), fill.paths.end(),
                       [](const FillPath& path) { return path.kind == PathKind::ring; });
}

// Laws of every contour-parallel fill: paths inside, none outside, what can be covered is.
FillReport judged(const Slice& slice, double most_underfill) {
  const Fill fill = contour_parallel(slice, {});
  const FillReport report = judge_fill(slice, fill.paths, 1);
  EXPECT_EQ(crossings(fill.paths), 0);
  EXPECT_LT(report.outside, 2e-4);  // chords outside of hole arcs by up to the tolerance
  EXPECT_LT(report.underfill - report.unreachable, most_underfill);
  const auto boundary = boundary_of(slice);
  for (const FillPath& path : fill.paths) {
    for (const Vec2& p : path.line.points) {
      EXPECT_TRUE(contains(slice, p));
      EXPECT_GT(distance_to(boundary, p), 0.5 - 1e-3);
    }
  }
  return report;
}

// The figures asked for: 13 rings, underfill <= 0.3 %, overfill <= 0.5 %.
TEST(ContourParallel, Flower) {
  const Slice slice = slice_of({flower(0.15, 500)});
  const Fill fill = contour_parallel(slice, {});
  EXPECT_EQ(rings_of(fill), 13);
  const FillReport report = judge_fill(slice, fill.paths, 1);
  EXPECT_LT(report.underfill, 0.003);
  EXPECT_LT(report.overfill, 0.005);
  EXPECT_LT(report.outside, 1e-5);
}

// With sharp corners each ring is the level curve: lengths are those of the exact offset.
TEST(ContourParallel, SharpRingsAreLevelCurves) {
  const Slice slice = slice_of({rectangle(0, 0, 10, 7)});
  ContourOptions options;
  options.corner_mm = 0;
  const Fill fill = contour_parallel(slice, options);
  ASSERT_GE(fill.paths.size(), 3u);
  for (int k = 0; k < 3; ++k) {
    const double d = 0.5 + k;
    EXPECT_NEAR(length_mm(fill.paths[static_cast<std::size_t>(k)].line), 2 * (17 - 4 * d), 1e-9);
  }
}

// A corner of 90 degrees rounded to the radius r is shorter by (2 - pi / 2) r.
TEST(ContourParallel, RoundedCornersInClosedForm) {
  const Slice slice = slice_of({rectangle(0, 0, 20, 20)});
  const Fill fill = contour_parallel(slice, {1, 0.5, 1e-7, 0.25, 0.05});
  const double sharp = 4 * (20 - 2 * 1.5);
  EXPECT_NEAR(length_mm(fill.paths[0].line), 4 * 19, 1e-9);  // the outermost stays sharp
  EXPECT_NEAR(length_mm(fill.paths[1].line), sharp - 4 * (2 - pi / 2) * 0.25, 1e-5);
}

TEST(ContourParallel, RingsGrowRoundHoles) {
  for (const double hole : {2.0, 2.4, 2.8, 3.0, 0.1, 7.9})
    judged(slice_of({circle(10, 90), circle(hole, 40)}), 0.005);
  const Fill fill = contour_parallel(slice_of({circle(10, 90), circle(3, 40)}), {});
  EXPECT_EQ(std::count_if(
                fill.paths.begin(), fill.paths.end(),
                [](const FillPath& path) { return path.level == 0 && signed_area(path.line.points) < 0; }),
            1);  // the hole's own ring, clockwise: material on the left
}

TEST(ContourParallel, ShapesThatAreHard) {
  judged(slice_of({circle(12, 80), circle(2.5, 30, {-5, 0}), circle(2.5, 30, {5, 1})}), 0.005);
  judged(slice_of({dumb_bell(3)}), 0.005);
  judged(slice_of({star()}), 0.005);
  judged(slice_of({l_shape()}), 0.005);
  judged(slice_of({circle(15, 90), circle(9, 60), circle(5, 50)}), 0.005);
  judged(slice_of({rectangle(0, 0, 10, 10), rectangle(10, 10, 20, 20)}), 0.005);
}

// The edge that two rings share is none: the fill is that of their union.
TEST(ContourParallel, SharedEdgesVanish) {
  const Slice two = slice_of({rectangle(0, 0, 10, 10), rectangle(10, 0, 15, 10)}),
              one = slice_of({rectangle(0, 0, 15, 10)});
  const FillReport a = judge_fill(two, contour_parallel(two, {}).paths, 1),
                   b = judge_fill(one, contour_parallel(one, {}).paths, 1);
  EXPECT_NEAR(a.length_mm, b.length_mm, 1e-6);
  EXPECT_NEAR(a.underfill, b.underfill, 1e-8);
}

// A neck narrower than a bead stays bare, and the report says how much no bead reaches.
TEST(ContourParallel, NarrowNeckIsNamed) {
  const FillReport report = judged(slice_of({dumb_bell(0.6)}), 0.005);
  EXPECT_GT(report.unreachable, 0.01);
}

TEST(ContourParallel, Strips) {
  for (const double width : {1.0, 1.2, 2.0, 2.5, 3.0, 3.7})
    judged(slice_of({rectangle(0, 0, 40, width)}), 0.005);
  // exactly one bead wide: one line along the middle, not a ring of no width
  const Fill one = contour_parallel(slice_of({rectangle(0, 0, 40, 1)}), {});
  ASSERT_EQ(one.paths.size(), 1u);
  EXPECT_NEAR(length_mm(one.paths[0].line), 39, 1e-6);
  EXPECT_TRUE(contour_parallel(slice_of({rectangle(0, 0, 40, 0.8)}), {}).paths.empty());
}

// The sense of the input means nothing, and the same input gives the same paths.
TEST(ContourParallel, SenseMeansNothing) {
  const Slice one = slice_of({l_shape()}), other = slice_of({reverse(l_shape())});
  const FillReport a = judge_fill(one, contour_parallel(one, {}).paths, 1),
                   b = judge_fill(other, contour_parallel(other, {}).paths, 1);
  EXPECT_NEAR(a.length_mm, b.length_mm, 1e-6);
  EXPECT_NEAR(a.underfill, b.underfill, 1e-8);
  const Fill first = contour_parallel(one, {}), again = contour_parallel(one, {});
  ASSERT_EQ(first.paths.size(), again.paths.size());
  for (std::size_t i = 0; i < first.paths.size(); ++i)
    EXPECT_EQ(first.paths[i].line.points, again.paths[i].line.points);
}

}  // namespace
}  // namespace afptraj
