// Angles of ply points on a mandrel, as a winder counts them.
#include "winding/ply_angles.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "geometry/error.h"
#include "tests/meridians.h"
#include "winding/meridian_geodesic.h"

namespace afptraj {
namespace {

double radians_of(double degrees) { return degrees * std::numbers::pi / 180; }

SkinMandrel tank() { return {test::vessel(100, 250, 60), Vec3(10, -20, 5), Vec3(-2, 2, -1) / 3, 0}; }

Vec3 in_part(const SkinMandrel& mandrel, const FibrePoint& p, double sense) {
  const Vec3 x = Vec3(1, 2, 2) / 3, y = mandrel.direction.cross(x);
  const double turn = sense * p.turn_rad;
  return mandrel.origin + p.z_mm * mandrel.direction + p.r_mm * (std::cos(turn) * x + std::sin(turn) * y);
}

// Chords of one geodesic through cylinder and domes, as a ply would give them, of either sense.
std::vector<FibreDirection> along_geodesic(const SkinMandrel& mandrel, double angle_deg, double sense) {
  const MeridianGeodesic pass(mandrel.meridian, 100 * std::sin(radians_of(angle_deg)), 1.5);
  const std::vector<FibrePoint> points = pass.points(4000);
  std::vector<FibreDirection> out;
  for (std::size_t i = 400; i + 400 < points.size(); i += 400) {
    const Vec3 chord = in_part(mandrel, points[i + 1], sense) - in_part(mandrel, points[i - 1], sense);
    out.push_back({in_part(mandrel, points[i], sense), (i % 800 == 0 ? -3.0 : 1.0) * chord});
  }
  return out;
}

TEST(PlyAngles, PointsOfOneGeodesicGiveItsAngle) {
  const SkinMandrel mandrel = tank();
  for (const double angle : {20.0, 54.7, 75.0}) {
    for (const int sense : {1, -1}) {
      const PlyAngle found = ply_angle(mandrel, along_geodesic(mandrel, angle, sense));
      // chords of 0.3 mm on a radius of 40 mm and more
      EXPECT_NEAR(found.angle_deg, angle, 0.01);
      EXPECT_LT(found.spread_deg, 0.02);
      EXPECT_LT(found.off_mm, 1e-9);
      EXPECT_EQ(found.sense, sense);
    }
  }
}

TEST(PlyAngles, SpreadIsTheFarthestFromTheMeansGeodesic) {
  const SkinMandrel mandrel = tank();
  const auto at = [&](double angle_deg, double off_mm) {
    const Vec3 x = Vec3(1, 2, 2) / 3, y = mandrel.direction.cross(x);
    const double a = radians_of(angle_deg);
    return FibreDirection{mandrel.origin + 100 * mandrel.direction + (100 + off_mm) * x,
                          std::cos(a) * mandrel.direction + std::sin(a) * y};
  };
  const PlyAngle found = ply_angle(mandrel, {at(30, 0), at(50, 2)});
  const double mean =
      std::asin((std::sin(radians_of(30)) + std::sin(radians_of(50))) / 2) * 180 / std::numbers::pi;
  EXPECT_NEAR(found.angle_deg, mean, 1e-9);
  EXPECT_NEAR(found.spread_deg, std::max(mean - 30, 50 - mean), 1e-9);
  EXPECT_NEAR(found.off_mm, 2, 1e-9);
  EXPECT_EQ(ply_angle(mandrel, {at(0, 0)}).sense, 0);
  EXPECT_EQ(ply_angle(mandrel, {at(90, 0)}).sense, 0);
  EXPECT_THROW(ply_angle(mandrel, {at(30, 0), at(-30, 0)}), Error);
  EXPECT_THROW(ply_angle(mandrel, {at(30, 11)}), Error);
  FibreDirection across = at(30, 0);
  across.direction = Vec3(1, 2, 2);
  EXPECT_THROW(ply_angle(mandrel, {across}), Error);
}

TEST(PlyAngles, MirroredNeighboursAreOneLayer) {
  const auto ply = [](double angle, int sense) { return PlyAngle{angle, 0, 0, sense}; };
  const auto layers =
      layers_of_plies({ply(30, 1), ply(31, -1), ply(30, -1), ply(45, 1), ply(50, -1), ply(90, 0)}, 2);
  ASSERT_EQ(layers.size(), 5u);
  EXPECT_EQ(layers[0].plies, (std::vector<std::size_t>{0, 1}));
  EXPECT_EQ(layers[0].angle_deg, 30.5);
  EXPECT_EQ(layers[1].plies, (std::vector<std::size_t>{2}));
  EXPECT_EQ(layers[4].angle_deg, 90);
}

}  // namespace
}  // namespace afptraj
