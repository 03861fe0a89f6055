#include "boundary/clip.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/specimens.h"

namespace afptraj {
namespace {

/// A circle of the (u, v) plane as four rational arcs; clockwise it is a hole.
Loop circle_loop(const Uv& centre, double radius, bool clockwise, int edge) {
  BSplineCurve2 c;
  c.degree = 2;
  c.knots = {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4};
  const double root = std::sqrt(0.5);
  for (int i = 0; i <= 8; ++i) {
    const double a = (clockwise ? -1 : 1) * i * pi / 4, r = i % 2 == 0 ? radius : radius / root;
    c.poles.push_back(centre + r * Uv(std::cos(a), std::sin(a)));
    c.weights.push_back(i % 2 == 0 ? 1 : root);
  }
  return {{{c, false, edge}}};
}

constexpr double width = 1000, height = 600, hole_radius = 120;
const Uv hole_centre(420, 330);

/// A rectangle with a circular hole, in the plane z = 0.
Skin plate_with_hole() {
  Part part = make_rectangular_part(Surface::plane({}), {0, width}, {0, height});
  part.faces[0].loops.push_back(
      circle_loop(hole_centre, hole_radius, true, static_cast<int>(part.edges.size())));
  part.edges.push_back({});
  return Skin(std::make_shared<const Part>(part), {0});
}

/// A straight line of the plane from a to b in `spans` cubics: exact.
SurfaceCurve straight(const Uv& a, const Uv& b, int spans = 7) {
  SurfaceCurve curve;
  curve.pieces.emplace_back();
  const double length = (b - a).norm();
  for (int i = 0; i <= spans; ++i) {
    CurveNode node;
    node.t = length * i / spans;
    node.at = {0, a + (b - a) * (static_cast<double>(i) / spans)};
    node.duv = (b - a) / length;
    curve.pieces[0].push_back(node);
  }
  return curve;
}

/// A whole circle from angle `a0` in cubics of about 0.3 mm; they are off by h^4 / (384 r^3) <= 4e-11 mm.
SurfaceCurve circle(const Uv& centre, double radius, double a0) {
  SurfaceCurve curve;
  curve.closed = true;
  curve.pieces.emplace_back();
  const int spans = static_cast<int>(2 * pi * radius / 0.3);
  for (int i = 0; i <= spans; ++i) {
    CurveNode node;
    const double a = a0 + 2 * pi * i / spans;
    node.t = radius * (a - a0);
    node.at = {0, centre + radius * Uv(std::cos(a), std::sin(a))};
    node.duv = Uv(-std::sin(a), std::cos(a));
    node.kg_per_mm = 1 / radius;
    curve.pieces[0].push_back(node);
  }
  return curve;
}

double length_of(const Skin& skin, const std::vector<SurfaceCurve>& curves) {
  double sum = 0;
  for (const SurfaceCurve& curve : curves)
    for (const auto& piece : curve.pieces)
      for (std::size_t i = 0; i + 1 < piece.size(); ++i) sum += arc_length(skin, piece, i, 0, 1);
  return sum;
}

Uv start_of(const SurfaceCurve& curve) { return curve.pieces.front().front().at.uv; }
Uv end_of(const SurfaceCurve& curve) { return curve.pieces.back().back().at.uv; }

void expect_ends(const SurfaceCurve& curve, const Uv& start, const Uv& end) {
  EXPECT_LT((start_of(curve) - start).norm(), 1e-9) << start_of(curve).transpose();
  EXPECT_LT((end_of(curve) - end).norm(), 1e-9) << end_of(curve).transpose();
}

/// The stretches clipped once more are themselves, and with those off the skin they make up the whole.
void expect_laws(const Skin& skin, const SurfaceCurve& curve) {
  const auto on = clip_to_skin(skin, curve), off = off_skin(skin, curve);
  EXPECT_NEAR(length_of(skin, on) + length_of(skin, off), length_of(skin, {curve}), 1e-9);
  for (const SurfaceCurve& stretch : on) {
    const auto again = clip_to_skin(skin, stretch);
    ASSERT_EQ(again.size(), 1u);
    EXPECT_EQ(again[0].pieces.size(), stretch.pieces.size());
    EXPECT_EQ(again[0].closed, stretch.closed);
    expect_ends(again[0], start_of(stretch), end_of(stretch));
    for (const auto& piece : stretch.pieces)
      for (std::size_t i = 0; i + 1 < piece.size(); ++i)
        EXPECT_TRUE(skin.trim(0).contains(cubic(piece, i).point(0.5)));
  }
}

TEST(Clip, CutsALineAtTheRectangleAndTheHole) {
  const Skin skin = plate_with_hole();
  for (const double y : {331.7, 250.0, 215.0, 449.999}) {  // the last one grazes the hole
    const SurfaceCurve line = straight(Uv(-77.3, y), Uv(1083.1, y));
    const auto clipped = clip_to_skin(skin, line);
    const double half = std::sqrt(hole_radius * hole_radius - (y - hole_centre.y()) * (y - hole_centre.y()));
    ASSERT_EQ(clipped.size(), 2u) << y;
    expect_ends(clipped[0], Uv(0, y), Uv(hole_centre.x() - half, y));
    expect_ends(clipped[1], Uv(hole_centre.x() + half, y), Uv(width, y));
    for (const SurfaceCurve& stretch : clipped) EXPECT_FALSE(stretch.closed);
    // The parameter of the ends is still that of the line.
    EXPECT_NEAR(clipped[0].first(), 77.3, 1e-9);
    EXPECT_NEAR(clipped[1].last(), 1077.3, 1e-9);
    expect_laws(skin, line);
    const auto off = off_skin(skin, line);
    ASSERT_EQ(off.size(), 3u);
    expect_ends(off[1], end_of(clipped[0]), start_of(clipped[1]));
  }
  // At a slant, through the centre of the hole.
  const Uv along = Uv(3, 4) / 5;
  const auto slant = clip_to_skin(skin, straight(hole_centre - 600 * along, hole_centre + 600 * along));
  ASSERT_EQ(slant.size(), 2u);
  expect_ends(slant[0], hole_centre - along * (330 / 0.8), hole_centre - hole_radius * along);
  expect_ends(slant[1], hole_centre + hole_radius * along, hole_centre + along * (270 / 0.8));
}

// A piece that begins just inside the boundary is cut there, not where it begins: pieces join where rays died near it.
TEST(Clip, CutsAPieceThatBeginsJustInside) {
  const Skin skin = plate_with_hole();
  for (const double inside : {1e-3, 5.3e-5, 2e-6}) {
    SurfaceCurve line = straight(Uv(800, 300), Uv(width - inside, 300));
    SurfaceCurve on = straight(Uv(width - inside, 300), Uv(width + 50, 300));
    for (CurveNode& node : on.pieces[0]) node.t += line.last();
    line.pieces.push_back(on.pieces[0]);
    const auto clipped = clip_to_skin(skin, line);
    ASSERT_EQ(clipped.size(), 1u) << inside;
    expect_ends(clipped[0], Uv(800, 300), Uv(width, 300));
  }
}

// A hole so small that it lies between two nodes, and within one cubic.
TEST(Clip, SeesAHoleBetweenTwoNodes) {
  Part part = make_rectangular_part(Surface::plane({}), {0, width}, {0, height});
  part.faces[0].loops.push_back(circle_loop(Uv(500, 300), 0.2, true, 4));
  part.edges.push_back({});
  const Skin skin(std::make_shared<const Part>(part), {0});
  const auto clipped = clip_to_skin(skin, straight(Uv(-10, 300.1), Uv(1010, 300.1), 1));
  ASSERT_EQ(clipped.size(), 2u);
  const double half = std::sqrt(0.04 - 0.01);
  expect_ends(clipped[0], Uv(0, 300.1), Uv(500 - half, 300.1));
  expect_ends(clipped[1], Uv(500 + half, 300.1), Uv(1000, 300.1));
}

// Circles about the corner (0, 0): the ends are known on both sides of the rectangle and, where the
// circles of curve and hole cross, on their radical line.
TEST(Clip, CutsAnArcAtKnownPlaces) {
  const Skin skin = plate_with_hole();
  const double r = 534.5;  // passes through the hole: its centre lies at 534.13
  const auto clipped = clip_to_skin(skin, circle(Uv(0, 0), r, -1));
  ASSERT_EQ(clipped.size(), 2u);
  const double d = hole_centre.norm(), x = (d * d + r * r - hole_radius * hole_radius) / (2 * d);
  const double y = std::sqrt(r * r - x * x);
  const Uv e = hole_centre / d, f(-e.y(), e.x());
  expect_ends(clipped[0], Uv(r, 0), x * e - y * f);
  expect_ends(clipped[1], x * e + y * f, Uv(0, r));
  expect_laws(skin, circle(Uv(0, 0), r, -1));
}

TEST(Clip, KeepsAClosedCurveClosed) {
  const Skin skin = plate_with_hole();
  const SurfaceCurve inside = circle(hole_centre, 200, 0.3);  // round the hole
  const auto whole = clip_to_skin(skin, inside);
  ASSERT_EQ(whole.size(), 1u);
  EXPECT_TRUE(whole[0].closed);
  EXPECT_NEAR(length_of(skin, whole), 2 * pi * 200, 1e-6);
  EXPECT_TRUE(off_skin(skin, inside).empty());
  expect_laws(skin, inside);
  // Within the hole, and round the plate: nothing is left.
  EXPECT_TRUE(clip_to_skin(skin, circle(hole_centre, 100, 0)).empty());
  EXPECT_TRUE(clip_to_skin(skin, circle(Uv(500, 300), 700, 0)).empty());
}

// Where a closed curve begins is nobody's business: wherever that is, the same stretches come out.
TEST(Clip, CutsAClosedCurveWhereverItBegins) {
  const Skin skin = plate_with_hole();
  const double r = 150;
  const Uv centre(hole_centre.x() + 200, hole_centre.y());  // its left side passes through the hole
  const double x = (200.0 * 200 + hole_radius * hole_radius - r * r) / 400,
               y = std::sqrt(hole_radius * hole_radius - x * x);
  for (const double a0 : {0.0, 1.0, 2.2, 3.1, 4.0, 5.5}) {
    const SurfaceCurve curve = circle(centre, r, a0);
    const auto clipped = clip_to_skin(skin, curve);
    ASSERT_EQ(clipped.size(), 1u) << a0;
    EXPECT_FALSE(clipped[0].closed) << a0;
    expect_ends(clipped[0], hole_centre + Uv(x, -y), hole_centre + Uv(x, y));
    for (const auto& piece : clipped[0].pieces)
      for (std::size_t i = 0; i + 1 < piece.size(); ++i) EXPECT_LT(piece[i].t, piece[i + 1].t);
    expect_laws(skin, curve);
  }
}

// A curve that only touches loses nothing on the inside and gains nothing on the outside.
TEST(Clip, PassesOverATouch) {
  const Skin skin = plate_with_hole();
  const double top = hole_centre.y() + hole_radius;
  for (const double x1 : {1000.0, 997.0}) {  // the touch within a cubic, and (x1 = 1000 - 3) elsewhere in one
    const auto above = clip_to_skin(skin, straight(Uv(-5, top), Uv(x1, top)));
    EXPECT_NEAR(length_of(skin, above), x1, 1e-9);
  }
  // Round the plate's inside, touching its lower side from within; round the outside, touching from without.
  EXPECT_NEAR(length_of(skin, clip_to_skin(skin, circle(Uv(800, 100), 100, 0.4))), 2 * pi * 100, 1e-6);
  EXPECT_TRUE(clip_to_skin(skin, circle(Uv(800, -100), 100, 0.4)).empty());
  // Within the hole, touching it: only the touch is on the skin.
  EXPECT_TRUE(clip_to_skin(skin, circle(hole_centre + Uv(20, 0), 100, 0.4)).empty());
  // One nanometre less, and it is cut: half chord sqrt(2 r 1e-6) = 0.0155.
  const auto cut = clip_to_skin(skin, straight(Uv(-5, top - 1e-6), Uv(1000, top - 1e-6)));
  ASSERT_EQ(cut.size(), 2u);
  EXPECT_NEAR(start_of(cut[1]).x() - end_of(cut[0]).x(), 2 * std::sqrt(2 * hole_radius * 1e-6), 1e-6);
}

// Through two corners: in at one, out at the other, once.
TEST(Clip, CutsThroughCorners) {
  const Skin skin = make_skin(Surface::plane({}), {0, 400}, {0, 300});
  const auto clipped = clip_to_skin(skin, straight(Uv(-80, -60), Uv(480, 360)));
  EXPECT_NEAR(length_of(skin, clipped), 500, 1e-9);
  ASSERT_EQ(clipped.size(), 1u);
  expect_ends(clipped[0], Uv(0, 0), Uv(400, 300));
}

TEST(Clip, DropsStretchesThatAreTooShort) {
  const Skin skin = make_skin(Surface::plane({}), {0, 400}, {0, 300});
  // Cuts the corner (400, 300) over 3 mm.
  const SurfaceCurve line = straight(Uv(300, 400 - 3 / std::sqrt(2.0)), Uv(500, 200 - 3 / std::sqrt(2.0)));
  const auto clipped = clip_to_skin(skin, line);
  ASSERT_EQ(clipped.size(), 1u);
  EXPECT_NEAR(length_of(skin, clipped), 3, 1e-9);
  EXPECT_EQ(clip_to_skin(skin, line, 2.999).size(), 1u);
  EXPECT_TRUE(clip_to_skin(skin, line, 3.001).empty());
}

// A hole on a cylinder, crossed by a generator and by a hoop; the crossings in closed form in (u, v).
TEST(Clip, CutsOnACurvedFace) {
  const double R = 350;
  Part part = make_rectangular_part(Surface::cylinder({}, R), {0, 2}, {0, 1000});
  // In (u, v) an ellipse-like figure would be a circle of the unrolled sheet; here a circle of (u, v) does.
  part.faces[0].loops.push_back(circle_loop(Uv(1, 500), 0.4, true, 4));
  part.edges.push_back({});
  const Skin skin(std::make_shared<const Part>(part), {0});
  const auto hoop = clip_to_skin(skin, straight(Uv(-0.5, 500.2), Uv(2.5, 500.2)));
  ASSERT_EQ(hoop.size(), 2u);
  const double half = std::sqrt(0.16 - 0.04);
  EXPECT_NEAR(R * start_of(hoop[0]).x(), 0, 1e-9);
  EXPECT_NEAR(R * end_of(hoop[0]).x(), R * (1 - half), 1e-9);
  EXPECT_NEAR(R * start_of(hoop[1]).x(), R * (1 + half), 1e-9);
  EXPECT_NEAR(R * end_of(hoop[1]).x(), R * 2, 1e-9);
}

TEST(Clip, SamplesWhatItKept) {
  const Skin skin = plate_with_hole();
  const DirectionField field({{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 0, 1)}}, 1e4);
  const auto clipped = clip_to_skin(skin, circle(Uv(0, 0), 534.5, -1));
  const CourseSegment segment = sample_segment(skin, clipped[0], field);
  EXPECT_NEAR(segment.length_mm(), length_of(skin, {clipped[0]}), 1e-9);
  for (const CourseSample& s : segment.samples) {
    EXPECT_NEAR(s.position.norm(), 534.5, 1e-9);
    EXPECT_NEAR(s.kg_per_mm, 1 / 534.5, 1e-12);
    EXPECT_NEAR(s.kn_per_mm, 0, 1e-15);
    const double angle = std::atan2(s.tangent.y(), s.tangent.x());
    EXPECT_NEAR(std::remainder(s.deviation_rad - angle, pi), 0, 1e-9);
    EXPECT_GT(s.deviation_rad, -pi / 2);
    EXPECT_LE(s.deviation_rad, pi / 2);
  }
  const SurfaceCurve again = curve_of(skin, segment);
  ASSERT_EQ(again.pieces.size(), 1u);
  EXPECT_NEAR(length_of(skin, {again}), segment.length_mm(), 1e-9);
}

/// Two faces of the plane z = 0 that share an edge along y = 500, where the second begins `gap` beyond the first.
Skin plates_with_gap(double gap) {
  Part part = make_rectangular_part(Surface::plane({}), {0, 1000}, {0, 500});
  RectangularFace second =
      make_rectangular_face(Surface::plane({}), {0, 1000}, {500 + gap, 800}, static_cast<int>(part.edges.size()));
  part.edges.insert(part.edges.end(), second.edges.begin(), second.edges.end());
  const int top = 2, bottom = 0;  // sides in the order of the loop
  second.face.loops[0].coedges[bottom].edge = part.faces[0].loops[0].coedges[top].edge;
  part.faces.push_back(std::move(second.face));
  return Skin(std::make_shared<const Part>(part), {0, 1});
}

// Over a gap the course is one segment with a sample on either side, none in the gap, and the way over it in s;
// without one there is one sample on the edge. What is read back from the samples is the same curve.
TEST(Clip, GoesOnOverFacesThatGap) {
  for (const double gap : {0.0, 5e-3, 0.05}) {
    const Skin skin = plates_with_gap(gap);
    const double x = 175, length = 100;
    SurfaceCurve curve = straight(Uv(x, 500 - length), Uv(x, 500));
    const SurfaceCurve beyond = straight(Uv(x, 500 + gap), Uv(x, 500 + gap + length));
    curve.pieces.push_back(beyond.pieces[0]);
    for (CurveNode& node : curve.pieces[1]) {
      node.t += length;
      node.at.face = 1;
    }
    const auto clipped = clip_to_skin(skin, curve);
    ASSERT_EQ(clipped.size(), 1u) << gap;
    const DirectionField field({{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 0, 1)}}, 1e4);
    const CourseSegment segment = sample_segment(skin, clipped[0], field);
    EXPECT_EQ(segment.samples.size(), gap > 0 ? 16u : 15u);
    EXPECT_NEAR(segment.length_mm(), 2 * length + gap, 1e-9);
    for (const CourseSample& s : segment.samples) {
      EXPECT_NEAR(s.s_mm, s.position.y() - (500 - length), 1e-9);
      EXPECT_TRUE(s.position.y() <= 500 + 1e-9 || s.position.y() >= 500 + gap - 1e-9) << s.position.y();
    }
    const SurfaceCurve again = curve_of(skin, segment);
    ASSERT_EQ(again.pieces.size(), 2u) << gap;
    EXPECT_NEAR(again.pieces[0].back().at.uv.y(), 500, 1e-9);
    EXPECT_NEAR(again.pieces[1].front().at.uv.y(), 500 + gap, 1e-9);
    EXPECT_NEAR(length_of(skin, {again}), 2 * length, 1e-9);
  }
}

// A path stands in the gap just before it enters a face, or just after it left one: neither is on the skin.
TEST(Clip, LeavesOutTheGap) {
  const double gap = 0.05, x = 175, length = 100;
  const Skin skin = plates_with_gap(gap);
  for (const bool late : {false, true}) {
    const double over = late ? 500 + gap : 500;  // where the path goes from one face to the other
    SurfaceCurve curve = straight(Uv(x, over - length), Uv(x, over));
    curve.pieces.push_back(straight(Uv(x, over), Uv(x, over + length)).pieces[0]);
    for (CurveNode& node : curve.pieces[1]) {
      node.t += length;
      node.at.face = 1;
    }
    const auto clipped = clip_to_skin(skin, curve);
    ASSERT_EQ(clipped.size(), 1u) << late;
    ASSERT_EQ(clipped[0].pieces.size(), 2u) << late;
    EXPECT_NEAR(clipped[0].pieces[0].back().at.uv.y(), 500, 1e-9) << late;
    EXPECT_NEAR(clipped[0].pieces[1].front().at.uv.y(), 500 + gap, 1e-9) << late;
    const DirectionField field({{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 0, 1)}}, 1e4);
    const CourseSegment segment = sample_segment(skin, clipped[0], field);
    EXPECT_NEAR(segment.length_mm(), 2 * length, 1e-9);
    const SurfaceCurve again = curve_of(skin, segment);
    ASSERT_EQ(again.pieces.size(), 2u) << late;
    EXPECT_NEAR(length_of(skin, {again}), 2 * length - gap, 1e-9);
  }
}

// An axis has no sense: angles fold into (-90, 90] degrees.
TEST(Clip, FoldsTheDeviationOfAnAxis) {
  const Vec3 z = Vec3::UnitZ(), asked = Vec3::UnitX();
  for (int degrees = -360; degrees <= 360; degrees += 15) {
    const double a = degrees * pi / 180;
    const double d = axis_deviation(asked, Vec3(std::cos(a), std::sin(a), 0), z);
    EXPECT_NEAR(std::remainder(d - a, pi), 0, 1e-14) << degrees;
    EXPECT_GE(d, -pi / 2) << degrees;
    EXPECT_LE(d, pi / 2) << degrees;
    if (std::abs(d) > 1.57) continue;  // 90 degrees is its own mirror image
    EXPECT_NEAR(axis_deviation(asked, Vec3(std::cos(a), std::sin(a), 0), -z), -d, 1e-14) << degrees;
  }
}

}  // namespace
}  // namespace afptraj
