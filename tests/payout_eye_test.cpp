// The payout eye against closed forms on cylinder and sphere, and its laws on vessels.
#include "winding/payout_eye.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "geometry/error.h"
#include "tests/meridians.h"
#include "winding/meridian_geodesic.h"

namespace afptraj {
namespace {

using std::numbers::pi;

TEST(PayoutEye, E1CylinderWithAFixedEye) {
  const double R = 60, c = 95, length = 400;
  const Meridian cylinder = meridian_through({{0, R}, {length, R}});
  const PayoutEye eye(cylinder, {30, c});
  const double leg = std::sqrt(c * c - R * R);
  for (const double a : {0.05, 0.4, 1.0, 1.5, pi / 2}) {
    for (const bool back : {false, true}) {
      const double angle = back ? pi - a : a;
      const EyePosition at = eye.at(fibre_tangent(cylinder, 120, 0.7, angle));
      EXPECT_NEAR(at.free_length_mm, leg / std::sin(a), 1e-9);
      EXPECT_NEAR(at.carriage_mm, 120 + leg / std::tan(angle), 1e-9);
      EXPECT_NEAR(at.mandrel_rad, 0.7 + std::acos(R / c), 1e-12);
      EXPECT_NEAR(at.cross_feed_mm, c, 1e-10);
      EXPECT_NEAR(at.rotation_rad, -std::atan2(c * std::cos(angle), R * std::sin(a)), 1e-12);
    }
  }
}

// The hull of a sphere is the sphere; the outline's chords stay within outline_sagitta_mm, by which l moves
// as dl = (R + clearance) / l times as much.
TEST(PayoutEye, E2Sphere) {
  const double R = 150, clearance = 25;
  const Meridian sphere = test::vessel(R, 0, R);
  const PayoutEye eye(sphere, {clearance, {}});
  const double expected = std::sqrt((R + clearance) * (R + clearance) - R * R);
  const double bound = 2 * outline_sagitta_mm * (R + clearance) / expected;
  for (const double t : {0.2, 0.7, 1.0, 1.5, 1.9}) {
    for (const double a : {0.1, 0.8, pi / 2, 2.0, 3.0}) {
      const EyePosition at = eye.at(fibre_tangent(sphere, t, 0, a));
      EXPECT_NEAR(at.free_length_mm, expected, bound) << t << ' ' << a;
      EXPECT_NEAR(std::hypot(at.carriage_mm, at.cross_feed_mm), R + clearance, 2 * outline_sagitta_mm);
    }
  }
}

// r T_hoop is the same all along a straight line, and with it the least distance from the axis.
TEST(PayoutEye, E3KeepsItsDistance) {
  for (const double height : {100.0, 60.0, 30.0}) {
    const Meridian tank = test::vessel(100, 250, height);
    for (const double K : {8.0, 35.0, 80.0, 99.0}) {
      const MeridianGeodesic pass(tank, K, 1.5);
      const PayoutEye eye(tank, {20, {}}), fixed(tank, {20, 130.0});
      for (const FibrePoint& point : pass.points(200)) {
        for (const double angle : {point.angle_rad, pi - point.angle_rad}) {
          const FibreTangent path = fibre_tangent(tank, point.t, point.turn_rad, angle);
          const EyePosition at = eye.at(path), still = fixed.at(path);
          const double far = eye.envelope().distance(at.carriage_mm, at.cross_feed_mm).mm;
          EXPECT_NEAR(far, 20, 1e-8);
          EXPECT_GE(at.cross_feed_mm, K * (1 - 1e-9));
          EXPECT_GE(fixed.envelope().distance(still.carriage_mm, still.cross_feed_mm).mm, 20 - 1e-9);
          EXPECT_LE(eye.deepest_mm(path, at.free_length_mm), 2 * outline_sagitta_mm);
          EXPECT_LE(eye.deepest_mm(path, still.free_length_mm), 2 * outline_sagitta_mm);
        }
      }
    }
  }
}

// The axes move without jumps along a pass, also where cylinder and dome meet and beyond the ends: with twice
// the points the greatest step is half as great.
TEST(PayoutEye, MovesWithoutJumps) {
  const Meridian tank = test::vessel(100, 250, 60);
  const MeridianGeodesic pass(tank, 20, 1.5);
  const PayoutEye eye(tank, {20, {}});
  const auto greatest_step = [&](int count) {
    EyePosition before;
    double greatest = 0;
    for (const FibrePoint& p : pass.points(count)) {
      const EyePosition at = eye.at(fibre_tangent(tank, p.t, p.turn_rad, p.angle_rad));
      if (p.length_mm > 0) {
        greatest = std::max({greatest, std::abs(at.carriage_mm - before.carriage_mm),
                             std::abs(at.cross_feed_mm - before.cross_feed_mm),
                             std::abs(at.mandrel_rad - before.mandrel_rad) * 100,
                             std::abs(at.rotation_rad - before.rotation_rad) * 100});
      }
      before = at;
    }
    return greatest;
  };
  EXPECT_NEAR(greatest_step(8000) / greatest_step(4000), 0.5, 0.05);
}

// Over a waist the thread would bridge: its line goes below the surface.
TEST(PayoutEye, SeesBridging) {
  const Meridian waist = meridian_through({{0, 80}, {50, 62}, {100, 56}, {150, 62}, {200, 80}});
  const PayoutEye eye(waist, {20, {}});
  const FibreTangent steep = fibre_tangent(waist, (waist.first() + waist.last()) / 2, 0, 0.2);
  EXPECT_GT(eye.deepest_mm(steep, eye.at(steep).free_length_mm), 1);
  const FibreTangent hoop = fibre_tangent(waist, (waist.first() + waist.last()) / 2, 0, pi / 2);
  EXPECT_LE(eye.deepest_mm(hoop, eye.at(hoop).free_length_mm), 2 * outline_sagitta_mm);
}

// The distance from the envelope's hull is that from the nearest place of a convex mandrel, from all sides.
TEST(PayoutEye, MeasuresFromTheNearestPlace) {
  const Meridian tank = test::vessel(100, 250, 60);
  const ClearanceEnvelope envelope(tank, 20);
  constexpr int samples = 2000;
  for (const double z : {-200.0, -90.0, -59.0, -20.0, 0.0, 3.0, 130.0, 250.0, 300.0, 400.0}) {
    for (const double radius : {0.5, 40.0, 99.0, 101.0, 180.0, 900.0}) {
      double least = 1e300;
      for (int i = 0; i <= samples; ++i) {
        const MeridianPoint at = tank.at(tank.first() + (tank.last() - tank.first()) * i / samples);
        least = std::min(least, std::hypot(z - at.z_mm, radius - at.r_mm));
      }
      const double far = envelope.distance(z, radius).mm;
      // inside the distance is 0; places are 0.13 mm apart, and so off by 0.07 at most
      const bool inside = envelope.depth_mm(z, radius) > 0;
      EXPECT_NEAR(far, inside ? 0 : least, 0.08) << z << " " << radius;
    }
  }
}

TEST(PayoutEye, RefusesAnEyeThatIsTooNear) {
  const Meridian cylinder = meridian_through({{0, 60}, {400, 60}});
  EXPECT_THROW(PayoutEye(cylinder, {30, 85.0}), Error);
  EXPECT_NO_THROW(PayoutEye(cylinder, {30, 90.0}));
}

}  // namespace
}  // namespace afptraj
