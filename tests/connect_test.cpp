#include "fill/connect.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "analysis/judge_fill.h"
#include "fill/contour_parallel.h"
#include "tests/slices.h"

namespace afptraj {
namespace {

using namespace test;

constexpr Connection both[] = {Connection::nested, Connection::spiral};

double total_mm(const Fill& fill) {
  double sum = 0;
  for (const FillPath& path : fill.paths) sum += length_mm(path.line);
  return sum;
}

Fill rings_only(const Slice& slice) {
  ContourOptions options;
  options.least_void_share = 1e9;
  Fill fill = contour_parallel(slice, options);
  std::erase_if(fill.paths, [](const FillPath& path) { return path.kind != PathKind::ring; });
  return fill;
}

// The parts of the slice that the centre line of a bead can reach from one to the other.
long parts(const Slice& slice) {
  const auto rings = offset_rings(slice, 0.5, 1e-6);
  return std::count_if(rings.begin(), rings.end(), [](const ArcRing& ring) { return signed_area(ring) > 0; });
}

// Length of `lines` that is not on `others`, by samples of at most `step`.
double off_mm(const std::vector<Polyline>& lines, const std::vector<Polyline>& others, double step) {
  std::map<std::pair<int, int>, std::vector<Polyline>> cells;  // of 1 mm, of what passes their box
  const auto cell = [](double x) { return static_cast<int>(std::floor(x)); };
  const auto pieces = [](const Polyline& line, const auto& visit) {
    const std::size_t n = line.points.size();
    for (std::size_t i = 0; i + (line.closed ? 0 : 1) < n; ++i)
      visit(line.points[i], line.points[(i + 1) % n]);
  };
  for (const Polyline& line : others) {
    pieces(line, [&](const Vec2& a, const Vec2& b) {
      const Vec2 lo = a.cwiseMin(b) - Vec2::Constant(1e-6), hi = a.cwiseMax(b) + Vec2::Constant(1e-6);
      for (int x = cell(lo.x()); x <= cell(hi.x()); ++x) {
        for (int y = cell(lo.y()); y <= cell(hi.y()); ++y) cells[{x, y}].push_back({{a, b}, false});
      }
    });
  }
  double sum = 0;
  for (const Polyline& line : lines) {
    pieces(line, [&](const Vec2& a, const Vec2& b) {
      const int count = 1 + static_cast<int>((b - a).norm() / step);
      for (int k = 0; k < count; ++k) {
        const Vec2 p = a + (b - a) * (k + 0.5) / count;
        const auto near = cells.find({cell(p.x()), cell(p.y())});
        if (near == cells.end() || distance_to(near->second, p) > 1e-6) sum += (b - a).norm() / count;
      }
    });
  }
  return sum;
}

// (C1) to (C3), on rings alone.
void expect_laws(const Slice& slice, Connection connection) {
  const Fill rings = rings_only(slice), joined = connected(rings, slice, 1, connection);
  EXPECT_EQ(static_cast<long>(joined.paths.size()), parts(slice));
  EXPECT_EQ(crossings(joined.paths), 0);
  // slanting links: 2 (1 + 2^2)^(1/2) = 4.5 where rings are straight, a half more where they spread
  EXPECT_LT(joined.links.longest_mm, connection == Connection::spiral ? 6.6 : 2.5);
  for (const FillPath& path : joined.paths) {
    for (std::size_t i = 0; i + 1 < path.line.points.size(); ++i)
      EXPECT_TRUE(contains(slice, (path.line.points[i] + path.line.points[i + 1]) / 2));
  }
  const double gaps = off_mm(lines_of(rings.paths), lines_of(joined.paths), 0.02);
  EXPECT_NEAR(total_mm(joined), total_mm(rings) - gaps + joined.links.length_mm,
              0.04 * (1 + joined.links.count));
  // what is not on a ring is a link
  EXPECT_LT(off_mm(lines_of(joined.paths), lines_of(rings.paths), 0.05), joined.links.length_mm + 1e-6);
}

TEST(Connect, LawsOnNamedSlices) {
  for (const Connection connection : both) {
    SCOPED_TRACE(static_cast<int>(connection));
    expect_laws(slice_of({circle(10, 90)}), connection);
    expect_laws(slice_of({rectangle(0, 0, 20, 14)}), connection);
    expect_laws(slice_of({l_shape()}), connection);
    expect_laws(slice_of({star()}), connection);
    expect_laws(slice_of({dumb_bell(3)}), connection);
    expect_laws(slice_of({flower(0.15, 300)}), connection);
    expect_laws(slice_of({circle(12, 80), circle(2.5, 30, {-5, 0}), circle(2.5, 30, {5, 1})}), connection);
    expect_laws(slice_of({circle(15, 90), circle(9, 60), circle(5, 50)}), connection);
    expect_laws(slice_of({circle(10, 90), circle(3, 40)}), connection);
  }
}

TEST(Connect, LawsOverRandomSlices) {
  for (unsigned seed = 0; seed < 8; ++seed) {
    SCOPED_TRACE(seed);
    for (const Connection connection : both) expect_laws(random_slice(seed), connection);
  }
}

// With the paths in what rings leave bare: one path still, which stays in the slice, and little more is bare.
TEST(Connect, CoversWhatItJoins) {
  for (const auto& outline : {flower(0.15, 300), l_shape(), star(), dumb_bell(3)}) {
    const Slice slice = slice_of({outline});
    ContourOptions options;
    options.least_void_share = 0.28;
    const Fill rings = contour_parallel(slice, options);
    const FillReport before = judge_fill(slice, rings.paths, 1);
    for (const Connection connection : both) {
      const Fill joined = connected(rings, slice, 1, connection);
      const FillReport report = judge_fill(slice, joined.paths, 1);
      EXPECT_EQ(report.paths, 1);
      EXPECT_EQ(crossings(joined.paths), 0);
      EXPECT_LT(report.outside, 2e-4);
      EXPECT_LT(report.underfill, before.underfill + 0.018);
    }
  }
}

// On a disc the nested links turn sharply at all their ends, those of a spiral only where it turns back.
TEST(Connect, SpiralsTurnSharplyLessOften) {
  const Slice slice = slice_of({circle(15, 200)});
  const Fill rings = rings_only(slice);
  const auto sharp = [&](Connection connection) {
    return judge_fill(slice, connected(rings, slice, 1, connection).paths, 1).sharp_corners;
  };
  EXPECT_GE(sharp(Connection::nested), 3 * 13);
  EXPECT_LE(sharp(Connection::spiral), 16);
}

// Two discs a tenth of a width apart, an island as near to its hole: no link leads over the gap.
TEST(Connect, NoLinkLeavesTheSlice) {
  const Slice discs = slice_of({circle(6, 60), circle(6, 60, {12.1, 0})}),
              island = slice_of({circle(12, 90), circle(5, 60), circle(4.8, 60)});
  for (const Connection connection : both) {
    expect_laws(discs, connection);
    expect_laws(island, connection);
    EXPECT_EQ(connected(rings_only(discs), discs, 1, connection).paths.size(), 2u);
    EXPECT_EQ(connected(rings_only(island), island, 1, connection).paths.size(), 2u);
  }
}

// Known answer: two squares inside each other, 40 and 32 mm round, two links of 1 mm, two gaps of 1 mm.
TEST(Connect, TwoSquaresInClosedForm) {
  Fill fill;
  fill.paths.push_back({{rectangle(0, 0, 10, 10), true}, PathKind::ring, 0});
  fill.paths.push_back({{rectangle(1, 1, 9, 9), true}, PathKind::ring, 1});
  const Fill joined = connected(fill, slice_of({rectangle(-1, -1, 11, 11)}), 1, Connection::nested);
  ASSERT_EQ(joined.paths.size(), 1u);
  EXPECT_TRUE(joined.paths[0].line.closed);
  EXPECT_NEAR(total_mm(joined), 40 + 32 - 2 + 2, 1e-9);
  EXPECT_EQ(joined.links.count, 2);
  EXPECT_NEAR(joined.links.length_mm, 2, 1e-9);
}

// Known answer: an open path beside a ring is run there and back.
TEST(Connect, SpurInClosedForm) {
  Fill fill;
  fill.paths.push_back({{rectangle(0, 0, 10, 10), true}, PathKind::ring, 0});
  fill.paths.push_back({{{{1, 5}, {3, 5}, {3, 6}}, false}, PathKind::centre, 0});
  fill.paths.push_back({{{{30, 5}, {31, 5}}, false}, PathKind::centre, 0});  // too far from all
  for (const Connection connection : both) {
    const Fill joined = connected(fill, slice_of({rectangle(-1, -1, 40, 11)}), 1, connection);
    ASSERT_EQ(joined.paths.size(), 2u);
    EXPECT_NEAR(length_mm(joined.paths[0].line), 40 + 2 * (1 + 3), 1e-9);
    EXPECT_NEAR(length_mm(joined.paths[1].line), 1, 1e-9);
  }
}

}  // namespace
}  // namespace afptraj
