#include "fill/slice.h"

#include <gtest/gtest.h>

#include <limits>

#include "geometry/error.h"
#include "io/slice_csv.h"
#include "tests/slices.h"
#include "tests/temporary_directory.h"

namespace afptraj {
namespace {

using namespace test;

TEST(Slice, WorksOutSenseAndNesting) {
  // outline, hole, island, hole in the island, and a second outline; the sense given means nothing
  const std::vector<std::vector<Vec2>> rings{circle(10, 64), circle(8, 64), circle(6, 64), circle(4, 64),
                                             rectangle(20, 0, 25, 5)};
  const Slice plain = slice_of(rings);
  std::vector<std::vector<Vec2>> turned;
  for (const auto& ring : rings) turned.push_back(reverse(ring));
  const Slice other = slice_of(turned);
  const int depths[] = {0, 1, 2, 3, 0};
  double area = 0;
  for (std::size_t i = 0; i < rings.size(); ++i) {
    EXPECT_EQ(plain.rings()[i].depth, depths[i]);
    EXPECT_EQ(other.rings()[i].depth, depths[i]);
    EXPECT_EQ(signed_area(plain.rings()[i].points) > 0, depths[i] % 2 == 0);
    EXPECT_EQ(signed_area(other.rings()[i].points) > 0, depths[i] % 2 == 0);
    area += (depths[i] % 2 == 0 ? 1 : -1) * std::abs(signed_area(rings[i]));
  }
  EXPECT_NEAR(plain.area_mm2(), area, 1e-11);  // sums of some hundred products of 1e2
  EXPECT_TRUE(contains(plain, {9, 0}));
  EXPECT_FALSE(contains(plain, {7, 0}));
  EXPECT_TRUE(contains(plain, {5, 0}));
}

TEST(Slice, RingsMayTouch) {
  // at a corner, along an edge, with a corner on an edge; a hole that touches its outline
  EXPECT_NEAR(
      slice_of({rectangle(0, 0, 10, 10), rectangle(10, 10, 20, 20), rectangle(20, 10, 30, 20)}).area_mm2(),
      300, 1e-10);
  EXPECT_NEAR(slice_of({rectangle(0, 0, 10, 10), {{0, 3}, {4, 2}, {4, 8}}}).area_mm2(), 100 - 12, 1e-10);
  // a corner on a slanted edge, where no lattice meets it exactly
  EXPECT_NO_THROW(slice_of({{{0, 0}, {10, 1.0 / 3}, {10, 10}, {0, 10}}, {{5, 1.0 / 6}, {7, 5}, {4, 5}}}));
}

std::string refusal(const std::vector<InputRing>& rings) {
  try {
    Slice("s.csv", rings);
    return "(made)";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::bad_input);
    return e.where() + ": " + e.what();
  }
}

TEST(Slice, RefusesWithThePlace) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto has = [](const std::string& text, const std::string& words) {
    EXPECT_NE(text.find(words), std::string::npos) << text;
  };
  has(refusal({}), "holds no ring");
  has(refusal({{"a", {{0, 0}, {1, 0}}, {2, 3}}}), "s.csv:2: ring 'a' has fewer than three different points");
  has(refusal({{"a", {{0, 0}, {1, 0}, {1, 0}, {0, 0}}, {2, 3, 4, 5}}}), "fewer than three different points");
  has(refusal({{"a", {{0, 0}, {1, nan}, {1, 1}}, {2, 3, 4}}}),
      "s.csv:3: a coordinate is not a finite number");
  has(refusal({{"a", {{0, 0}, {1e7, 0}, {1, 1}}, {2, 3, 4}}}), "s.csv:3: a coordinate is beyond");
  has(refusal({{"a", {{0, 0}, {10, 10}, {10, 0}, {0, 10}}, {2, 3, 4, 5}}}),
      "s.csv:2: ring 'a' crosses itself at (5, 5)");
  has(refusal({{"a", rectangle(0, 0, 10, 10), {}}, {"b", rectangle(5, 5, 15, 15), {}}}),
      "crosses ring 'b' at (10, 5)");
  has(refusal({{"a", rectangle(0, 0, 10, 10), {}}, {"b", rectangle(0, 0, 10, 10), {}}}),
      "lies on another ring");
  has(refusal({{"a", {{0, 0}, {5, 0}, {10, 0}}, {}}}), "encloses no area");
}

// A crossing that only the whole search finds: one of 20 000 edges dips through another ring.
TEST(Slice, FindsOneCrossingAmongMany) {
  std::vector<Vec2> outer = circle(10, 20000), inner = circle(9, 20000);
  EXPECT_NO_THROW(slice_of({outer, inner}));
  inner[777] *= 10.1 / 9;
  EXPECT_THROW(slice_of({outer, inner}), Error);
}

TEST(SliceFile, ReadsAndRefuses) {
  TemporaryDirectory scratch;
  const auto read = [&](const std::string& text) {
    const std::string path = scratch.write("s.csv", text);
    try {
      const SliceFile file = read_slice(path);
      return "(read) " + std::to_string(file.slice.rings().size()) + " rings at " + std::to_string(file.z_mm);
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::bad_input);
      return e.where().substr(path.size()) + " " + e.what();
    }
  };
  const auto has = [](const std::string& text, const std::string& words) {
    EXPECT_NE(text.find(words), std::string::npos) << text;
  };
  has(read("path,i,x,y\na,0,0,0\na,1,1,0\na,2,1,1\na,3,0,0\n"), "(read) 1 rings");
  has(read("path,closed,i,x,y,z\na,1,0,0,0,2.5\na,1,1,1,0,2.5\na,1,2,1,1,2.5\n"), "(read) 1 rings at 2.5");
  has(read("path,i,x,y\n"), "no rows");
  has(read("path,closed,i,x,y\na,0,0,0,0\na,0,1,1,0\na,0,2,1,1\n"), ":2 ring 'a' is open");
  has(read("path,i,x,y\na,0,0,0\na,1,nan,0\na,2,1,1\n"), ":3 column 'x': 'nan' is not a finite number");
  has(read("path,i,x,y\na,0,0,0\na,2,1,0\na,1,1,1\n"), ":4 column 'i': 1 does not come after");
  has(read("path,i,x,y\na,0,0,0\nb,0,1,0\na,1,1,1\n"), ":4 ring 'a' appears again");
  has(read("path,i,x,y,z\na,0,0,0,0\na,1,1,0,1\na,2,1,1,0\n"), ":3 column 'z': differs");
  has(read("path,i,x\na,0,0\n"), "y");
}

}  // namespace
}  // namespace afptraj
