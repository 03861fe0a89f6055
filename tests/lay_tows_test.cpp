// Tows against closed forms: cases R1, R5 and R8, plates, holes in every position, faces that meet.
#include "boundary/lay_tows.h"

#include <gtest/gtest.h>

#include "tests/tow_specimens.h"

namespace afptraj {
namespace {

constexpr double d = 6.35;

// A straight boundary at an angle a: edges leave at +-w/2 cot a from the middle, the rule cuts at its share between
// (case R8: the triangle is w / tan a long). Straight lines of a plane are exact: the solver's tolerance is left.
TEST(Tows, AreCutAtTheirShareOfASlantedBoundary) {
  const double height = 600;
  const Skin skin = plate(3000, height);
  for (const double angle_deg : {90.0, 45.0, 20.0, 5.0}) {
    const double a = angle_deg * pi / 180, cot = std::cos(a) / std::sin(a);
    const Uv along(std::cos(a), std::sin(a));
    for (const double p : {0.0, 0.25, 0.5, 1.0}) {
      // Begins inside, ends beyond the upper side, far from the others.
      const double reach = 250;
      const Uv centre(1500, height - reach * std::sin(a));
      const LaidTows tows =
          lay(skin, {straight_course(0, centre - 200 * along, centre + 1.2 * reach * along)}, 8, d, bare_rule(p));
      ASSERT_EQ(tows.pieces.size(), 8u) << angle_deg << " " << p;
      for (const TowPiece& piece : tows.pieces) {
        const double m = (4.5 - piece.tow) * d;
        // The middle line reaches y = height where centre.y + s sin a + m cos a = height.
        const double s = (height - centre.y() - m * std::cos(a)) / std::sin(a) + (p - 0.5) * d * cot;
        const Uv expected = centre + s * along + m * Uv(-along.y(), along.x());
        const Vec3 end = piece.samples.back().position;
        EXPECT_NEAR(end.x(), expected.x(), 1e-7) << angle_deg << " " << p << " tow " << piece.tow;
        EXPECT_NEAR(end.y(), expected.y(), 1e-7) << angle_deg << " " << p << " tow " << piece.tow;
      }
    }
  }
}

// The centre line ends 0.1 mm beyond the boundary; outer tows go on for W / (2 tan a).
TEST(Tows, GoOnWhereTheCentreLineHasLeft) {
  const Skin skin = plate(1000, 600);
  for (const double angle_deg : {60.0, 30.0, 10.0}) {
    const double a = angle_deg * pi / 180;
    const Uv along(std::cos(a), std::sin(a)), out(500, 600 + 0.1);
    const LaidTows tows = lay(skin, {straight_course(0, out - 400 * along, out)}, 8, d, bare_rule(0));
    ASSERT_EQ(tows.pieces.size(), 8u);
    for (const TowPiece& piece : tows.pieces) {
      const double m = (4.5 - piece.tow) * d;
      // The left edge leaves first: 0 %.
      const double s = 400 - (0.1 + (m + d / 2) * std::cos(a)) / std::sin(a);
      EXPECT_NEAR(piece.length_mm(), s, 1e-6) << angle_deg << " tow " << piece.tow;
    }
  }
}

TEST(Tows, OfACourseWhoseCentreNeverTouchesTheSkin) {
  const Skin skin = plate(1000, 600);
  // Centre 10 mm below the lower side: tows 1 and 2 lie above it by 15.4 ... 2.7; tow 3's middle is at 5.875.
  const LaidTows tows = lay(skin, {straight_course(-1, {-20, -10}, {1020, -10})}, 8, d, bare_rule(0.5));
  ASSERT_EQ(tows.pieces.size(), 2u);
  for (const TowPiece& piece : tows.pieces) EXPECT_NEAR(piece.length_mm(), 1000, 1e-7);
  EXPECT_EQ(tows.pieces[1].tow, 2);
  // 100 %: tow 3 reaches over to 2.7 mm below - it does not touch; with the centre at -8 it does.
  EXPECT_EQ(lay(skin, {straight_course(-1, {-20, -8}, {1020, -8})}, 8, d, bare_rule(1)).pieces.size(), 3u);
  EXPECT_EQ(lay(skin, {straight_course(-1, {-20, -8}, {1020, -8})}, 8, d, bare_rule(0)).pieces.size(), 2u);
  EXPECT_TRUE(lay(skin, {straight_course(-1, {-20, -80}, {1020, -80})}, 8, d, bare_rule(1)).pieces.empty());
}

struct HoleCase {
  const char* where;
  Uv centre;
  double radius;
  double p;
  std::vector<int> cut;  ///< tows in two pieces
};

// Tows 1 ... 4 of 10 mm, their edges at y = 320, 310, 300, 290, 280; the next course lies below from 280.
TEST(Tows, AHoleInEveryPosition) {
  const double w = 10;
  const std::vector<LevelCurve> levels = {straight_course(-1, {-50, 260}, {1050, 260}),
                                          straight_course(0, {-50, 300}, {1050, 300})};
  const std::vector<HoleCase> cases = {{"inside one tow, over its middle", {500, 305}, 4, 0.5, {2}},
                                       {"inside one tow, over its middle, full", {500, 305}, 4, 1, {}},
                                       {"inside one tow, beside its middle", {500, 302.5}, 2, 0.5, {}},
                                       {"across three", {500, 305}, 13, 0.5, {1, 2, 3}},
                                       {"across three, not to the middles", {500, 305}, 9.95, 0.5, {2}},
                                       {"across three, to the rule's lines", {500, 305}, 9.95, 0.49, {1, 2, 3}},
                                       {"across three, none", {500, 305}, 9, 0, {1, 2, 3}},
                                       {"at a course border", {500, 280}, 8, 0.5, {4}},
                                       {"touching a tow's edge", {500, 305}, 5, 0, {2}}};
  for (const HoleCase& c : cases) {
    const Skin skin = plate(1000, 600, {circle_loop(c.centre, c.radius, true, 0)});
    const LaidTows tows = lay(skin, levels, 4, w, bare_rule(c.p));
    for (int tow = 1; tow <= 4; ++tow) {
      const bool cut = std::find(c.cut.begin(), c.cut.end(), tow) != c.cut.end();
      const auto pieces = pieces_of(tows, 0, tow);
      ASSERT_EQ(pieces.size(), cut ? 2u : 1u) << c.where << ", tow " << tow;
      // Where the rule's line crosses the circle: at the edge nearer to the hole's middle, p of the width outwards.
      if (!cut || c.p != 0) continue;
      const double hi = 330 - 10 * tow, lo = hi - w;
      const double y = c.centre.y() > hi ? hi : c.centre.y() < lo ? lo : hi;
      const double dy = y - c.centre.y();
      if (c.centre.y() < hi && c.centre.y() > lo) continue;
      const double half = std::sqrt(c.radius * c.radius - dy * dy);
      EXPECT_NEAR(pieces[0]->length_mm(), 500 - half, 1e-6) << c.where << ", tow " << tow;
      EXPECT_NEAR(pieces[1]->length_mm(), 500 - half, 1e-6) << c.where << ", tow " << tow;
    }
    const auto border = pieces_of(tows, -1, 1);  // 270 ... 280
    const bool reached = c.centre.y() < 285;
    EXPECT_EQ(border.size(), reached ? 2u : 1u) << c.where;
  }
}

TEST(Tows, AHoleThatTouchesTheBoundaryIsANotch) {
  // A round notch of the left side: centre (0, 305), radius 20, as part of one outer loop.
  std::vector<Uv> corners = {{0, 0}, {1000, 0}, {1000, 600}, {0, 600}, {0, 325}};
  for (int i = 1; i < 90; ++i) corners.push_back(Uv(0, 305) + 20 * Uv(std::sin(i * pi / 90), std::cos(i * pi / 90)));
  corners.push_back({0, 285});
  Part part = make_rectangular_part(Surface::plane({}), {0, 1000}, {0, 600});
  part.faces[0].loops = {polygon_loop(corners, 0)};
  const Skin skin(std::make_shared<const Part>(part), {0});
  const LaidTows tows = lay(skin, {straight_course(0, {-50, 300}, {1050, 300})}, 4, 10, bare_rule(0.5));
  ASSERT_EQ(tows.pieces.size(), 4u);
  for (const TowPiece& piece : tows.pieces) {
    const double dy = 325 - 10 * piece.tow - 305;
    const double depth = std::abs(dy) < 20 ? std::sqrt(400 - dy * dy) : 0;
    // The polygon lies within 20 (1 - cos 1 deg) = 3.1e-3 of the circle, along the tow by at most 3.1e-3 / cos 60 deg.
    EXPECT_NEAR(piece.length_mm(), 1000 - depth, 7e-3) << piece.tow;
  }
}

TEST(Tows, ATinyHoleBelowTheMinimumGapIsLaidThrough) {
  const Skin skin = plate(1000, 600, {circle_loop({500, 305}, 4, true, 0), circle_loop({700, 305}, 0.01, true, 0)});
  CutRule rule;  // the minimum gap of 25
  const LaidTows tows = lay(skin, {straight_course(0, {-50, 300}, {1050, 300})}, 4, 10, rule);
  EXPECT_EQ(tows.pieces.size(), 4u);
  EXPECT_EQ(tows.report.bridged, 2);
}

TEST(Tows, ShortPiecesAtACornerAreExtendedPastTheBoundary) {
  const Skin skin = plate(1000, 600);
  // Cuts the corner (0, 0): at distance c from it along the diagonal a line at 45 degrees is 2 c long.
  const double c = 25;
  const Uv corner_point = Uv(c, c) / std::sqrt(2.0), along = Uv(1, -1) / std::sqrt(2.0);
  const LevelCurve level = straight_course(0, corner_point - 30 * along, corner_point + 30 * along);
  CutRule rule;
  rule.min_gap_mm = 0;
  for (const ShortTows how : {ShortTows::symmetric, ShortTows::forward, ShortTows::backward, ShortTows::drop}) {
    rule.short_tows = how;
    const LaidTows tows = lay(skin, {level}, 4, 5, rule);
    if (how == ShortTows::drop) {
      EXPECT_TRUE(tows.pieces.empty());
      EXPECT_EQ(tows.report.dropped, 4);
      continue;
    }
    ASSERT_EQ(tows.pieces.size(), 4u) << to_string(how);
    EXPECT_EQ(tows.report.extended, 4);
    for (const TowPiece& piece : tows.pieces) {
      EXPECT_NEAR(piece.length_mm(), 101.6, 1e-6);
      const double m = (2.5 - piece.tow) * 5, half = c + m;  // n x t of (1, -1) points away from the corner
      const Uv middle = corner_point + m * Uv(1, 1) / std::sqrt(2.0);
      const double start = how == ShortTows::symmetric ? -50.8 : how == ShortTows::forward ? -half : half - 101.6;
      const Uv expected = middle + start * along;
      EXPECT_NEAR(piece.samples.front().position.x(), expected.x(), 1e-6) << to_string(how) << piece.tow;
      EXPECT_NEAR(piece.samples.front().position.y(), expected.y(), 1e-6) << to_string(how) << piece.tow;
    }
  }
}

TEST(Tows, AreTheSameWhenTheirLinesAreNotKept) {
  const Skin skin = make_skin(gentle_surface(), {0, 1}, {0, 1});
  std::vector<LevelCurve> levels;
  // The last lies off the skin altogether, its bands are left out; the one before reaches in.
  for (const double v : {0.5, 0.6, 1.01, 3.0}) levels.push_back({static_cast<int>(levels.size()), {straight_uv({-0.02, v}, {1.02, v}, 1040)}});
  TowLineOptions options;
  const LaidTows kept = lay_tows(skin, levels, options, bare_rule(0.5));
  const LaidTows freed = lay_tows(skin, levels, options, bare_rule(0.5), false);
  EXPECT_EQ(kept.bands.size(), 3u);
  EXPECT_TRUE(freed.bands.empty());
  const std::vector<TowBand> bands = tow_bands(skin, levels, options);
  ASSERT_EQ(bands.size(), 3u);
  ASSERT_EQ(kept.pieces.size(), freed.pieces.size());
  for (std::size_t i = 0; i < kept.pieces.size(); ++i) {
    const TowPiece &a = kept.pieces[i], &b = freed.pieces[i];
    EXPECT_EQ(a.band, b.band);
    EXPECT_EQ(bands[a.band].course, a.course);
    EXPECT_EQ(a.range.hi, b.range.hi);
    ASSERT_EQ(a.samples.size(), b.samples.size());
    EXPECT_EQ(a.samples.back().position, b.samples.back().position);
  }
}

// R1: on a cylinder lines at an offset from a helix are helices of the same slope: length 1414.2136 from rim to rim for
// the middle of a tow (50 %), straight (radius above 1e6).
TEST(Tows, OnACylinderAreHelices) {
  const double R = 350, L = 1000;
  const Skin skin = make_skin(Surface::cylinder({}, R), {0, 4}, {0, L});
  const double du = L / R;
  const LaidTows tows = lay(skin, {{0, {straight_uv({0.5, 0}, {0.5 + du, L}, L * std::sqrt(2.0))}}}, 8, d, bare_rule(0.5));
  ASSERT_EQ(tows.pieces.size(), 8u);
  for (const TowPiece& piece : tows.pieces) EXPECT_NEAR(piece.length_mm(), 1414.2135623730951, 1e-6);
  EXPECT_GT(tows.report.tightest.radius_mm, 1e6);
}

// R5: the parallel of the equator at distance x has steering radius R cot(x / R) and length ratio cos(x / R).
TEST(Tows, OnASphereTurnAsTheirDistanceFromTheEquator) {
  const double R = 1000;
  const Skin skin = make_skin(Surface::sphere({}, R), {0, 1}, {-0.7, 0.7});
  const int N = 20;
  const double w = 50.8;
  const LaidTows tows = lay(skin, {{0, {straight_uv({0, 0}, {1, 0}, R)}}}, N, w, bare_rule(0.5));
  ASSERT_EQ(tows.pieces.size(), static_cast<std::size_t>(N));
  for (const TowPiece& piece : tows.pieces) {
    const double x = (0.5 * (N + 1) - piece.tow) * w / R;
    EXPECT_NEAR(piece.length_mm(), R * std::cos(x), 2e-3);  // cubics every 16 mm, to 1e-3 mm
    const double kg = piece.samples[piece.samples.size() / 2].kg_per_mm;
    EXPECT_NEAR(kg, std::tan(x) / R, 1e-9);
  }
  EXPECT_NEAR(tows.report.tightest.radius_mm, R / std::tan((0.5 * N - 0.5) * w / R), 1e-3);
}

// Between nodes too a line lies at its distance, within its tolerance; the sphere's latitude tells.
TEST(TowLines, KeepTheirDistanceBetweenNodes) {
  const double R = 200;
  const Skin skin = make_skin(Surface::sphere({}, R), {0, 2}, {-1, 1});
  // Along a great circle inclined by 0.5: exact cubics of it every 1 mm (error 1 / 384 R^3: 1e-9).
  SurfaceCurve circle;
  circle.pieces.emplace_back();
  const double tilt = 0.5;
  for (int i = 20; i <= 280; ++i) {
    const double a = i / R;
    const Vec3 p(std::cos(a), std::sin(a) * std::cos(tilt), std::sin(a) * std::sin(tilt));
    const Vec3 v(-std::sin(a), std::cos(a) * std::cos(tilt), std::cos(a) * std::sin(tilt));
    CurveNode node;
    node.t = i;
    const double r2 = p.x() * p.x() + p.y() * p.y();
    node.at = {0, Uv(std::atan2(p.y(), p.x()), std::asin(p.z()))};
    node.duv = Uv((p.x() * v.y() - p.y() * v.x()) / r2, v.z() / std::sqrt(r2)) / R;
    circle.pieces[0].push_back(node);
  }
  TowLineOptions options;
  const auto bands = tow_bands(skin, {{0, {circle}}}, options);
  ASSERT_EQ(bands.size(), 1u);
  const Vec3 pole(0, -std::sin(tilt), std::cos(tilt));
  double worst = 0;
  for (const TowLine& line : bands[0].edges)
    for (const SurfaceCurve& run : line.runs)
      for (int i = 0; i <= 1000; ++i) {
        const Vec3 p = frame_at(skin, run, run.first() + (run.last() - run.first()) * i / 1000).frame.position;
        worst = std::max(worst, std::abs(R * std::asin(p.dot(pole) / R) - line.offset_mm));
      }
  EXPECT_LT(worst, options.tolerance_mm);
  EXPECT_GT(worst, 1e-9);  // and it is measured between nodes
}

// An annulus of radii 200 and 300 under closed courses: whole turns, and none where the edge lies outside by the rule.
TEST(Tows, OnAnAnnulusAreWholeTurns) {
  Part part = make_rectangular_part(Surface::plane({}), {0, 1}, {0, 1});
  part.faces[0].loops = {circle_loop({0, 0}, 300, false, 0), circle_loop({0, 0}, 200, true, 1)};
  const Skin skin(std::make_shared<const Part>(part), {0});
  const std::vector<LevelCurve> levels = {{0, {arc_curve({0, 0}, 250, 0.3, 2 * pi, true)}}};
  // Eleven tows of 10 mm from 195 to 305: with 0 % the outermost are left out, with 100 % they stay.
  const LaidTows none = lay(skin, levels, 11, 10, bare_rule(0)), full = lay(skin, levels, 11, 10, bare_rule(1));
  EXPECT_EQ(none.pieces.size(), 9u);
  EXPECT_EQ(full.pieces.size(), 11u);
  for (const TowPiece& piece : full.pieces) {
    EXPECT_TRUE(piece.closed);
    const double r = 250 - (6 - piece.tow) * 10;  // left is inwards
    // Cubics every 16 mm about r = 200: a length error of (16 / 200)^4 / 720 of it at most.
    EXPECT_NEAR(piece.length_mm(), 2 * pi * r, 2 * pi * r * 6e-8 + 2e-4) << piece.tow;
  }
}

// Over the edge of two faces of one plane tows go on as if it were not there.
TEST(Tows, GoOnOverASharedEdge) {
  Part part = make_rectangular_part(Surface::plane({}), {0, 2000}, {0, 300});
  RectangularFace second =
      make_rectangular_face(Surface::plane({}), {0, 2000}, {300, 600}, static_cast<int>(part.edges.size()));
  part.edges.insert(part.edges.end(), second.edges.begin(), second.edges.end());
  second.face.loops[0].coedges[0].edge = part.faces[0].loops[0].coedges[2].edge;
  part.faces.push_back(std::move(second.face));
  const Skin skin(std::make_shared<const Part>(part), {0, 1});
  const double a = 30 * pi / 180;
  const Uv along(std::cos(a), std::sin(a)), middle(1000, 300);
  SurfaceCurve curve = straight_uv(middle - 600 * along, middle, 600);
  SurfaceCurve beyond = straight_uv(middle, middle + 600 * along, 600);
  for (CurveNode& node : beyond.pieces[0]) {
    node.t += 600;
    node.at.face = 1;
  }
  curve.pieces.push_back(beyond.pieces[0]);
  const LaidTows tows = lay(skin, {{0, {curve}}}, 8, d, bare_rule(0.5));
  ASSERT_EQ(tows.pieces.size(), 8u);
  for (const TowPiece& piece : tows.pieces) {
    EXPECT_NEAR(piece.length_mm(), 1200, 1e-6) << piece.tow;  // from the lower side to the upper
  }
}

}  // namespace
}  // namespace afptraj
