#include "trajectory/feature_sections.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/specimens.h"

namespace afptraj {
namespace {

constexpr double W = 50.8;
// The sections' length is asked for to 1e-4 mm a metre.
constexpr double length_tolerance = 2e-4;

/// A straight (u, v) segment as the reference path.
SplinePath uv_line(const Skin& skin, const Uv& a, const Uv& b, int normal_sign = 1) {
  const double length = (skin.point({0, b}) - skin.point({0, a})).norm();
  return SplinePath(skin, {{{0, normal_sign, nullptr}, line_segment(a, b, 0, length)}}, false);
}

void expect_bands(const FeatureSections& sections) {
  EXPECT_EQ(sections.N1, std::max(0, static_cast<int>(std::ceil((sections.L1_mm - W / 2) / W))));
  EXPECT_EQ(sections.N2, std::max(0, static_cast<int>(std::ceil((sections.L2_mm - W / 2) / W))));
}

// A plate, along its length: what lies to the left and to the right of the path. b = n x t is left.
TEST(FeatureSections, MeasureAPlate) {
  const Skin skin = make_skin(Surface::plane({}), {0, 1000}, {0, 600});
  const FeatureSections along = feature_sections(skin, uv_line(skin, Uv(0, 130), Uv(1000, 130)), W, W);
  EXPECT_NEAR(along.L1_mm, 470, length_tolerance);
  EXPECT_NEAR(along.L2_mm, 130, length_tolerance);
  EXPECT_EQ(along.N1, 9);  // (470 - 25.4) / 50.8 = 8.75
  EXPECT_EQ(along.N2, 3);  // (130 - 25.4) / 50.8 = 2.06
  const FeatureSections back = feature_sections(skin, uv_line(skin, Uv(1000, 130), Uv(0, 130)), W, W);
  EXPECT_NEAR(back.L1_mm, along.L2_mm, length_tolerance);
  EXPECT_NEAR(back.L2_mm, along.L1_mm, length_tolerance);
  EXPECT_EQ(back.N1, along.N2);
  EXPECT_EQ(back.N2, along.N1);
}

// At 45 degrees through the plate's corners the longest sections end in the other two corners; the path is
// asked every W, so the greatest is missed by W / 2 at most, of sides that fall with slope 1.
TEST(FeatureSections, TakeTheGreatestOverThePath) {
  const Skin skin = make_skin(Surface::plane({}), {0, 600}, {0, 600});
  const SplinePath diagonal = uv_line(skin, Uv(0, 0), Uv(600, 600));
  const double half = 300 * std::sqrt(2.0);
  for (const double spacing : {W, 1.0}) {
    const FeatureSections sections = feature_sections(skin, diagonal, W, spacing);
    EXPECT_LE(sections.L1_mm, half + length_tolerance);
    EXPECT_GE(sections.L1_mm, half - spacing / 2 - length_tolerance);
    EXPECT_NEAR(sections.L2_mm, sections.L1_mm, length_tolerance);
    expect_bands(sections);
  }
}

// A part of a cylinder along a generator: the sections are arcs of its circle.
TEST(FeatureSections, MeasureArcsOfACylinder) {
  const double R = 350;
  const Surface surface = Surface::cylinder({}, R);
  Part part = make_rectangular_part(surface, {0.2, 2.7}, {0, 1000});
  for (const bool reversed : {false, true}) {
    part.faces[0].reversed = reversed;
    const Skin skin(std::make_shared<const Part>(part), {0});
    // Up along z: n x t = x cross z = -y at u = 0, so u falls to the left.
    const FeatureSections sections = feature_sections(skin, uv_line(skin, Uv(0.9, 10), Uv(0.9, 990)), W, W);
    const double to_low = R * 0.7, to_high = R * 1.8;
    EXPECT_NEAR(sections.L1_mm, reversed ? to_high : to_low, length_tolerance);
    EXPECT_NEAR(sections.L2_mm, reversed ? to_low : to_high, length_tolerance);
    EXPECT_EQ(sections.N1, reversed ? 12 : 5);  // (630 - 25.4) / 50.8 = 11.90, (245 - 25.4) / 50.8 = 4.32
    EXPECT_EQ(sections.N2, reversed ? 5 : 12);
    expect_bands(sections);
    // A carried normal that is turned once more turns the sides again.
    const FeatureSections turned = feature_sections(skin, uv_line(skin, Uv(0.9, 10), Uv(0.9, 990), -1), W, W);
    EXPECT_NEAR(turned.L1_mm, sections.L2_mm, length_tolerance);
    EXPECT_NEAR(turned.L2_mm, sections.L1_mm, length_tolerance);
  }
}

// Across a cylinder, along a hoop: the sections are generators.
TEST(FeatureSections, MeasureGeneratorsOfACylinder) {
  const double R = 350;
  const Skin skin = make_skin(Surface::cylinder({}, R), {0, 2.7}, {0, 1000});
  const FeatureSections sections = feature_sections(skin, uv_line(skin, Uv(0.1, 300), Uv(2.6, 300)), W, W);
  EXPECT_NEAR(sections.L1_mm, 700, length_tolerance);  // n x t = z
  EXPECT_NEAR(sections.L2_mm, 300, length_tolerance);
  EXPECT_EQ(sections.N1, 14);  // 13.28
  EXPECT_EQ(sections.N2, 6);   // 5.41
}

// Round a whole tube both sides meet opposite of the path: they share the section, and the bands of both make up the
// tube.
TEST(FeatureSections, ShareAWholeTube) {
  const double R = 100;
  const Skin skin = make_skin(Surface::cylinder({}, R), {0, 2 * pi}, {0, 1000});
  const FeatureSections sections = feature_sections(skin, uv_line(skin, Uv(0.9, 10), Uv(0.9, 990)), W, W);
  EXPECT_NEAR(sections.L1_mm, pi * R, length_tolerance);
  EXPECT_NEAR(sections.L2_mm, pi * R, length_tolerance);
  EXPECT_EQ(sections.N1 + sections.N2 + 1, 13);  // 628.3 / 50.8 = 12.4
  expect_bands(sections);
}

// On a helix the planes cut ellipses: at 45 degrees the axes R and R sqrt 2. The unrolled section is the sine
// z = R sin(phi) times the slope: from the middle of a half cylinder its length is known.
TEST(FeatureSections, MeasureEllipsesOfACylinder) {
  const double R = 100, phi = 1.0;
  const Skin skin = make_skin(Surface::cylinder({}, R), {-phi, phi}, {-1000, 1000});
  // One point of a helix at 45 degrees, on the middle generator; to both sides the plane z = -y meets u =
  // +-phi.
  const SplinePath helix = uv_line(skin, Uv(-1e-6 / R, -1e-6), Uv(1e-6 / R, 1e-6));
  const FeatureSections sections = feature_sections(skin, helix, W, W);
  double length = 0;  // of sqrt(R^2 + (R cos phi)^2) by Simpson's rule; its error is 1e-12
  const int n = 200;
  for (int i = 0; i <= n; ++i) {
    const double c = std::cos(phi * i / n), weight = i == 0 || i == n ? 1 : i % 2 == 1 ? 4 : 2;
    length += weight * R * std::sqrt(1 + c * c) * phi / n / 3;
  }
  EXPECT_NEAR(sections.L1_mm, length, length_tolerance);
  EXPECT_NEAR(sections.L2_mm, length, length_tolerance);
}

// N = ceil((L - W/2) / W), never below 0: course 0 covers W / 2 on each side. Lengths of whole bands need no
// further one for the sake of rounding.
TEST(FeatureSections, CountTheBands) {
  const double high = 20000;
  const Skin skin = make_skin(Surface::plane({}), {0, 100}, {0, high});
  const auto bands = [&](double right) {
    const FeatureSections sections =
        feature_sections(skin, uv_line(skin, Uv(0, right), Uv(100, right)), W, W);
    EXPECT_NEAR(sections.L2_mm, right, 1e-9 * high + length_tolerance);
    return sections.N2;
  };
  EXPECT_EQ(bands(1), 0);
  EXPECT_EQ(bands(W / 2 - 0.1), 0);
  EXPECT_EQ(bands(W / 2 + 0.1), 1);
  EXPECT_EQ(bands(1.5 * W - 0.1), 1);
  EXPECT_EQ(bands(1.5 * W + 0.1), 2);
  EXPECT_EQ(bands(10.5 * W - 0.1), 10);
  EXPECT_EQ(bands(10.5 * W + 0.1), 11);
  EXPECT_EQ(bands(W / 2), 0);
  EXPECT_EQ(bands(100.5 * W), 100);
}

// Sections cross from face to face: a plate folded at right angles is as long as its two sides.
TEST(FeatureSections, GoOverAFold) {
  Frame upright;
  upright.origin = Vec3(0, 300, 0);
  upright.y = Vec3(0, 0, 1);
  upright.z = Vec3(0, -1, 0);
  RectangularFace flat = make_rectangular_face(Surface::plane({}), {0, 500}, {0, 300});
  RectangularFace wall = make_rectangular_face(Surface::plane(upright), {0, 500}, {0, 200}, 4);
  Part part;
  // The flat one's side v = 300 is the wall's side v = 0.
  const int shared = flat.face.loops[0].coedges[2].edge;
  wall.face.loops[0].coedges[0].edge = shared;
  part.faces = {flat.face, wall.face};
  part.edges = flat.edges;
  part.edges.insert(part.edges.end(), wall.edges.begin(), wall.edges.end());
  const Skin skin(std::make_shared<const Part>(part), {0, 1});
  const FeatureSections sections = feature_sections(skin, uv_line(skin, Uv(0, 100), Uv(500, 100)), W, W);
  EXPECT_NEAR(sections.L1_mm, 200 + 200, length_tolerance);
  EXPECT_NEAR(sections.L2_mm, 100, length_tolerance);
}

}  // namespace
}  // namespace afptraj
