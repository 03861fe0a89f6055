// Level curves of the distance from a boundary: closed forms, laws, and Clipper as an independent route.
#include "fill/distance_diagram.h"

#include <gtest/gtest.h>

#include <polyclipping/clipper.hpp>
#include <random>

#include "fill/contour_parallel.h"
#include "tests/slices.h"

namespace afptraj {
namespace {

using namespace test;

struct Size {
  double area = 0, length = 0;
  std::size_t rings = 0;
};

Size size_of(const std::vector<ArcRing>& rings) {
  Size out;
  for (const ArcRing& ring : rings) out.area += signed_area(ring), out.length += length_mm(ring), ++out.rings;
  return out;
}

// Clipper's offset: lattice 1e-8 mm, arcs to 1e-6 mm.
Size clipper_offset(const Slice& slice, double distance_mm) {
  constexpr double scale = 1e8, arc_mm = 1e-6;
  ClipperLib::ClipperOffset offset(2, arc_mm * scale);
  for (const SliceRing& ring : slice.rings()) {
    ClipperLib::Path path;
    for (const Vec2& p : ring.points)
      path.emplace_back(std::llround(p.x() * scale), std::llround(p.y() * scale));
    offset.AddPath(path, ClipperLib::jtRound, ClipperLib::etClosedPolygon);
  }
  ClipperLib::Paths out;
  offset.Execute(out, -distance_mm * scale);
  Size size;
  for (const auto& path : out) {
    size.area += ClipperLib::Area(path) / (scale * scale);
    for (std::size_t i = 0; i < path.size(); ++i) {
      const auto &a = path[i], &b = path[(i + 1) % path.size()];
      size.length += std::hypot(static_cast<double>(b.X - a.X), static_cast<double>(b.Y - a.Y)) / scale;
    }
    ++size.rings;
  }
  return size;
}

TEST(DistanceDiagram, SquareInClosedForm) {
  const Slice square = slice_of({rectangle(0, 0, 10, 10)});
  const DistanceDiagram diagram = DistanceDiagram::of(square, 4);
  EXPECT_NEAR(diagram.greatest_mm(), 5, 1e-12);
  for (const double d : {0.5, 1.0, 3.25, 4.999}) {
    const Size in = size_of(diagram.level(d, 1e-6));
    EXPECT_EQ(in.rings, 1u);
    // coordinates are on the lattice: only rounding remains
    EXPECT_NEAR(in.area, (10 - 2 * d) * (10 - 2 * d), 1e-10);
    EXPECT_NEAR(in.length, 4 * (10 - 2 * d), 1e-10);
  }
  for (const double d : {0.5, 3.0}) {
    const Size out = size_of(diagram.level(-d, 1e-6));
    EXPECT_NEAR(out.area, 100 + 40 * d + pi * d * d, 1e-10);
    EXPECT_NEAR(out.length, 40 + 2 * pi * d, 1e-10);
  }
  EXPECT_TRUE(diagram.level(5, 1e-6).empty());
  EXPECT_TRUE(diagram.level(7, 1e-6).empty());
}

TEST(DistanceDiagram, BeadAlongAnOpenPathIsACapsule) {
  const DistanceDiagram diagram = DistanceDiagram::of({{{{0, 0}, {3, 0}, {3, 4}}, false}}, 1);
  const Size bead = size_of(diagram.level(-0.5, 1e-6));
  // two capsules of 3 and 4 that share half a disc and more: lengths x width + disc + corner's outer quarter
  // - inner square
  EXPECT_NEAR(bead.area, 7 + pi / 4 + pi / 16 - 0.25, 1e-9);
  EXPECT_EQ(bead.rings, 1u);
}

// Every point of a level curve is at that distance from the boundary, on the right side: asked of all edges.
TEST(DistanceDiagram, PointsAreAtTheDistance) {
  for (const Slice& slice : {slice_of({flower(0.15, 400), {{-5, -5}, {5, -5}, {5, 5}, {0, 0}, {-5, 5}}}),
                             slice_of({star()}), slice_of({l_shape(), circle(3, 50, {5, 5})})}) {
    const auto boundary = boundary_of(slice);
    const DistanceDiagram diagram = DistanceDiagram::of(slice, 3);
    for (const double d : {-3.0, -0.4, 0.3, 1.0, 1.7, 2.4}) {
      for (const ArcRing& ring : diagram.level(d, 1e-6)) {
        for (const Vec2& p : flattened(ring, 1e-3).points) {
          // the boundary is snapped by up to a unit; the points themselves lie on the exact curve
          EXPECT_NEAR(distance_to(boundary, p), std::abs(d), 2 * diagram.unit_mm());
          EXPECT_EQ(contains(slice, p), d > 0);
        }
      }
    }
  }
}

TEST(DistanceDiagram, AgreesWithClipper) {
  const std::vector<Vec2> hole{{-5, -5}, {5, -5}, {5, 5}, {0, 0}, {-5, 5}};
  for (const Slice& slice :
       {slice_of({flower(0.15, 1000)}), slice_of({flower(0.15, 1000), hole}), slice_of({star()}),
        slice_of({dumb_bell(3)}), slice_of({circle(15, 200), circle(9, 120), circle(5, 90)}),
        slice_of({circle(12, 300), circle(2.5, 80, {-5, 0}), circle(2.5, 80, {5, 1})})}) {
    const DistanceDiagram diagram = DistanceDiagram::of(slice, 2);
    for (const double d : {-2.0, -0.5, 0.4, 1.1, 1.9, 2.8, 3.7}) {
      const Size ours = size_of(diagram.level(d, 1e-6)), theirs = clipper_offset(slice, d);
      // Clipper's arcs are inscribed, up to 1e-6 mm inside of the curve, beside lattices of 1e-8 mm
      EXPECT_NEAR(ours.area, theirs.area, 1.1e-6 * std::max(theirs.length, 1.0)) << d;
      EXPECT_NEAR(ours.length, theirs.length, 1e-5 * std::max(theirs.length, 1.0)) << d;
      EXPECT_EQ(ours.rings, theirs.rings) << d;
    }
  }
}

// Rigid motion, the sense and the start of a ring change nothing but rounding.
TEST(DistanceDiagram, IsInvariant) {
  const std::vector<Vec2> ring = flower(0.15, 300);
  const Size plain = size_of(offset_rings(slice_of({ring}), 1.3, 1e-6));
  std::vector<Vec2> moved;
  for (const Vec2& p : ring) moved.push_back(Eigen::Rotation2Dd(0.7) * p + Vec2(1000, -300));
  std::rotate(moved.begin(), moved.begin() + 77, moved.end());
  const Size other = size_of(offset_rings(slice_of({reverse(moved)}), 1.3, 1e-6));
  EXPECT_NEAR(other.area, plain.area, 1e-5);  // snapping by 3e-8 mm along 130 mm
  EXPECT_NEAR(other.length, plain.length, 1e-5);
}

// Slivers, nearly parallel walls, points nearly on edges: curves stay closed and at their distance.
TEST(DistanceDiagram, RandomPolygons) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> radius(0.2, 10);
  for (int round = 0; round < 60; ++round) {
    std::vector<Vec2> ring;
    const int n = 5 + round * 3;
    for (int i = 0; i < n; ++i) {
      const double t = 2 * pi * i / n, r = radius(random);
      ring.emplace_back(r * std::cos(t), r * std::sin(t));
    }
    const Slice slice = slice_of({ring});
    const DistanceDiagram diagram = DistanceDiagram::of(slice, 1);
    for (const double d : {-1.0, 0.02, 0.2, 0.5}) {
      const Size ours = size_of(diagram.level(d, 1e-6)), theirs = clipper_offset(slice, d);
      EXPECT_NEAR(ours.area, theirs.area, 1.1e-6 * std::max(theirs.length, 1.0)) << round << " " << d;
    }
  }
}

}  // namespace
}  // namespace afptraj
