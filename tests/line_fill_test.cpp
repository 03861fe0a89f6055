#include "fill/line_fill.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "analysis/judge_fill.h"
#include "tests/slices.h"

namespace afptraj {
namespace {

using namespace test;

LineOptions at(double angle_deg, bool zigzag = false, bool outline = false) {
  LineOptions options;
  options.angle_rad = angle_deg * pi / 180;
  options.zigzag = zigzag;
  options.outline = outline;
  return options;
}

double lines_mm(const Fill& fill) {
  double sum = 0;
  for (const FillPath& path : fill.paths) {
    if (path.kind == PathKind::line) sum += length_mm(path.line);
  }
  return sum;
}

// (L1): no point of any path, ends and between, nearer to the boundary than half a width.
void expect_inside(const Slice& slice, const Fill& fill, double first) {
  const auto boundary = boundary_of(slice);
  for (const FillPath& path : fill.paths) {
    const auto& points = path.line.points;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
      const Vec2 d = points[i + 1] - points[i];
      const int parts = 1 + static_cast<int>(d.norm() / 0.8);
      for (int k = 0; k <= parts; ++k) {
        const Vec2 p = points[i] + d * k / parts;
        ASSERT_TRUE(contains(slice, p));
        ASSERT_GT(distance_to(boundary, p), first - 1.1e-3);
      }
    }
  }
}

// Known answers: ten lines of 9 mm with their round ends in a square of 10; in the zigzag nine links of 1 mm.
TEST(LineFill, SquareInClosedForm) {
  const Slice slice = slice_of({rectangle(0, 0, 10, 10)});
  for (const double angle : {0.0, 90.0, 180.0, -90.0}) {
    const Fill raster = line_fill(slice, at(angle)), zigzag = line_fill(slice, at(angle, true));
    ASSERT_EQ(raster.paths.size(), 10u);
    EXPECT_NEAR(lines_mm(raster), 90, 1e-4);
    ASSERT_EQ(zigzag.paths.size(), 1u);
    EXPECT_EQ(zigzag.links.count, 9);
    EXPECT_NEAR(zigzag.links.length_mm, 9, 1e-4);
    EXPECT_NEAR(lines_mm(zigzag), 99, 1e-4);
    // each end leaves two corners of (1 - pi / 4) / 4 bare, nothing is laid twice or outside
    const FillReport report = judge_fill(slice, raster.paths, 1);
    EXPECT_NEAR(report.underfill, 20 * 2 * (1 - pi / 4) / 4 / 100, 1e-6);
    EXPECT_LT(report.outside, 1e-5);
    EXPECT_NEAR(report.overfill, -10 * pi / 4 / 100, 1e-5);  // length x width leaves out the ends
    EXPECT_NEAR(report.overfill_with_ends, 0, 1e-5);
  }
}

// With the outline: a ring of 36 mm and eight lines of 8 mm from 1 to 9; all is covered but for the corners.
TEST(LineFill, OutlinedSquareInClosedForm) {
  const Slice slice = slice_of({rectangle(0, 0, 10, 10)});
  const Fill fill = line_fill(slice, at(0, false, true));
  ASSERT_EQ(fill.paths.size(), 9u);
  EXPECT_EQ(fill.paths[0].kind, PathKind::outline);
  EXPECT_NEAR(length_mm(fill.paths[0].line), 36, 1e-6);
  EXPECT_NEAR(lines_mm(fill), 64, 1e-4);
  EXPECT_NEAR(judge_fill(slice, fill.paths, 1).underfill, (4 - pi) / 4 / 100, 1e-6);
}

// Raster against brute force: on each line the measure of what is half a width deep, by distances to the
// boundary at samples of 0.01 mm, each of which errs by less than 0.01 at each of its ends.
TEST(LineFill, LinesAreAllThatIsDeepEnough) {
  for (unsigned seed = 0; seed < 6; ++seed) {
    const Slice slice = random_slice(seed);
    const double angle = 17.0 * seed;
    const Fill fill = line_fill(slice, at(angle));
    const Vec2 along = Eigen::Rotation2Dd(angle * pi / 180) * Vec2(1, 0), normal = left_of(along);
    std::vector<std::pair<double, double>> rows;  // height, length
    std::vector<int> ends;
    for (const FillPath& path : fill.paths) {
      ASSERT_EQ(path.line.points.size(), 2u);
      const Vec2 a = path.line.points[0], b = path.line.points[1];
      EXPECT_NEAR(normal.dot(b - a), 0, 1e-9);
      EXPECT_GT(along.dot(b - a), 0.04);
      if (rows.empty() || normal.dot(a) > rows.back().first + 1e-6)
        rows.emplace_back(normal.dot(a), 0), ends.push_back(0);
      rows.back().second += (b - a).norm();
      ends.back() += 2;
    }
    const auto boundary = boundary_of(slice);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      if (k + 1 < rows.size()) {
        // evenly spaced; where lines are missing nothing is deep enough
        const double gap = rows[k + 1].first - rows[k].first, step = rows[1].first - rows[0].first;
        EXPECT_LT(step, 1 + 1e-9);
        EXPECT_NEAR(gap, step * std::round(gap / step), 1e-9);
        for (double h = rows[k].first + step; h < rows[k + 1].first - step / 2; h += step) {
          for (double x = -60; x < 100; x += 0.05) {
            const Vec2 p = x * along + h * normal;
            EXPECT_FALSE(contains(slice, p) && distance_to(boundary, p) > 0.51);
          }
        }
      }
      if (k % 4 != seed % 4) continue;
      int deep = 0;
      for (double x = -60; x < 100; x += 0.01) {
        const Vec2 p = x * along + rows[k].first * normal;
        deep += contains(slice, p) && distance_to(boundary, p) >= 0.5;
      }
      // stretches below 0.05 mm are left out
      EXPECT_NEAR(rows[k].second, deep * 0.01, 0.01 * ends[k] + 0.05);
    }
  }
}

TEST(LineFill, LawsOverRandomSlices) {
  int paths = 0, links = 0;
  for (unsigned seed = 0; seed < 16; ++seed) {
    SCOPED_TRACE(seed);
    const Slice slice = random_slice(seed);
    const double angle = 360 * std::fmod(seed * 0.618, 1.0);
    for (const bool outline : {false, true}) {
      const Fill raster = line_fill(slice, at(angle, false, outline)),
                 zigzag = line_fill(slice, at(angle, true, outline));
      EXPECT_EQ(crossings(raster.paths), 0);
      EXPECT_EQ(crossings(zigzag.paths), 0);
      expect_inside(slice, zigzag, 0.5);
      // (L3): the same lines, each once, and links
      EXPECT_EQ(raster.links.count, 0);
      EXPECT_NEAR(lines_mm(zigzag) - zigzag.links.length_mm, lines_mm(raster), 1e-6);
      EXPECT_LE(zigzag.links.longest_mm, 10);
      const auto count = [](const Fill& fill) {
        return std::count_if(fill.paths.begin(), fill.paths.end(),
                             [](const FillPath& p) { return p.kind == PathKind::line; });
      };
      EXPECT_EQ(count(zigzag) + zigzag.links.count, count(raster));
      paths += static_cast<int>(count(zigzag));
      links += zigzag.links.count;
      if (outline != (seed % 4 > 0)) continue;  // the judge takes its time
      const FillReport report = judge_fill(slice, zigzag.paths, 1);
      EXPECT_LT(report.outside, 2e-4);
      if (!outline) continue;
      EXPECT_LT(report.underfill - report.unreachable, 0.002);
    }
  }
  EXPECT_GT(links, 6 * paths);  // most lines are joined
}

// A turn of slice and lines changes nothing.
TEST(LineFill, RigidMotion) {
  const std::vector<Vec2> outline = flower(0.15, 300);
  std::vector<Vec2> turned;
  for (const Vec2& p : outline) turned.push_back(Eigen::Rotation2Dd(0.7) * p + Vec2(100, -40));
  LineOptions options = at(20, true);
  const Fill one = line_fill(slice_of({outline}), options);
  options.angle_rad += 0.7;
  const Fill other = line_fill(slice_of({turned}), options);
  EXPECT_EQ(one.paths.size(), other.paths.size());
  EXPECT_NEAR(lines_mm(one), lines_mm(other), 1e-2);
}

// A bound on links takes links away, not lines.
TEST(LineFill, LongLinksAreNotLaid) {
  const Slice slice = slice_of({{{0, 0}, {40, 0}, {30, 4}, {0, 4}}});
  LineOptions options = at(0, true);
  const Fill all = line_fill(slice, options);
  EXPECT_EQ(all.paths.size(), 1u);
  EXPECT_GT(all.links.longest_mm, 2);  // along the slope: 1 / sin(atan(0.4))
  options.most_link_mm = 2;
  const Fill some = line_fill(slice, options);
  EXPECT_LE(some.links.longest_mm, 2);
  EXPECT_GT(some.paths.size(), 1u);
  EXPECT_NEAR(lines_mm(some) - some.links.length_mm, lines_mm(all) - all.links.length_mm, 1e-6);
}

// The figures asked for the flower: with the outline at most 0.2 % bare, nothing outside.
TEST(LineFill, Flower) {
  const Slice slice = slice_of({flower(0.15, 500)});
  for (const bool zigzag : {false, true}) {
    const FillReport report =
        judge_fill(slice, line_fill(slice, at(zigzag ? 60 : -60, zigzag, true)).paths, 1);
    EXPECT_LT(report.underfill, 0.002);
    EXPECT_LT(report.outside, 2e-4);
  }
}

// Strips: one bead wide, and narrower.
TEST(LineFill, Strips) {
  const Fill one = line_fill(slice_of({rectangle(0, 0, 40, 1)}), at(0));
  ASSERT_EQ(one.paths.size(), 1u);
  EXPECT_NEAR(lines_mm(one), 39, 1e-4);
  EXPECT_TRUE(line_fill(slice_of({rectangle(0, 0, 40, 0.9)}), at(0)).paths.empty());
}

}  // namespace
}  // namespace afptraj
