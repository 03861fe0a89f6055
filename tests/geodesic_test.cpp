#include "geometry/geodesic.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "geometry/curvature.h"
#include "geometry/dormand_prince.h"
#include "tests/specimens.h"

namespace afptraj {
namespace {

GeodesicOptions fine() {
  GeodesicOptions o;
  o.tolerance_mm = 1e-11;  // the global error over 1 m was at most 6 times this
  return o;
}

// (G1) The cylinder's geodesics are helices. R1: R 350, 45 degrees.
TEST(Geodesic, IsAHelixOnACylinder) {
  const Skin skin = make_skin(Surface::cylinder({}, 350), {0, 2 * pi}, {-1000, 1000});
  const GeodesicTracer tracer(skin, fine());
  const double a = pi / 4;
  const SurfacePoint start{0, Uv(1.0, -500)};
  const SurfaceDerivatives d = skin.derivatives(start);
  GeodesicState g = tracer.start(start, std::sin(a) * d.Su.normalized() + std::cos(a) * d.Sv);
  ASSERT_EQ(tracer.advance(g, 1000), TraceEnd::reached);
  const double turn = 1.0 + 1000 * std::sin(a) / 350, z = -500 + 1000 * std::cos(a);
  EXPECT_LT((skin.point(g.at) - Vec3(350 * std::cos(turn), 350 * std::sin(turn), z)).norm(), 1e-9);
  EXPECT_NEAR(g.y, 1, 1e-12);  // (G4) developable
}

// (G1) R3: cone of half angle 20 degrees from r = 200 to 500 starting at 45 degrees.
TEST(Geodesic, IsAStraightLineOfTheUnrolledCone) {
  const double half = 20 * pi / 180;
  const Skin skin = make_skin(Surface::cone({}, 200, half), {0, 2 * pi}, {-100, 1200});
  const GeodesicTracer tracer(skin, fine());
  const SurfacePoint start{0, Uv(0.5, 0)};
  const SurfaceDerivatives d = skin.derivatives(start);
  GeodesicState g = tracer.start(start, (d.Su.normalized() + d.Sv).normalized());
  ASSERT_EQ(tracer.advance(g, 988.7189), TraceEnd::reached);
  const Vec3 end = skin.point(g.at);
  // The reference length has 4 decimals: the radius it reaches is 500 to 1e-4 * sin(20 deg).
  EXPECT_NEAR(std::hypot(end.x(), end.y()), 500, 5e-5);
  EXPECT_NEAR((g.at.uv.x() - 0.5) * 180 / pi, 83.533267, 1e-5);
  // Clairaut exactly: r sin(alpha) is constant.
  const SurfaceDerivatives e = skin.derivatives(g.at);
  const double sine = uv_to_tangent(e, g.duv).dot(e.Su.normalized());
  EXPECT_NEAR(std::hypot(end.x(), end.y()) * sine, 200 * std::sin(pi / 4), 1e-8);
}

// (G1, G4) Great circles, over the seam and close to the pole; y = cos(s / R).
TEST(Geodesic, IsAGreatCircleOnASphere) {
  const double R = 300;
  const Skin skin = make_skin(Surface::sphere({}, R), {0, 2 * pi}, {-pi / 2, pi / 2});
  const GeodesicTracer tracer(skin, fine());
  for (const double tilt : {0.3, 1.2, 1.5, 1.57}) {  // 1.57: passes the pole at 0.24 mm
    const SurfacePoint start{0, Uv(3.0, 0.0)};
    const SurfaceDerivatives d = skin.derivatives(start);
    const Vec3 n = d.S / R;
    const Vec3 t = std::cos(tilt) * d.Su.normalized() + std::sin(tilt) * d.Sv.normalized();
    GeodesicState g = tracer.start(start, t);
    ASSERT_EQ(tracer.advance(g, 1000), TraceEnd::reached) << tilt;
    const Vec3 expected = R * (std::cos(1000 / R) * n + std::sin(1000 / R) * t);
    EXPECT_LT((skin.point(g.at) - expected).norm(), 1e-9) << tilt;
    EXPECT_NEAR(g.y, std::cos(1000 / R), 1e-9) << tilt;
  }
}

TEST(Geodesic, CrossesASmoothPoleAndEndsAtAnApex) {
  const double R = 300;
  const Skin dome = make_skin(Surface::sphere({}, R), {0, 2 * pi}, {-pi / 2, pi / 2});
  const GeodesicTracer tracer(dome, fine());
  const SurfacePoint start{0, Uv(1.0, 1.0)};
  const SurfaceDerivatives d = dome.derivatives(start);
  GeodesicState g = tracer.start(start, d.Sv);
  ASSERT_EQ(tracer.advance(g, 400), TraceEnd::reached);
  const double latitude = pi - (1.0 + 400 / R);  // down the other side
  const Vec3 expected(-R * std::cos(latitude) * std::cos(1.0), -R * std::cos(latitude) * std::sin(1.0),
                      R * std::sin(latitude));
  EXPECT_LT((dome.point(g.at) - expected).norm(), 1e-8);

  const Skin cone = make_skin(Surface::cone({}, 100, 0.5), {0, 2 * pi}, {-100 / std::sin(0.5), 500});
  const GeodesicTracer on_cone(cone, fine());
  const SurfacePoint rim{0, Uv(1.0, 300)};
  GeodesicState h = on_cone.start(rim, -cone.derivatives(rim).Sv);
  EXPECT_EQ(on_cone.advance(h, 600), TraceEnd::singular);
}

// (G1) Clairaut on the torus, many turns; R10: from the outer equator the hole is crossed only
// below 41.810315 degrees from the meridian.
TEST(Geodesic, KeepsClairautsConstantOnATorus) {
  const Skin skin = make_skin(Surface::torus({}, 1000, 200), {0, 2 * pi}, {0, 2 * pi});
  const GeodesicTracer tracer(skin, fine());
  for (const double degrees : {41.8, 41.82}) {
    const double a = degrees * pi / 180;
    const SurfacePoint start{0, Uv(0.1, 0)};
    const SurfaceDerivatives d = skin.derivatives(start);
    const double r0 = std::hypot(d.S.x(), d.S.y());
    GeodesicState g = tracer.start(start, std::sin(a) * d.Su.normalized() + std::cos(a) * d.Sv.normalized());
    double least = r0;
    for (int i = 0; i < 800; ++i) {
      ASSERT_EQ(tracer.advance(g, 5), TraceEnd::reached);
      const SurfaceDerivatives e = skin.derivatives(g.at);
      const double r = std::hypot(e.S.x(), e.S.y());
      least = std::min(least, r);
      EXPECT_NEAR(r * uv_to_tangent(e, g.duv).dot(e.Su.normalized()), r0 * std::sin(a), 2e-8);
    }
    // 41.82 degrees turn back at r = 1200 sin(41.82 deg) = 800.14; a sample misses r = 800 by < 0.02.
    EXPECT_EQ(least < 800.05, degrees < 41.81) << least;
  }
}

using State2 = std::array<double, 2>;

/// A pendulum of length 1 under unit gravity: nonlinear and smooth.
State2 pendulum(const State2& x) { return {x[1], -std::sin(x[0])}; }

double apart(const State2& a, const State2& b) { return std::hypot(a[0] - b[0], a[1] - b[1]); }

// (G2) The order of the formulas: fixed steps of half the length make the error 2^8 times smaller, and the
// estimates of one step, h E5 and h E3, 2^6 and 2^4 times.
TEST(DormandPrince, HasItsOrder) {
  const auto walk = [](int steps) {
    State2 x{1, 0.5};
    for (int i = 0; i < steps; ++i) x = dop853::step(x, pendulum(x), 8.0 / steps, pendulum);
    return x;
  };
  const State2 truth = walk(200);
  for (const int steps : {8, 12, 16}) {
    const double gain = apart(walk(steps), truth) / apart(walk(2 * steps), truth);
    EXPECT_NEAR(std::log2(gain), 8, 1) << steps;
  }
  const State2 start{1, 0.5}, zero{};
  const auto estimates = [&](double h) {
    State2 e5, e3;
    dop853::step(start, pendulum(start), h, pendulum, &e5, &e3);
    return std::array{h * apart(e5, zero), h * apart(e3, zero)};
  };
  const auto [whole5, whole3] = estimates(0.4);
  const auto [half5, half3] = estimates(0.2);
  EXPECT_NEAR(std::log2(whole5 / half5), 6, 0.5);
  EXPECT_NEAR(std::log2(whole3 / half3), 4, 0.5);
  const auto short_error = [&](double h) {
    return apart(dop853::short_step(start, pendulum(start), h, pendulum),
                 dop853::step(start, pendulum(start), h, pendulum));
  };
  EXPECT_NEAR(std::log2(short_error(0.1) / short_error(0.05)), 5, 0.5);
}

// (G2) The estimate E5^2 / E3 of a step goes with h^8: steps are chosen by the eighth root of the tolerance.
TEST(Geodesic, ErrorFollowsTheTolerance) {
  const Skin skin = make_bumpy_skin();
  const SurfacePoint start{0, Uv(0.31, 0.22)};
  const auto end = [&](double tolerance) {
    GeodesicOptions o;
    o.tolerance_mm = tolerance;
    const GeodesicTracer tracer(skin, o);
    GeodesicState g = tracer.start(start, Vec3(0.6, 0.8, 0));
    EXPECT_EQ(tracer.advance(g, 400), TraceEnd::reached);
    return skin.point(g.at);
  };
  const Vec3 truth = end(1e-13);
  const double coarse = (end(1e-5) - truth).norm(), middle = (end(1e-8) - truth).norm();
  EXPECT_LT(coarse, 1e-3);
  EXPECT_LT(middle, 1e-6);
  EXPECT_LT(middle, coarse / 30);
  EXPECT_LT((end(1e-11) - truth).norm(), 1e-9);
}

// (G3) There and back, over many knot lines.
TEST(Geodesic, WalksBackToItsStart) {
  const Skin skin = make_bumpy_skin();
  const GeodesicTracer tracer(skin, fine());
  std::mt19937 rng(3);
  std::uniform_real_distribution<double> place(0.3, 0.7), angle(0, 2 * pi);
  for (int i = 0; i < 20; ++i) {
    const SurfacePoint start{0, Uv(place(rng), place(rng))};
    const double a = angle(rng);
    GeodesicState g = tracer.start(start, Vec3(std::cos(a), std::sin(a), 0));
    const PathFrame first = frame_of(skin, g);
    ASSERT_EQ(tracer.advance(g, 150), TraceEnd::reached);
    g.duv = -g.duv;
    ASSERT_EQ(tracer.advance(g, 150), TraceEnd::reached);
    const PathFrame last = frame_of(skin, g);
    EXPECT_LT((last.position - first.position).norm(), 1e-9);
    EXPECT_LT((last.tangent + first.tangent).norm(), 1e-10);
  }
}

// (G4) y is the distance of neighbouring rays: central differences, error O(h^2) = 1e-8 relative.
TEST(Geodesic, JacobiFieldIsTheDistanceOfNeighbours) {
  const Skin skin = make_bumpy_skin();
  const GeodesicTracer tracer(skin, fine());
  const double h = 1e-3;
  const auto ray = [&](double shift) {
    // From the straight (u, v) line v = 0.5, orthogonally; parametrised by u.
    const double u = 0.47 + shift;
    const SurfacePoint at{0, Uv(u, 0.5)};
    const SurfaceDerivatives d = skin.derivatives(at);
    const Vec3 n = unit_normal(d);
    const double kg = geodesic_curvature(d, n, Uv(1, 0), Uv(0, 0));
    GeodesicState g = tracer.start(at, n.cross(d.Su), 1, 1, -kg);
    EXPECT_EQ(tracer.advance(g, 220), TraceEnd::reached);
    return g;
  };
  const double du = h / 1000;
  const Vec3 a = skin.point(ray(-du).at), b = skin.point(ray(du).at);
  const double speed = skin.derivatives({0, Uv(0.47, 0.5)}).Su.norm();
  EXPECT_NEAR((b - a).norm() / (2 * du * speed), std::abs(ray(0).y), 1e-6);
}

// Knots of a B-spline cylinder: double knots where S_uu jumps by its own size.
TEST(Geodesic, CrossesKnotsWithJumpsOfTheSecondDerivative) {
  const Skin skin = make_skin(nurbs_cylinder(350, 1000), {0, 4}, {0, 1});
  const GeodesicTracer tracer(skin, fine());
  const SurfacePoint start{0, Uv(0.3, 0.1)};
  const SurfaceDerivatives d = skin.derivatives(start);
  GeodesicState g = tracer.start(start, (d.Su.normalized() + d.Sv.normalized()).normalized());
  ASSERT_EQ(tracer.advance(g, 1000), TraceEnd::reached);
  const double turn = std::atan2(d.S.y(), d.S.x()) + 1000 / std::sqrt(2.0) / 350;
  const Vec3 expected(350 * std::cos(turn), 350 * std::sin(turn), d.S.z() + 1000 / std::sqrt(2.0));
  EXPECT_LT((skin.point(g.at) - expected).norm(), 1e-9);
}

// Beyond the rim of a closed B-spline the way round crosses the seam's continuation: (u, v) wraps, and
// the piece with it. A ray that goes out, round and back in must still be the helix.
TEST(Geodesic, WrapsRoundBeyondTheRimOfAClosedSurface) {
  Part part = make_rectangular_part(nurbs_cylinder(350, 1000), {0, 4}, {0.2, 1});
  const Skin skin(std::make_shared<const Part>(part), {0});
  GeodesicOptions o = fine();
  o.outside_limit_mm = 1000;
  const GeodesicTracer tracer(skin, o);
  const SurfacePoint start{0, Uv(3.6, 0.21)};  // 10 mm above the rim, short of the seam
  const SurfaceDerivatives d = skin.derivatives(start);
  const Vec3 t = (d.Su.normalized() - 0.2 * d.Sv.normalized()).normalized();
  GeodesicState g = tracer.start(start, t);
  ASSERT_EQ(tracer.advance(g, 500), TraceEnd::reached);
  EXPECT_TRUE(g.outside);
  const double turn = std::atan2(d.S.y(), d.S.x()) + 500 * std::hypot(t.x(), t.y()) / 350;
  const Vec3 expected(350 * std::cos(turn), 350 * std::sin(turn), d.S.z() + 500 * t.z());
  EXPECT_LT((skin.point(g.at) - expected).norm(), 1e-9);
}

// The rim is a knot line and a trim loop at once: a step that lands on it must still notice both ways.
TEST(Geodesic, NoticesALoopOnTheEndOfTheDomain) {
  const Skin skin = make_skin(nurbs_cylinder(350, 1000), {0, 4}, {0, 1});
  GeodesicOptions o = fine();
  o.margin_mm = 100;
  const GeodesicTracer tracer(skin, o);
  const SurfacePoint start{0, Uv(0.5, 0.01)};
  const SurfaceDerivatives d = skin.derivatives(start);
  GeodesicState g = tracer.start(start, -d.Sv);
  ASSERT_EQ(tracer.advance(g, 30), TraceEnd::reached);
  EXPECT_TRUE(g.outside);
  g.duv = -g.duv;
  ASSERT_EQ(tracer.advance(g, 40), TraceEnd::reached);
  EXPECT_FALSE(g.outside);
}

// A path that starts on the boundary, or a rounding error beyond it, and leads off the skin crosses no loop
// on its way.
TEST(Geodesic, LeavesAcrossNothingFromAStartOnTheBoundary) {
  Part part = make_rectangular_part(nurbs_cylinder(350, 1000), {0, 4}, {0.2, 1});
  const Skin skin(std::make_shared<const Part>(part), {0});
  GeodesicOptions o = fine();
  o.outside_limit_mm = 100;
  const GeodesicTracer tracer(skin, o);
  for (const double beyond : {0.0, 1e-15, 1e-12}) {
    const SurfacePoint start{0, Uv(0.5, 0.2 - beyond)};
    const SurfaceDerivatives d = skin.derivatives(start);
    GeodesicState g = tracer.start(start, -d.Sv);
    ASSERT_EQ(tracer.advance(g, 30), TraceEnd::reached);
    EXPECT_TRUE(g.outside) << beyond;
    EXPECT_FALSE(g.in_hole) << beyond;
    EXPECT_EQ(tracer.advance(g, 100), TraceEnd::left) << beyond;
    GeodesicState in = tracer.start(start, d.Sv);
    ASSERT_EQ(tracer.advance(in, 30), TraceEnd::reached);
    EXPECT_FALSE(in.outside) << beyond;
  }
}

// How far a path may run outside is exact. A great circle pokes out over a circle of latitude and comes back:
// lat = asin(sin(i) sin(s / R)) is above v0 over R (pi - 2 asin(sin v0 / sin i)).
TEST(Geodesic, LeavesAfterTheSameWayWhateverItsSteps) {
  const double R = 1000, v0 = 0.3, tilt = 0.32;
  const Skin skin = make_skin(Surface::sphere({}, R), {-1.5, 1.5}, {-1, v0});
  const double outside = R * (pi - 2 * std::asin(std::sin(v0) / std::sin(tilt)));
  for (const double tolerance : {1e-5, 1e-8, 1e-11})
    for (const double limit : {outside - 0.1, outside + 0.1}) {
      GeodesicOptions options;
      options.tolerance_mm = tolerance;
      options.outside_limit_mm = limit;
      const GeodesicTracer tracer(skin, options);
      const Vec3 ahead(std::cos(tilt) * std::sin(pi / 4), std::cos(tilt) * std::cos(pi / 4), std::sin(tilt));
      GeodesicState g = tracer.start({0, Uv(-pi / 4, 0)}, ahead);
      EXPECT_EQ(tracer.advance(g, 0.9 * R * pi), limit > outside ? TraceEnd::reached : TraceEnd::left)
          << tolerance << " " << limit - outside;
    }
}

// Two planes meeting at a fold: the straightest path keeps its angle to the edge.
TEST(Geodesic, TurnsAboutAFold) {
  const Vec3 n1(0, 0, 1), n2 = Vec3(0, -1, 1).normalized();
  const Vec3 t = turn_across(Vec3(0.6, 0.8, 0), Vec3::UnitX(), n1, n2);
  EXPECT_NEAR(t.x(), 0.6, 1e-15);
  EXPECT_LT((t - Vec3(0.6, 0.8 / std::sqrt(2.0), 0.8 / std::sqrt(2.0))).norm(), 1e-15);
}

}  // namespace
}  // namespace afptraj
