#include "trajectory/parallels.h"

#include <gtest/gtest.h>

#include <cmath>

#include "boundary/clip.h"
#include "geometry/curvature.h"
#include "tests/specimens.h"
#include "tests/tow_specimens.h"
#include "trajectory/level_curve.h"
#include "trajectory/path_fit.h"

namespace afptraj {
namespace {

constexpr double W = 50.8;

/// A straight (u, v) segment as the reference, raised to a cubic so that any length is one piece.
std::shared_ptr<const SplinePath> uv_line(const Skin& skin, const Uv& a, const Uv& b, bool closed = false) {
  const SurfaceDerivatives d = skin.derivatives({0, 0.5 * (a + b)});
  const double length = uv_to_tangent(d, b - a).norm();
  return std::make_shared<const SplinePath>(
      skin, std::vector<SplinePath::Piece>{{{0, 1, nullptr}, line_segment(a, b, 0, length)}}, closed);
}

ParallelOptions options_for(const Skin& skin) {
  ParallelOptions o;
  o.front.spacing_mm = W;
  o.front.sample_mm = 4;
  o.geodesic.tolerance_mm = 1e-10;
  o.geodesic.outside_limit_mm = skin.diagonal();
  o.front.extension_margin_mm = W / 2;
  o.geodesic.margin_mm = 2 * W;
  return o;
}

template <typename Visit>
void for_each_midpoint(const Skin& skin, const SurfaceCurve& curve, Visit visit) {
  for (const auto& piece : curve.pieces)
    for (std::size_t i = 0; i + 1 < piece.size(); ++i) visit(frame_at(skin, piece, i, 0.5));
}

/// E_k: the greatest |distance to level k - W| over points of level k + 1 between samples whose
/// foot on the clipped level k is interior.
double spacing_error(const Skin& skin, const Parallels& parallels, int* checked = nullptr) {
  GeodesicOptions fine;
  fine.tolerance_mm = 1e-12;
  fine.outside_limit_mm = skin.diagonal();
  fine.margin_mm = W;
  const GeodesicTracer tracer(skin, fine);
  double worst = 0;
  for (const LevelCurve& level : parallels.levels) {
    if (level.number == 0) continue;
    const int parent = level.number > 0 ? level.number - 1 : level.number + 1;
    LaidCurves laid(skin, W);
    for (const LevelCurve& other : parallels.levels)
      if (other.number == parent)
        for (const SurfaceCurve& c : other.curves)
          for (SurfaceCurve& s : clip_to_skin(skin, c)) laid.add(std::move(s), parent);
    for (const SurfaceCurve& curve : level.curves)
      for (const SurfaceCurve& s : clip_to_skin(skin, curve))
        for_each_midpoint(skin, s, [&](const CurveFrame& f) {
          const auto near = laid.rival(tracer, f.frame.position, f.frame.normal, 1.02 * W, -1, 0, 0);
          if (!near) return;
          worst = std::max(worst, std::abs(std::abs(near->foot.distance_mm) - W));
          if (checked) ++*checked;
        });
  }
  return worst;
}

// R5, R11: on a sphere the parallels of the equator are circles of latitude k W / R, steering R / tan.
TEST(Parallels, OfTheEquatorAreCirclesOfLatitude) {
  const double R = 1000;
  const Skin skin = make_skin(Surface::sphere({}, R), {0, 2 * pi}, {-pi / 2, pi / 2});
  const Parallels p =
      geodesic_parallels(skin, uv_line(skin, Uv(0, 0), Uv(2 * pi, 0), true), options_for(skin));
  // The pole lies pi R / 2 = 30.92 W away: 30 circles on each side.
  ASSERT_EQ(p.levels.size(), 61u);
  for (const LevelCurve& level : p.levels) {
    const double latitude = level.number * W / R;
    ASSERT_EQ(level.curves.size(), 1u) << level.number;
    EXPECT_TRUE(level.curves[0].closed);
    double length = 0;
    for (const auto& piece : level.curves[0].pieces)
      for (std::size_t i = 0; i + 1 < piece.size(); ++i) length += arc_length(skin, piece, i, 0, 1);
    EXPECT_NEAR(length, 2 * pi * R * std::cos(latitude), 1e-6) << level.number;
    for_each_midpoint(skin, level.curves[0], [&](const CurveFrame& f) {
      EXPECT_NEAR(R * std::asin(f.frame.position.z() / R), level.number * W, 1e-6);
      EXPECT_NEAR(f.kg_per_mm, std::tan(latitude) / R, 1e-9);
    });
  }
  const double steering = 1 / std::abs(p.levels[40].curves[0].pieces[0][5].kg_per_mm);
  EXPECT_NEAR(steering, 1796.184, 5e-4);  // 508 mm from the equator, cases.md R5
}

// R1: cylinder R 350, L 1000, courses at 45 degrees: helices; 30.6104 bands go round.
TEST(Parallels, OfAHelixAreHelicesAndMeetBehind) {
  const double R = 350, L = 1000;
  const Skin skin = make_skin(Surface::cylinder({}, R), {0, 2 * pi}, {0, L});
  const double turn = L / R;  // 45 degrees
  const auto helix = std::make_shared<const SplinePath>(
      skin,
      std::vector<SplinePath::Piece>{
          {{0, 1, nullptr}, line_segment(Uv(1, 0), Uv(1 + turn, L), 0, L * std::sqrt(2.0))}},
      false);
  const Parallels p = geodesic_parallels(skin, helix, options_for(skin));
  int left = 0, right = 0;
  for (const LevelCurve& level : p.levels) {
    double length = 0;
    for (const SurfaceCurve& curve : level.curves)
      for (const SurfaceCurve& s : clip_to_skin(skin, curve)) {
        for (const auto& piece : s.pieces)
          for (std::size_t i = 0; i + 1 < piece.size(); ++i) length += arc_length(skin, piece, i, 0, 1);
        for_each_midpoint(skin, s, [&](const CurveFrame& f) {
          EXPECT_NEAR(f.frame.tangent.z(), std::sqrt(0.5), 1e-8);
          // Helices at 45 degrees: phi R - z is constant along each, and grows by W sqrt 2 a course.
          const double phase =
              f.frame.position.z() - R * std::atan2(f.frame.position.y(), f.frame.position.x()) + R;
          const double off = std::remainder(phase - level.number * W * std::sqrt(2.0), 2 * pi * R);
          EXPECT_NEAR(off, 0, 1e-6) << level.number;
        });
      }
    if (length == 0) continue;  // beyond the rims only
    left = std::max(left, level.number);
    right = std::max(right, -level.number);
    EXPECT_NEAR(length, L * std::sqrt(2.0), 1e-6) << level.number;
  }
  // 2 pi R / (W sqrt 2) = 30.6104 bands: the fronts meet at 15.305 W, so 15 on each side.
  EXPECT_EQ(left, 15);
  EXPECT_EQ(right, 15);
}

// Offsets of a line on developables are lines; the corner that no ray reaches is filled by the
// extension of each course, at the same spacing.
TEST(Parallels, FillTheCornersOfAPlate) {
  const Skin skin = make_skin(Surface::plane({}), {0, 1000}, {0, 600});
  const auto line = uv_line(skin, Uv(300, 0), Uv(900, 600));
  for (const double outside : {0.0, skin.diagonal()}) {  // with and without the extended plane
    ParallelOptions o = options_for(skin);
    o.geodesic.outside_limit_mm = outside;
    const Parallels p = geodesic_parallels(skin, line, o);
    double total = 0;
    for (const LevelCurve& level : p.levels)
      for (const SurfaceCurve& curve : level.curves)
        for (const SurfaceCurve& s : clip_to_skin(skin, curve)) {
          for_each_midpoint(skin, s, [&](const CurveFrame& f) {
            const Vec3& x = f.frame.position;
            EXPECT_NEAR((x.y() - x.x() + 300) / std::sqrt(2.0), level.number * W, 1e-7);
          });
          for (const auto& piece : s.pieces)
            for (std::size_t i = 0; i + 1 < piece.size(); ++i) total += arc_length(skin, piece, i, 0, 1);
        }
    // Every 45 degree line of the rectangle at the spacing W: lengths in closed form.
    double expected = 0;
    for (int k = -20; k <= 20; ++k) {
      const double c = k * W * std::sqrt(2.0) - 300;  // y = x + c
      const double x0 = std::max(0.0, -c), x1 = std::min(1000.0, 600 - c);
      if (x1 > x0) expected += (x1 - x0) * std::sqrt(2.0);
    }
    EXPECT_NEAR(total, expected, 1e-5) << outside;
  }
}

TEST(Parallels, KeepTheirDistanceOnAGentlePanel) {
  const Skin skin = make_skin(gentle_surface(), {0, 1}, {0, 1});
  const Parallels p = geodesic_parallels(skin, uv_line(skin, Uv(0.25, 0), Uv(0.8, 1)), options_for(skin));
  int checked = 0;
  EXPECT_LT(spacing_error(skin, p, &checked), 1e-4);
  EXPECT_GT(checked, 2000);
}

// Fronts fold here: each must end where it meets another, and what is left keeps its distance.
TEST(Parallels, FollowTheTrueDistanceWhereFrontsFold) {
  const Skin skin = make_bumpy_skin();
  const Parallels p = geodesic_parallels(skin, uv_line(skin, Uv(0, 0.5), Uv(1, 0.45)), options_for(skin));
  int checked = 0;
  EXPECT_LT(spacing_error(skin, p, &checked), 1e-3);
  EXPECT_GT(checked, 2000);
}

/// A front ends inside the skin only where it meets another: both end at one point. Returns how many ends lie
/// inside.
int expect_ends_inside_in_pairs(const Skin& skin, const Parallels& parallels) {
  int count = 0;
  for (const LevelCurve& level : parallels.levels) {
    std::vector<Vec3> ends;
    for (const LevelCurve& other : parallels.levels)  // fronts of both sides may meet
      if (std::abs(other.number) == std::abs(level.number))
        for (const SurfaceCurve& curve : other.curves) {
          if (curve.closed) continue;
          for (const CurveNode* node : {&curve.pieces.front().front(), &curve.pieces.back().back()})
            if (skin.trim(node->at.face).contains(node->at.uv)) ends.push_back(skin.point(node->at));
        }
    for (std::size_t i = 0; i < ends.size(); ++i) {
      double nearest = 1e300;
      for (std::size_t j = 0; j < ends.size(); ++j)
        if (j != i) nearest = std::min(nearest, (ends[j] - ends[i]).norm());
      EXPECT_LT(nearest, 1e-6) << "course " << level.number << " ends at " << ends[i].transpose();
      ++count;
    }
  }
  return count;
}

// To the solver's accuracy.
TEST(Parallels, EndInsideOnlyInPairs) {
  const Skin bumpy = make_bumpy_skin();
  const Skin tube = make_skin(Surface::cylinder({}, 350), {0, 2 * pi}, {0, 1000});
  const double turn = 1000.0 / 350;
  const auto helix = std::make_shared<const SplinePath>(
      tube,
      std::vector<SplinePath::Piece>{
          {{0, 1, nullptr}, line_segment(Uv(1, 0), Uv(1 + turn, 1000), 0, 1000 * std::sqrt(2.0))}},
      false);
  int ends = expect_ends_inside_in_pairs(
      bumpy, geodesic_parallels(bumpy, uv_line(bumpy, Uv(0, 0.5), Uv(1, 0.45)), options_for(bumpy)));
  ends += expect_ends_inside_in_pairs(tube, geodesic_parallels(tube, helix, options_for(tube)));
  EXPECT_GT(ends, 10);
}

// The parallels of a closed path do not depend on where it starts: not on a crease of the surface either,
// where the corners that waves fold into cut the level apart at the joint. Total lengths of every level
// agree.
TEST(Parallels, OfAClosedPathKnowNoStart) {
  const Skin skin = make_skin(nurbs_cylinder(350, 1500), {0, 4}, {0, 1});
  std::vector<double> lengths[2];
  for (const int start : {0, 137}) {
    // 60 mm waves of a third of the way round: the radius of 227 mm folds beyond level 4.
    constexpr int n = 1100;
    SteppedPath path;
    path.closed = true;
    for (int i = 0; i <= n; ++i) {
      const double a = 2 * pi * ((start + i) % n) / n;
      const Vec3 p(350 * std::cos(a), 350 * std::sin(a), 750 + 60 * std::cos(3 * a));
      SteppedPoint point;
      point.at = skin.closest_point().closest(p, 1)->at;
      if (i == n) point.at = path.points.front().at;
      point.position = skin.point(point.at);
      point.direction = Vec3(-350 * std::sin(a), 350 * std::cos(a), -180 * std::sin(3 * a)).normalized();
      point.s_mm = path.points.empty()
                       ? 0
                       : path.points.back().s_mm + (point.position - path.points.back().position).norm();
      path.points.push_back(point);
    }
    FitOptions fitting;
    fitting.fairness = 0;
    const Parallels parallels =
        geodesic_parallels(skin, fit_path(skin, path, fitting).path, options_for(skin));
    expect_ends_inside_in_pairs(skin, parallels);
    for (const LevelCurve& level : parallels.levels) {
      double sum = 0;
      for (const SurfaceCurve& curve : level.curves)
        for (const SurfaceCurve& clipped : clip_to_skin(skin, curve))
          for (const auto& piece : clipped.pieces)
            for (std::size_t i = 0; i + 1 < piece.size(); ++i)
              sum += arc_length(skin, {piece[i], piece[i + 1]}, 0, 0, 1);
      lengths[start > 0].push_back(sum);
    }
  }
  ASSERT_EQ(lengths[0].size(), lengths[1].size());
  // Two splines with other knots: 8 mm apart on waves of 733 mm they are off by 350^-4 60 8^4 / 384 or some
  // 1e-6, and steeply crossing corners move by no more than ten times that.
  for (std::size_t k = 0; k < lengths[0].size(); ++k) EXPECT_NEAR(lengths[0][k], lengths[1][k], 1e-3) << k;
}

// The parallel at d of a parabola of least radius r < d meets itself on the axis, (d^2 / r + r) / 2 above the
// apex, where the Jacobi field is 1 - (r / d)^2: it is cut there however young the swallowtail.
TEST(Parallels, MeetThemselvesJustBeyondAFocalPoint) {
  const Skin skin = make_skin(Surface::plane({}), {-300, 300}, {-100, 600});
  const double r = 200;
  for (const double d : {r + 0.2, r + 2.0}) {
    BSplineCurve2 parabola{2, {-300, -300, -300, 300, 300, 300}, {}, {}};
    parabola.poles = {Uv(-300, 300 * 300 / (2 * r)), Uv(0, -300 * 300 / (2 * r)),
                      Uv(300, 300 * 300 / (2 * r))};
    ParallelOptions options = options_for(skin);
    options.front.spacing_mm = d / 4;
    const Parallels p =
        geodesic_parallels(skin,
                           std::make_shared<const SplinePath>(
                               skin, std::vector<SplinePath::Piece>{{{0, 1, nullptr}, parabola}}, false),
                           options);
    expect_ends_inside_in_pairs(skin, p);
    const Vec3 meeting(0, 0.5 * (d * d / r + r), 0);
    int ends = 0;
    for (const LevelCurve& level : p.levels)
      if (level.number == 4)
        for (const SurfaceCurve& curve : level.curves)
          for (const CurveNode* node : {&curve.pieces.front().front(), &curve.pieces.back().back()})
            if ((skin.point(node->at) - meeting).norm() < 1e-6) ++ends;
    EXPECT_EQ(ends, 2) << d;
  }
}

/// A path that comes from `before` away to the origin of (u, v), turns there within a few mm, and goes on for
/// `after`; both legs are straight, or bent to the left by `bend` (1 / mm).
std::shared_ptr<const SplinePath> hairpin(const Skin& skin, const Uv& there, const Uv& back, double before,
                                          double after, double bend = 0) {
  BSplineCurve2 turn{3, {}, {}, {}};
  for (int i = 0; i < 3; ++i) turn.knots.push_back(-before);
  const int spans = 80;
  for (int i = 0; i <= spans; ++i) turn.knots.push_back(-before + (before + after) * i / spans);
  for (int i = 0; i < 3; ++i) turn.knots.push_back(after);
  for (std::size_t i = 0; i + 4 < turn.knots.size(); ++i) {
    const double s = (turn.knots[i + 1] + turn.knots[i + 2] + turn.knots[i + 3]) / 3;
    const Uv along = s < 0 ? there : back;
    turn.poles.emplace_back(s * along + 0.5 * bend * s * s * Uv(-along.y(), along.x()));
  }
  return std::make_shared<const SplinePath>(skin, std::vector<SplinePath::Piece>{{{0, 1, nullptr}, turn}},
                                            false);
}

/// How many ends of level 1 lie at a place.
int ends_of_level_one_at(const Skin& skin, const Parallels& p, const Vec3& place) {
  int ends = 0;
  for (const LevelCurve& level : p.levels)
    if (level.number == 1)
      for (const SurfaceCurve& curve : level.curves)
        for (const CurveNode* node : {&curve.pieces.front().front(), &curve.pieces.back().back()})
          if ((skin.point(node->at) - place).norm() < 1e-6) ++ends;
  return ends;
}

// A course that comes back from a tight turn by 120 degrees ends at the edge so soon that the turn sweeps all
// that its own rays reach: the next course must end where the continuation of that one crosses it, not
// beyond.
TEST(Parallels, EndWhereACourseThatLeftTheSkinGoesOn) {
  const Skin skin = make_skin(Surface::plane({}), {-6 * W, 2 * W}, {-2 * W, 1.1 * W});
  const Uv back(-0.5, std::sqrt(0.75));
  ParallelOptions options = options_for(skin);
  options.geodesic.outside_limit_mm = 0;
  options.geodesic.margin_mm = options.front.extension_margin_mm = 8;
  const Parallels p =
      geodesic_parallels(skin, hairpin(skin, Uv::UnitX(), back, 6 * W, 1.1 * W / back.y()), options);
  expect_ends_inside_in_pairs(skin, p);
  const Vec3 meeting(-std::sqrt(3.0) * W, W, 0);  // W from both straight lines
  EXPECT_EQ(ends_of_level_one_at(skin, p, meeting), 2);
}

/// The place in (u, v) where two ends of level 1 meet.
std::optional<Uv> meeting_of_level_one(const Skin& skin, const Parallels& p) {
  std::vector<SurfacePoint> ends;
  for (const LevelCurve& level : p.levels)
    if (level.number == 1)
      for (const SurfaceCurve& curve : level.curves)
        for (const CurveNode* node : {&curve.pieces.front().front(), &curve.pieces.back().back()}) {
          for (const SurfacePoint& other : ends)
            if ((skin.point(other) - skin.point(node->at)).norm() < 1e-6) return node->at.uv;
          ends.push_back(node->at);
        }
  return std::nullopt;
}

// A plate folded back by 150 degrees is isometric to the flat one: fronts meet where they do there, however
// close to the fold that is and on whichever side. The legs are bent, so that chords do not tell the place.
TEST(Parallels, MeetBesideASharpFold) {
  const double lo = -8 * W, hi = 8 * W, folded = 150 * pi / 180;
  const auto parallels = [&](const Skin& skin) {
    ParallelOptions options = options_for(skin);
    options.max_levels = 1;
    options.front.sample_mm = 16;
    return geodesic_parallels(skin, hairpin(skin, Uv(0.98, 0.2), Uv(-0.66, 0.75), 6 * W, 6 * W, -1 / (4 * W)),
                              options);
  };
  const Skin flat = make_skin(Surface::plane({}), {lo, hi}, {lo, hi});
  const auto meeting = meeting_of_level_one(flat, parallels(flat));
  ASSERT_TRUE(meeting);
  for (const double beside : {-0.3, -0.03, -0.003, 0.003, 0.03, 0.3}) {
    const double fold = meeting->y() + beside;
    BSplineSurface s;
    s.degree_u = s.degree_v = 1;
    s.knots_u = {lo, lo, hi, hi};
    s.knots_v = {lo, lo, fold, hi, hi};
    for (const double x : {lo, hi}) {
      s.poles.emplace_back(x, lo, 0);
      s.poles.emplace_back(x, fold, 0);
      s.poles.emplace_back(x, fold + (hi - fold) * std::cos(folded), (hi - fold) * std::sin(folded));
    }
    const Skin skin = make_skin(Surface::bspline(s), {lo, hi}, {lo, hi});
    const auto there = meeting_of_level_one(skin, parallels(skin));
    ASSERT_TRUE(there) << beside;
    EXPECT_LT((*there - *meeting).norm(), 1e-6) << beside;
  }
}

// A cell whose derivatives belong to a parameter 50 times too long makes a loop of 14 times its chord.
TEST(Parallels, LevelCurvesDoNotLoop) {
  const Skin skin = make_skin(Surface::plane({}), {-10, 10}, {-10, 10});
  const auto node = [](double t, double x, double speed) {
    return CurveNode{t, {0, Uv(x, 0)}, Uv(speed, 0)};
  };
  const SurfaceCurve curve{{{node(0, 0, 1), node(2, 2, 1), node(2.01, 2.01, 50), node(4, 4, 1)}}, false};
  const auto length = [&](const SurfaceCurve& c) {
    double sum = 0;
    for (const auto& piece : c.pieces)
      for (std::size_t i = 0; i + 1 < piece.size(); ++i) sum += arc_length(skin, piece, i, 0, 1);
    return sum;
  };
  EXPECT_GT(length(curve), 20);
  EXPECT_NEAR(length(without_loops(skin, curve)), 4, 1e-9);
}

// A plate that steps down beside the start of the reference: course 1 goes on over the step, where the
// reference itself has left the plate. What lies below is reached from there, from the other side of course 1
// than its parallels lie on.
TEST(Parallels, ReachWhatLiesBehindAnExtension) {
  Part part = make_rectangular_part(Surface::plane({}), {-6 * W, 6 * W}, {-4 * W, 4 * W});
  part.faces[0].loops = {polygon_loop({{0, 0},
                                       {6 * W, 0},
                                       {6 * W, 4 * W},
                                       {-6 * W, 4 * W},
                                       {-6 * W, -4 * W},
                                       {-W, -4 * W},
                                       {-W, 0.2 * W},
                                       {0, 0.2 * W}},
                                      0)};
  const Skin skin(std::make_shared<const Part>(part), {0});
  ParallelOptions options = options_for(skin);
  options.geodesic.outside_limit_mm = options.geodesic.margin_mm = options.front.extension_margin_mm = 8;
  const Parallels p = geodesic_parallels(skin, uv_line(skin, Uv(0, 0.1 * W), Uv(6 * W, 0.1 * W)), options);
  expect_ends_inside_in_pairs(skin, p);
  // Courses W apart leave no place farther than W from all of them, corners where fronts meet included.
  double farthest = 0;
  for (double x = -5.9 * W; x < 6 * W; x += 0.2 * W)
    for (double y = -3.9 * W; y < 4 * W; y += 0.2 * W) {
      if (!skin.trim(0).contains(Uv(x, y))) continue;
      double least = 1e300;
      for (const LevelCurve& level : p.levels)
        for (const SurfaceCurve& curve : level.curves)
          for (const auto& piece : curve.pieces)
            for (const CurveNode& node : piece) least = std::min(least, (node.at.uv - Uv(x, y)).norm());
      farthest = std::max(farthest, least);
    }
  EXPECT_LE(farthest, W);
}

/// 0.4 x 0.6 m, flat but for a lip of 0.01 mm that stands up on the edge v = 0: there the parametrisation is
/// a hundred times slower than a few millimetres away and turns by a right angle, as at the lip of a nacelle.
Surface lipped_surface() {
  BSplineSurface s;
  s.degree_u = 1;
  s.knots_u = {0, 0, 1, 1};
  s.degree_v = 3;
  s.knots_v = uniform_knots(3, 5);
  for (const double x : {0.0, 400.0}) {
    s.poles.emplace_back(x, 0, -0.01);
    for (const double y : {0.0, 100.0, 300.0, 600.0}) s.poles.emplace_back(x, y, 0);
  }
  return Surface::bspline(s);
}

// Where the parametrisation changes its speed within a sample, rays are added until the cubic between them
// follows.
TEST(Parallels, FollowASurfaceThatNearlyShrinksToItsEdge) {
  const Skin skin = make_skin(lipped_surface(), {0, 1}, {0, 1});
  ParallelOptions options = options_for(skin);
  options.front.sample_mm = 3;
  const Parallels p = geodesic_parallels(skin, uv_line(skin, Uv(0.3, 0), Uv(0.8, 1)), options);
  int counted = 0;
  for (const LevelCurve& level : p.levels)
    for (const SurfaceCurve& curve : level.curves)
      for (const SurfaceCurve& s : clip_to_skin(skin, curve))
        for (const auto& piece : s.pieces)
          for (std::size_t i = 0; i + 1 < piece.size(); ++i) {
            const double chord = (skin.point(piece[i].at) - skin.point(piece[i + 1].at)).norm();
            EXPECT_LT(arc_length(skin, piece, i, 0, 1), 1.05 * chord + 1e-4) << level.number;
            ++counted;
          }
  EXPECT_GT(counted, 500);
}

// Round an edge of 0.3 mm radius the rays stand as close as the curve turns, whatever the sampling.
TEST(Parallels, KeepTheirDistanceRoundASharpEdge) {
  BSplineSurface s;
  s.degree_u = 1;
  s.knots_u = {0, 0, 1, 1};
  s.degree_v = 3;
  s.knots_v = uniform_knots(3, 7);
  const double y[] = {0, 100, 199.6, 200, 200.4, 300, 400}, z[] = {0, 60, 119.7, 120, 119.7, 60, 0};
  for (const double x : {0.0, 600.0})
    for (int j = 0; j < 7; ++j) s.poles.emplace_back(x, y[j], z[j]);
  const Skin skin = make_skin(Surface::bspline(s), {0, 1}, {0, 1});
  ParallelOptions options = options_for(skin);
  options.front.sample_mm = 20;
  const Parallels p = geodesic_parallels(skin, uv_line(skin, Uv(0, 0.05), Uv(1, 0.2)), options);
  int checked = 0;
  EXPECT_LT(spacing_error(skin, p, &checked), 1e-4);
  EXPECT_GT(checked, 200);
}

}  // namespace
}  // namespace afptraj
