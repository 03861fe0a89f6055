#include "geometry/surface_curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "geometry/closest_point.h"
#include "geometry/curvature.h"
#include "tests/specimens.h"

namespace afptraj {
namespace {

/// A curve of space that lies on the skin, by arc length: point, unit tangent, geodesic curvature.
struct KnownCurve {
  double length = 0;
  std::function<Vec3(double)> point, tangent;
  double kg = 0;
};

/// Nodes at equal arc lengths; `seed` leads Newton to the parameters. `breaks`: where a new piece begins.
SurfaceCurve sampled(const Skin& skin, const KnownCurve& known, int spans, Uv seed,
                     const std::vector<double>& breaks = {}) {
  const Surface& surface = skin.face(0).surface;
  SurfaceCurve curve;
  std::vector<double> ends = breaks;
  ends.push_back(known.length);
  double s0 = 0;
  for (const double s1 : ends) {
    auto& piece = curve.pieces.emplace_back();
    for (int i = 0; i <= spans; ++i) {
      CurveNode node;
      node.t = s0 + (s1 - s0) * i / spans;
      node.at = {0, *foot_point(surface, known.point(node.t), seed)};
      seed = node.at.uv;
      // On a break the derivatives are those of the piece's own side.
      const Uv inward =
          i == 0 ? Uv(*foot_point(surface, known.point(node.t + 1e-3 * (s1 - s0)), seed) - seed)
                 : Uv(i == spans && !piece.empty() ? Uv(piece.back().at.uv - seed) : Uv(Uv::Zero()));
      const SurfaceDerivatives d = surface.derivatives(surface.span_at(seed, inward), seed);
      node.duv = tangent_to_uv(d, known.tangent(node.t));
      node.kg_per_mm = known.kg;
      piece.push_back(node);
    }
    s0 = s1;
  }
  return curve;
}

/// Greatest distance between the curve and the known one at equal parameters, and of the lengths.
struct Errors {
  double position = 0, tangent = 0, length = 0;
};
Errors errors_of(const Skin& skin, const KnownCurve& known, const SurfaceCurve& curve) {
  Errors out;
  double length = 0;
  for (const auto& piece : curve.pieces)
    for (std::size_t i = 0; i + 1 < piece.size(); ++i) {
      for (const double x : {0.1, 0.3, 0.5, 0.7, 0.9}) {
        const CurveFrame f = frame_at(skin, piece, i, x);
        const double t = piece[i].t + x * (piece[i + 1].t - piece[i].t);
        out.position = std::max(out.position, (f.frame.position - known.point(t)).norm());
        out.tangent = std::max(out.tangent, (f.frame.tangent - known.tangent(t)).norm());
      }
      length += arc_length(skin, piece, i, 0, 1);
    }
  out.length = std::abs(length - known.length);
  return out;
}

/// Halving the spacing divides the error by 16, that of tangents by 8; 3.8 and 2.8 leave room for the next
/// term of the expansion.
void expect_fourth_order(const Skin& skin, const KnownCurve& known, const Uv& seed, int spans,
                         const std::vector<double>& breaks = {}) {
  const Errors coarse = errors_of(skin, known, sampled(skin, known, spans, seed, breaks));
  const Errors fine = errors_of(skin, known, sampled(skin, known, 2 * spans, seed, breaks));
  EXPECT_GT(std::log2(coarse.position / fine.position), 3.8) << coarse.position << " " << fine.position;
  EXPECT_LT(std::log2(coarse.position / fine.position), 4.2) << coarse.position << " " << fine.position;
  EXPECT_GT(std::log2(coarse.tangent / fine.tangent), 2.8) << coarse.tangent << " " << fine.tangent;
  EXPECT_GT(fine.position, 1e-11);  // above rounding, or nothing was measured
  // The nodes are exact, so the length is off by the square of the tangent's error and, where the curve
  // turns in the surface, by kappa_g times the offset; rounding of a sum of a metre stands beside it.
  const double turn = std::abs(known.kg);
  for (const Errors& e : {coarse, fine})
    EXPECT_LT(e.length, known.length * (e.tangent * e.tangent + turn * e.position) + 1e-11);
  if (turn > 0) {
    EXPECT_GT(std::log2(coarse.length / fine.length), 3.8) << coarse.length << " " << fine.length;
  }
}

/// A small circle of a sphere about a tilted axis: in longitude and latitude far from a polynomial.
KnownCurve small_circle(double R, const Vec3& axis, double colatitude, double turn) {
  const Vec3 z = axis.normalized(), x = z.unitOrthogonal(), y = z.cross(x);
  const double r = R * std::sin(colatitude), h = R * std::cos(colatitude);
  KnownCurve c;
  c.length = turn * r;
  c.point = [=](double s) { return Vec3(h * z + r * (std::cos(s / r) * x + std::sin(s / r) * y)); };
  c.tangent = [=](double s) { return Vec3(-std::sin(s / r) * x + std::cos(s / r) * y); };
  c.kg = 1 / (R * std::tan(colatitude));  // turns left, about its axis
  return c;
}

TEST(SurfaceCurve, IsOfFourthOrderOnATiltedCircleOfASphere) {
  const Skin skin = make_skin(Surface::sphere({}, 300), {0, 2 * pi}, {-pi / 2, pi / 2});
  const KnownCurve circle = small_circle(300, Vec3(0.9, 0.2, 0.3), 0.6, 2 * pi);
  const Vec3 start = circle.point(0);
  expect_fourth_order(skin, circle, Uv(std::atan2(start.y(), start.x()), std::asin(start.z() / 300)), 100);
}

/// A helix on a cylinder whose parameter u is a rational function of the angle: distorted, and only
/// continuous where the arcs join, so a piece ends there.
TEST(SurfaceCurve, IsOfFourthOrderOnAHelixInARationalParametrisation) {
  const double R = 350, pitch = 0.7;
  const Skin skin = make_skin(nurbs_cylinder(R, 1000), {0, 4}, {0, 1});
  const double c = std::cos(pitch), s = std::sin(pitch);
  KnownCurve helix;
  helix.length = 1.2 * R / c;  // 1.2 rad round, over the join at 90 degrees
  const double a0 = 0.9;
  helix.point = [=](double t) {
    const double a = a0 + t * c / R;
    return Vec3(R * std::cos(a), R * std::sin(a), 20 + t * s);
  };
  helix.tangent = [=](double t) {
    const double a = a0 + t * c / R;
    return Vec3(-c * std::sin(a), c * std::cos(a), s);
  };
  expect_fourth_order(skin, helix, Uv(0.6, 0.02), 20, {(pi / 2 - a0) * R / c});
}

/// Frames: on a skin with its face turned round, and with the carried normal's sign, the normal follows.
TEST(SurfaceCurve, CarriesTheNormalOfTheFaceWithItsSign) {
  Part part = make_rectangular_part(Surface::sphere({}, 300), {0, 2 * pi}, {-pi / 2, pi / 2});
  const KnownCurve circle = small_circle(300, Vec3(0.9, 0.2, 0.3), 0.6, pi);
  for (const bool reversed : {false, true})
    for (const int sign : {1, -1}) {
      part.faces[0].reversed = reversed;
      const Skin skin(std::make_shared<const Part>(part), {0});
      const Vec3 start = circle.point(0);
      SurfaceCurve curve =
          sampled(skin, circle, 50, Uv(std::atan2(start.y(), start.x()), std::asin(start.z() / 300)));
      for (CurveNode& node : curve.pieces[0]) node.normal_sign = sign;
      const CurveFrame f = frame_at(skin, curve, 100);
      const Vec3 outward = f.frame.position / 300;
      EXPECT_NEAR(f.frame.normal.dot(outward), reversed ? -sign : sign, 1e-12);
      EXPECT_NEAR(f.frame.tangent.dot(f.frame.normal), 0, 1e-12);
      EXPECT_LT((frame_at(skin, curve, 1e9).frame.position - circle.point(circle.length)).norm(), 1e-9);
    }
}

GeodesicTracer exact_tracer(const Skin& skin) {
  GeodesicOptions o;
  o.tolerance_mm = 1e-12;
  return GeodesicTracer(skin, o);
}

// On a sphere the distance from a small circle is R times the difference of colatitudes, positive to the
// left, inside of a circle that turns left. At equal distances left and right the answers are
// symmetrical. The curve's own error is that of its cubics: h^4 / 384 times its fourth derivative.
TEST(SurfaceCurve, FindsTheGeodesicFootOnBothSides) {
  const double R = 300, colatitude = 0.6;
  const Skin skin = make_skin(Surface::sphere({}, R), {0, 2 * pi}, {-pi / 2, pi / 2});
  const Vec3 axis = Vec3(0.9, 0.2, 0.3).normalized();
  const KnownCurve circle = small_circle(R, axis, colatitude, 2 * pi);
  const Vec3 start = circle.point(0);
  const SurfaceCurve curve =
      sampled(skin, circle, 800, Uv(std::atan2(start.y(), start.x()), std::asin(start.z() / R)));
  const double curve_error = errors_of(skin, circle, curve).position;
  ASSERT_LT(curve_error, 1e-7);
  const GeodesicTracer tracer = exact_tracer(skin);
  for (const double t : {123.4, 500.0, 900.0})
    for (const double distance : {-90.0, -1.0, 1e-3, 1.0, 50.0, 90.0}) {
      const Vec3 on = circle.point(t) / R, left = on.cross(circle.tangent(t));
      const Vec3 p = R * (std::cos(distance / R) * on + std::sin(distance / R) * left);
      // The seed is off by 20 mm.
      const auto foot = geodesic_foot(tracer, curve, t + 20, p);
      ASSERT_TRUE(foot) << t << " " << distance;
      EXPECT_NEAR(foot->distance_mm, distance, 1e-8 + curve_error);
      EXPECT_NEAR(foot->t, t, 1e-6);
      EXPECT_LE(foot->miss_mm, 1e-8);
    }
}

// R6: two great circles 50.8 apart where they are parallel; from one to the other at a right angle the
// distance is R asin(sin(50.8 / R) cos(s / R)).
TEST(SurfaceCurve, FeetOfTwoGeodesicsOnASphere) {
  const double R = 1000, apart = 50.8;
  const Skin skin = make_skin(Surface::sphere({}, R), {0, 2 * pi}, {-pi / 2, pi / 2});
  // The equator, whose cubics in (u, v) are exact.
  SurfaceCurve equator;
  auto& piece = equator.pieces.emplace_back();
  for (int i = 0; i <= 40; ++i) {
    CurveNode node;
    node.t = 50.0 * i;
    node.at = {0, Uv(1 + node.t / R, 0)};
    node.duv = Uv(1 / R, 0);
    piece.push_back(node);
  }
  const GeodesicTracer tracer = exact_tracer(skin);
  const double expected[] = {49.21945, 44.57678, 37.16236};
  for (int i = 0; i < 3; ++i) {
    const double s = 250 * (i + 1);
    // The other one leaves (latitude apart / R, longitude 1) eastwards.
    const Vec3 p0(std::cos(apart / R) * std::cos(1), std::cos(apart / R) * std::sin(1), std::sin(apart / R));
    const Vec3 p = R * (std::cos(s / R) * p0 + std::sin(s / R) * Vec3(-std::sin(1), std::cos(1), 0));
    const auto foot = geodesic_foot(tracer, equator, s, p);
    ASSERT_TRUE(foot);
    EXPECT_NEAR(foot->distance_mm, expected[i], 5e-6);  // five decimals are given
    EXPECT_NEAR(foot->distance_mm, R * std::asin(std::sin(apart / R) * std::cos(s / R)), 2e-8);
  }
}

// Where a ray from the curve ends, the foot is the ray's start, at its length; on a surface without any
// symmetry.
TEST(SurfaceCurve, TheFootOfARaysEndIsItsStart) {
  const Skin skin = make_bumpy_skin();
  const GeodesicTracer tracer = exact_tracer(skin);
  // A circle of the (u, v) plane, so that kg varies.
  SurfaceCurve curve;
  auto& piece = curve.pieces.emplace_back();
  const Surface& surface = skin.face(0).surface;
  for (int i = 0; i <= 200; ++i) {
    CurveNode node;
    const double a = 0.01 * i;
    node.t = 250 * a;
    node.at = {0, Uv(0.5 + 0.25 * std::cos(a), 0.4 + 0.25 * std::sin(a))};
    node.duv = Uv(-std::sin(a), std::cos(a)) / 1000;
    const SurfaceDerivatives d = surface.derivatives(node.at.uv);
    node.kg_per_mm = geodesic_curvature(d, unit_normal(d), node.duv, Uv(-std::cos(a), -std::sin(a)) / 250000);
    piece.push_back(node);
  }
  for (const double t : {60.0, 180.3, 333.0, 471.1})
    for (const double distance : {-40.0, 40.0}) {
      const CurveFrame from = frame_at(skin, curve, t);
      GeodesicState g = tracer.start(from.at, std::copysign(1.0, distance) * from.frame.left());
      ASSERT_EQ(tracer.advance(g, std::abs(distance)), TraceEnd::reached);
      const auto foot = geodesic_foot(tracer, curve, t + 8, skin.point(g.at), 1e-10);
      ASSERT_TRUE(foot) << t << " " << distance;
      EXPECT_NEAR(foot->distance_mm, distance, 1e-9);
      EXPECT_NEAR(foot->t, t, 1e-7);
    }
}

// Beyond the ends there is no foot, unless slack allows it.
TEST(SurfaceCurve, HasNoFootBeyondItsEnds) {
  const Skin skin = make_skin(Surface::plane({}), {0, 100}, {0, 100});
  SurfaceCurve line;
  for (const double t : {0.0, 25.0, 50.0}) {
    CurveNode node;
    node.t = t;
    node.at = {0, Uv(20 + t, 50)};
    node.duv = Uv(1, 0);
    if (line.empty()) line.pieces.emplace_back();
    line.pieces[0].push_back(node);
  }
  const GeodesicTracer tracer = exact_tracer(skin);
  EXPECT_TRUE(geodesic_foot(tracer, line, 20, Vec3(70, 60, 0)));
  EXPECT_FALSE(geodesic_foot(tracer, line, 20, Vec3(71, 60, 0)));
  EXPECT_FALSE(geodesic_foot(tracer, line, 20, Vec3(19, 40, 0)));
}

// Creases: inner knots of full multiplicity, periods included.
TEST(SurfaceCurve, SeesTheLinesWhereAParametrisationIsOnlyContinuous) {
  const Surface cylinder = nurbs_cylinder(350, 1000);
  const auto crossing = crease_between(cylinder, Uv(0.8, 0.3), Uv(1.6, 0.5));
  ASSERT_TRUE(crossing);
  EXPECT_EQ(crossing->axis, 0);
  EXPECT_NEAR(crossing->value, 1, 1e-12);
  EXPECT_NEAR(crossing->x, 0.25, 1e-12);
  EXPECT_FALSE(crease_between(cylinder, Uv(1.1, 0.3), Uv(1.9, 0.9)));
  EXPECT_FALSE(crease_between(cylinder, Uv(1, 0.3), Uv(2, 0.9)));  // ends do not count
  EXPECT_NEAR(crease_between(cylinder, Uv(5.1, 0.3), Uv(4.9, 0.3))->value, 5, 1e-12);
  EXPECT_TRUE(on_crease(cylinder, Uv(1, 0.77)));
  EXPECT_FALSE(on_crease(cylinder, Uv(1.001, 0.77)));
}

}  // namespace
}  // namespace afptraj
