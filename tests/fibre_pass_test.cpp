// Steered passes: closed forms, the curvature of the path in space, and what friction can reach.
#include "winding/fibre_pass.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <string>

#include "geometry/error.h"
#include "tests/meridians.h"
#include "winding/meridian_geodesic.h"
#include "winding/pass_maker.h"

namespace afptraj {
namespace {

using std::numbers::pi;
using Vec3 = Eigen::Vector3d;

double radians_of(double degrees) { return degrees * pi / 180; }

SteeredClairaut steered(const Meridian& meridian, double from, double to, double q, double ratio,
                        int blocks = 32) {
  return {SteeringGrid(meridian, from, to, blocks), q, ratio};
}

Vec3 place(const FibrePoint& p) {
  return {p.r_mm * std::cos(p.turn_rad), p.r_mm * std::sin(p.turn_rad), p.z_mm};
}

TEST(SteeredClairaut, S1Cylinder) {
  const double R = 60, L = 200;
  const Meridian tube = meridian_through({{0, R}, {L, R}});
  for (const double ratio : {-0.3, 0.1, 0.25}) {
    const SteeredClairaut path = steered(tube, 0, tube.last(), R * std::sin(0.5), ratio);
    for (const double z : {3.0, 77.7, 111.1}) {
      const double inverse = 1 / std::sin(0.5) - ratio * z / R;
      EXPECT_NEAR(path.at(z).q_mm, R / inverse, 1e-9 * R) << ratio;
      EXPECT_NEAR(path.at(z).slope, ratio / (inverse * inverse), 1e-9) << ratio;
    }
    // the way back along the same law
    const double q = path.at(77.7).q_mm;
    EXPECT_NEAR(steered(tube, 77.7, 0, q, ratio).at(0).q_mm, R * std::sin(0.5), 1e-9 * R);
  }
}

TEST(SteeredClairaut, S2Cone) {
  const Meridian cone = meridian_through({{0, 90}, {120, 50}});
  const double slope = -40.0 / 120;  // r' / z'
  for (const double ratio : {-0.2, 0.15}) {
    const SteeredClairaut path = steered(cone, 0, cone.last(), 30, ratio);
    const auto kept = [&](double t) { return 1 / path.at(t).q_mm - ratio / slope / cone.at(t).r_mm; };
    for (const double share : {0.2, 0.55, 0.9})
      EXPECT_NEAR(kept(share * cone.last()), kept(0), 1e-11) << ratio;
  }
}

TEST(SteeredClairaut, S3WithoutSteeringItIsClairaut) {
  const Meridian tank = test::vessel(100, 250, 60);
  const SteeredClairaut path = steered(tank, 2, 2.9, 40, 0);
  EXPECT_EQ(path.at(2.5).q_mm, 40);
  EXPECT_EQ(path.at(2.5).slope, 0);
}

TEST(SteeredClairaut, S4OrderOfTheIntegrator) {
  const Meridian tank = test::vessel(100, 250, 60);
  const double to = 2.5, exact = steered(tank, 2, to, 40, 0.2, 200).at(to).q_mm;
  const auto error = [&](int blocks) {
    return std::abs(steered(tank, 2, to, 40, 0.2, blocks).at(to).q_mm - exact);
  };
  EXPECT_NEAR(std::log2(error(3) / error(6)), 4, 0.3);
  EXPECT_NEAR(std::log2(error(6) / error(12)), 4, 0.3);
  EXPECT_LT(error(32), 1e-8);
}

// The path in space: its curvature across the surface against that along the surface's normal.
double curvature_ratio(const FibrePoint& a, const FibrePoint& b, const FibrePoint& c, const Vec3& normal) {
  const double before = b.length_mm - a.length_mm, after = c.length_mm - b.length_mm;
  const Vec3 e = (place(b) - place(a)) / before, f = (place(c) - place(b)) / after;
  const Vec3 bend = 2 * (f - e) / (before + after), along = (before * f + after * e) / (before + after);
  return bend.dot(normal.cross(along.normalized())) / bend.dot(normal);
}

TEST(FibrePass, S5HasTheCurvatureAskedFor) {
  const double R = 100, height = 60, L = 250;
  const Meridian tank = test::vessel(R, L, height);
  for (const double ratio : {-0.15, 0.2}) {
    const auto path = std::make_shared<SteeredClairaut>(steered(tank, 2, 2.95, 45, ratio));
    const FibrePass pass(tank, 45, 1.5, {}, Steering{2, path});
    ASSERT_TRUE(pass.last().turns);
    const std::vector<FibrePoint> points = pass.points(4000);
    double worst = 0;
    int seen = 0;
    for (std::size_t i = 1; i + 1 < points.size(); ++i) {
      const FibrePoint& p = points[i];
      // steps as short as they are near the turn leave no digits to second differences
      if (p.z_mm < L + 1 || points[i + 1].length_mm - p.length_mm < 0.01) continue;
      const Vec3 at = place(p);
      const Vec3 inward =
          -Vec3(at.x() / (R * R), at.y() / (R * R), (at.z() - L) / (height * height)).normalized();
      worst = std::max(worst, std::abs(curvature_ratio(points[i - 1], p, points[i + 1], inward) - ratio));
      ++seen;
    }
    EXPECT_GT(seen, 500);
    EXPECT_LT(worst, 1e-4) << ratio;
  }
}

// Of a constant ratio on a sphere: a circle of radius R / sqrt(1 + ratio^2).
TEST(FibrePass, IsACircleOnASphere) {
  const double R = 150;
  const Meridian sphere = test::vessel(R, 0, R);
  const double middle = sphere.widest();
  for (const double ratio : {-0.2, 0.3}) {
    const auto path = std::make_shared<SteeredClairaut>(steered(sphere, middle, 1.95, 60, ratio));
    const FibrePass pass(sphere, 60, middle, {}, Steering{middle, path});
    std::vector<Vec3> on;
    for (const FibrePoint& point : pass.points(60))
      if (point.t >= middle) on.push_back(place(point));
    ASSERT_GT(on.size(), 10u);
    const Vec3 normal = (on[on.size() / 2] - on.front()).cross(on.back() - on[on.size() / 2]).normalized();
    const double from_centre = R * std::abs(ratio) / std::hypot(1, ratio);
    for (const Vec3& at : on) EXPECT_NEAR(std::abs(at.dot(normal)), from_centre, 1e-6) << ratio;
  }
}

TEST(PassMaker, TurnsOnACylinder) {
  const double R = 60, L = 500, mu = 0.25, tow = 8;
  const Meridian tube = meridian_through({{0, R}, {L, R}});
  const PassMaker maker(tube, {mu, {}, {}, tow});
  for (const double angle : {35.0, 54.7, 80.0}) {
    const auto found = maker.at(angle);
    ASSERT_TRUE(found);
    const double alpha = radians_of(angle), zone = R * (1 / std::sin(alpha) - 1) / mu;
    const double between = L - tow - 2 * zone;
    const FibrePass& pass = found->pass;
    EXPECT_NEAR(pass.first().z_mm, tow / 2, 1e-9);
    EXPECT_NEAR(pass.last().z_mm, L - tow / 2, 1e-9);
    EXPECT_EQ(found->needed_friction(), mu);
    const double turn = between * std::tan(alpha) / R + 2 * std::acosh(1 / std::sin(alpha)) / mu;
    EXPECT_NEAR(pass.turn_rad(), turn, 1e-8 * turn);
    const double length = between / std::cos(alpha) + 2 * R / std::tan(alpha) / mu;
    EXPECT_NEAR(pass.length_mm(), length, 1e-8 * length);
  }
  EXPECT_FALSE(maker.at(10));
}

TEST(PassMaker, TurnsAtTheOpeningsAskedFor) {
  const Meridian tank = test::vessel(100, 250, 60);
  const SteeringRule rule{0.3, 30, 55, 8};
  const PassMaker maker(tank, rule);
  const auto found = maker.at(25);  // as a geodesic it would turn at 42.3
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->pass.first().r_mm, 30, 1e-9);
  EXPECT_NEAR(found->pass.last().r_mm, 55, 1e-9);
  EXPECT_LT(found->ratio_first, 0);
  EXPECT_GT(found->ratio_last, 0);
  EXPECT_LE(found->needed_friction(), rule.friction);
  // between the domes the angle stays
  EXPECT_EQ(found->pass.clairaut_at(1.5), 100 * std::sin(radians_of(25)));
  // no friction is needed where a geodesic turns there anyway
  const double K = 100 * std::sin(radians_of(25));
  const auto same = PassMaker(tank, {0.3, K, K, 8}).at(25);
  ASSERT_TRUE(same);
  EXPECT_LT(same->needed_friction(), 1e-9);
  EXPECT_NEAR(same->pass.turn_rad(), MeridianGeodesic(tank, K, 1.5).turn_rad(), 1e-9);
}

// The number that stands after some words in a text.
double number_after(const std::string& text, const std::string& words) {
  const std::size_t at = text.find(words);
  EXPECT_NE(at, std::string::npos) << text;
  return at == std::string::npos ? 0 : std::stod(text.substr(at + words.size()));
}

// What a refusal names can be wound.
TEST(PassMaker, NamesWhatIsFeasible) {
  const Meridian tank = test::vessel(100, 250, 60);
  const auto at = [&](double friction, double opening) {
    return PassMaker(tank, {friction, {}, opening, 8}).at(25).has_value();
  };
  for (const double opening : {10.0, 90.0}) {
    ASSERT_FALSE(at(0.1, opening));
    const std::string text = PassMaker(tank, {0.1, {}, opening, 8}).refusal(25);
    const double least = number_after(text, "radii from "), most = number_after(text, " to ");
    EXPECT_TRUE(at(0.1, least * 1.0001)) << text;
    EXPECT_TRUE(at(0.1, most * 0.9999)) << text;
    EXPECT_FALSE(at(0.1, least * 0.999)) << text;
    EXPECT_FALSE(at(0.1, most * 1.001)) << text;
    const double needed = number_after(text, "a friction of ");
    EXPECT_TRUE(at(needed * 1.001, opening)) << text;
    EXPECT_FALSE(at(needed * 0.999, opening)) << text;
  }
  const Meridian tube = meridian_through({{0, 60}, {200, 60}});
  const std::string text = PassMaker(tube, {0.2, {}, {}, 8}).refusal(20);
  const double angle = number_after(text, "an angle of at least ");
  EXPECT_TRUE(PassMaker(tube, {0.2, {}, {}, 8}).at(angle)) << text;
  EXPECT_FALSE(PassMaker(tube, {0.2, {}, {}, 8}).at(angle - 0.001)) << text;
  const double needed = number_after(text, "a friction of ");
  EXPECT_TRUE(PassMaker(tube, {needed * 1.001, {}, {}, 8}).at(20)) << text;
  EXPECT_FALSE(PassMaker(tube, {needed * 0.999, {}, {}, 8}).at(20)) << text;
  EXPECT_NE(PassMaker(tube, {0, {}, {}, 8}).refusal(20).find("runs off the first end"), std::string::npos);
}

TEST(PassMaker, RefusesOpeningsThatTheMandrelHasNot) {
  const Meridian tank = test::vessel(100, 250, 60);
  EXPECT_THROW(PassMaker(tank, {0.2, 120, {}, 8}), Error);
  EXPECT_THROW(PassMaker(tank, {0.2, {}, 3, 8}), Error);
}

}  // namespace
}  // namespace afptraj
