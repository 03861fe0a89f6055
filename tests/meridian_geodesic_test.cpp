// Geodesics by Clairaut's relation, against closed forms and against an integrator of the geodesic's equation
// on the surface itself, which knows nothing of Clairaut.
#include "winding/meridian_geodesic.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "geometry/geodesic.h"
#include "tests/meridians.h"
#include "winding/frustum.h"
#include "winding/quadrature.h"

namespace afptraj {
namespace {

using test::vessel;

constexpr double law = 1e-9;  // radians, and mm by mm

TEST(MeridianGeodesic, M1HalfAGreatCircle) {
  const double R = 150;
  const Meridian sphere = vessel(R, 0, R);
  for (const double share : {0.02, 0.2, 0.5, 0.8, 0.97}) {
    const MeridianGeodesic geodesic(sphere, share * R, sphere.widest());
    EXPECT_TRUE(geodesic.first().turns);
    EXPECT_TRUE(geodesic.last().turns);
    EXPECT_NEAR(geodesic.first().r_mm, share * R, law);
    EXPECT_NEAR(geodesic.turn_rad(), pi, law) << share;
    EXPECT_NEAR(geodesic.length_mm(), pi * R, law * R) << share;
    // all points lie in one plane through the centre
    const auto points = geodesic.points(40);
    const auto place = [](const FibrePoint& p) {
      return Vec3(p.r_mm * std::cos(p.turn_rad), p.r_mm * std::sin(p.turn_rad), p.z_mm);
    };
    const Vec3 normal = place(points.front()).cross(place(points[20])).normalized();
    for (const FibrePoint& point : points) EXPECT_NEAR(place(point).dot(normal), 0, law * R);
  }
}

TEST(MeridianGeodesic, M2CylinderWithHemispheres) {
  const double R = 150, L = 420;
  const Meridian tank = vessel(R, L, R);
  for (const double alpha : {0.1, 0.5, 1.0, 1.3}) {
    const MeridianGeodesic geodesic(tank, R * std::sin(alpha), 1.5);
    EXPECT_NEAR(geodesic.turn_rad(), pi + L * std::tan(alpha) / R, law * (1 + std::tan(alpha))) << alpha;
    EXPECT_NEAR(geodesic.length_mm(), pi * R + L / std::cos(alpha), law * 1000) << alpha;
    for (const FibrePoint& point : geodesic.points(60)) {
      const bool on_cylinder = point.z_mm > 1 && point.z_mm < L - 1;
      EXPECT_NEAR(point.angle_rad, on_cylinder ? alpha : point.angle_rad, law);
    }
  }
}

TEST(MeridianGeodesic, M3Cone) {
  const Meridian cone = meridian_through({{0, 49}, {120, 27}});
  const WindMandrel same{98, 120, 54};
  for (const double angle : {5.0, 20.0, 33.0}) {
    const ConeGeodesic expected(same, angle);
    const MeridianGeodesic geodesic(cone, expected.clairaut_mm(), cone.first());
    EXPECT_FALSE(geodesic.first().turns);
    EXPECT_FALSE(geodesic.last().turns);  // 27 mm is still wider than K
    EXPECT_NEAR(geodesic.turn_rad(), radians(expected.turn_deg(120)), law);
    for (const FibrePoint& point : geodesic.points(20))
      EXPECT_NEAR(point.turn_rad, radians(expected.turn_deg(point.z_mm)), law);
  }
}

// The surface that a meridian of one B-spline turns to: a rational biquadratic circle about the z axis.
Part turned(const BSplineCurve2& meridian) {
  BSplineSurface surface;
  surface.degree_u = 2;
  surface.degree_v = meridian.degree;
  surface.knots_u = {0, 0, 0, 0.25, 0.25, 0.5, 0.5, 0.75, 0.75, 1, 1, 1};
  surface.knots_v = meridian.knots;
  const double c = std::numbers::sqrt2 / 2;
  const double x[9] = {1, 1, 0, -1, -1, -1, 0, 1, 1}, y[9] = {0, 1, 1, 1, 0, -1, -1, -1, 0};
  const std::size_t rows = meridian.poles.size();
  for (std::size_t i = 0; i < 9; ++i) {
    for (std::size_t j = 0; j < rows; ++j) {
      const double r = meridian.poles[j].y();
      surface.poles.emplace_back(r * x[i], r * y[i], meridian.poles[j].x());
      surface.weights.push_back((i % 2 == 1 ? c : 1) * (meridian.weights.empty() ? 1 : meridian.weights[j]));
    }
  }
  return make_rectangular_part(Surface::bspline(surface), {0, 1}, {meridian.first(), meridian.last()});
}

// Walks from the middle of the pass over the surface and compares where it comes to.
void expect_walk(const BSplineCurve2& curve, double share) {
  const Meridian meridian({curve});
  const double K = share * meridian.at(meridian.widest()).r_mm;
  const MeridianGeodesic geodesic(meridian, K, meridian.widest());
  const auto points = geodesic.points(64);
  const FibrePoint& start = points[32];
  const auto part = std::make_shared<const Part>(turned(curve));
  const Skin skin(part, {0});
  const GeodesicTracer tracer(skin, {1e-13});
  const MeridianPoint slope = meridian.at(start.t);
  const Vec3 along = Vec3(slope.dr, 0, slope.dz) / slope.speed();
  const Vec3 direction = along * std::cos(start.angle_rad) + Vec3(0, 1, 0) * std::sin(start.angle_rad);
  GeodesicState state = tracer.start({0, {0, curve.first() + start.t}}, direction);
  for (std::size_t i = 33; i < points.size(); ++i) {
    ASSERT_EQ(tracer.advance(state, points[i].length_mm - points[i - 1].length_mm), TraceEnd::reached);
    const double turn = points[i].turn_rad - start.turn_rad;
    const Vec3 expected(points[i].r_mm * std::cos(turn), points[i].r_mm * std::sin(turn), points[i].z_mm);
    // The integrator's own error over some 500 mm; near a turn the meridian's parameter is touchy, the place
    // not.
    ASSERT_LT((skin.point(state.at) - expected).norm(), 2e-9 * points.back().length_mm) << i << ' ' << share;
  }
}

TEST(MeridianGeodesic, M4EllipsoidAndBSplines) {
  BSplineCurve2 barrel;
  barrel.degree = 3;
  barrel.knots = {0, 0, 0, 0, 0.3, 0.6, 1, 1, 1, 1};
  barrel.poles = {{0, 20}, {5, 60}, {60, 110}, {140, 90}, {190, 70}, {200, 15}};
  BSplineCurve2 ellipse = test::quarter_ellipse(0, 120, 70, 10, true);
  for (const double share : {0.3, 0.5, 0.75}) {
    expect_walk(barrel, share);
    expect_walk(ellipse, share);
  }
}

// On a spheroid of half-axes R and h a dome's half turn is, with sin u = k sin phi, k^2 = 1 - K^2 / R^2,
//   (K / R^2) int_0^{pi/2} sqrt(h^2 + (R^2 - h^2) k^2 sin^2 phi) / (1 - k^2 sin^2 phi) dphi,
// complete elliptic integrals of the first and third kind.
double spheroid_turn(double R, double h, double K) {
  const double k2 = 1 - K * K / (R * R), c = (R * R - h * h) * k2;
  // sqrt(1 - m s) / (1 - n s) = ((m / n) + (1 - m / n) / (1 - n s)) / sqrt(1 - m s)
  const auto both = [](double m, double n) {
    return m / n * std::comp_ellint_1(std::sqrt(m)) + (1 - m / n) * std::comp_ellint_3(std::sqrt(m), n);
  };
  if (c < 0) return K * h / (R * R) * both(-c / (h * h), k2);  // prolate
  const double whole = h * h + c;                              // oblate: from the other end of the quarter
  return K * std::sqrt(whole) / (R * R) / (1 - k2) * both(c / whole, -k2 / (1 - k2));
}

TEST(MeridianGeodesic, M5CylinderWithEllipsoids) {
  const double R = 150, L = 420;
  for (const double h : {60.0, 106.0, 210.0}) {
    const Meridian tank = vessel(R, L, h);
    for (const double alpha : {0.1, 0.5, 1.0, 1.3}) {
      const double K = R * std::sin(alpha);
      const MeridianGeodesic geodesic(tank, K, 1.5);
      const double expected = 2 * spheroid_turn(R, h, K) + L * std::tan(alpha) / R;
      EXPECT_NEAR(geodesic.turn_rad(), expected, law * (1 + std::tan(alpha))) << h << ' ' << alpha;
    }
  }
}

// The geodesic isotensoid carries its pressure by fibres alone: cos(gamma) = r^3 sqrt(R^2 - K^2) /
// (R^3 sqrt(r^2 - K^2)), gamma the meridian's angle with the axis. With q = r^2 its fibre turns by
//   int K dq / (2 q sqrt(q - K^2 - q^3 (R^2 - K^2) / R^6)).
struct Isotensoid {
  double R, K;
  // the integrand by w = sqrt(R^2 - q), which is smooth at the equator
  double root(double q) const {
    const double a = (R * R - K * K) / std::pow(R, 6);
    // the cubic without its root at q = R^2
    return std::sqrt(std::max(0.0, a * (q * q + R * R * q) - K * K / (R * R)));
  }
  double turn(double w_end) const {
    return integral(
        [&](double w) {
          const double q = R * R - w * w;
          return K / (q * root(q));
        },
        0, w_end, 1e-13);
  }
  double z(double w_end) const {  // dz = cos(gamma) / sin(gamma) dr
    return integral(
        [&](double w) {
          const double q = R * R - w * w;
          return q * std::sqrt(R * R - K * K) / (R * R * R) / root(q);
        },
        0, w_end, 1e-12);
  }
};

double isotensoid_error(int rows) {
  const Isotensoid dome{100, 30};
  const double w_end = std::sqrt(100 * 100 - 40.0 * 40.0);  // to r = 40
  std::vector<MeridianRow> meridian;
  for (int i = 0; i <= rows; ++i) {
    const double w = w_end * i / rows;
    meridian.push_back({dome.z(w), std::sqrt(100 * 100 - w * w)});
  }
  const Meridian curve = meridian_through(meridian);
  const MeridianGeodesic geodesic(curve, 30, curve.first());
  EXPECT_FALSE(geodesic.last().turns);
  return std::abs(geodesic.turn_rad() - dome.turn(w_end));
}

TEST(MeridianGeodesic, M6Isotensoid) {
  // the spline's own error, which falls with the fourth power of the rows' distance
  const double coarse = isotensoid_error(40), fine = isotensoid_error(160);
  EXPECT_LT(fine, 2e-8);
  EXPECT_GT(std::log2(coarse / fine) / 2, 3.5);
}

TEST(MeridianGeodesic, ClairautHoldsAtEveryPoint) {
  const Meridian tank = vessel(100, 250, 60);
  const MeridianGeodesic geodesic(tank, 35, 1.5);
  const auto points = geodesic.points(400);
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    EXPECT_NEAR(points[i].r_mm * std::sin(points[i].angle_rad), 35, law);
    // and the angle is that of the path: r dtheta / ds between neighbours, to the second order
    const FibrePoint &a = points[i - 1], &b = points[i + 1];
    const double sine = points[i].r_mm * (b.turn_rad - a.turn_rad) / (b.length_mm - a.length_mm);
    EXPECT_NEAR(sine, 35 / points[i].r_mm, 2e-3);
  }
}

// The widest place may be the end itself: nothing lies before it.
TEST(MeridianGeodesic, BeginsAtAnEnd) {
  const Meridian dome({test::quarter_ellipse(0, 120, 70, 10, true)});
  const MeridianGeodesic geodesic(dome, 60, dome.first());
  EXPECT_EQ(geodesic.first().t, dome.first());
  EXPECT_FALSE(geodesic.first().turns);
  EXPECT_NEAR(geodesic.last().r_mm, 60, law);
}

TEST(MeridianGeodesic, RunsOffWhereTheOpeningIsWider) {
  const Meridian cylinder = meridian_through({{0, 50}, {300, 50}});
  const MeridianGeodesic geodesic(cylinder, 50 * std::sin(0.7), cylinder.first());
  EXPECT_FALSE(geodesic.first().turns);
  EXPECT_FALSE(geodesic.last().turns);
  EXPECT_NEAR(geodesic.turn_rad(), 300 * std::tan(0.7) / 50, law);
  EXPECT_NEAR(geodesic.length_mm(), 300 / std::cos(0.7), law * 300);
}

// A neck narrower than K ends the pass on its near side.
TEST(MeridianGeodesic, TurnsBeforeANeck) {
  const Meridian neck = meridian_through({{0, 30}, {40, 60}, {90, 40}, {140, 60}, {180, 30}});
  const MeridianGeodesic geodesic(neck, 45, 50);
  EXPECT_TRUE(geodesic.last().turns);
  EXPECT_LT(geodesic.last().z_mm, 90);
}

}  // namespace
}  // namespace afptraj
