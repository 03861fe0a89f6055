// What layers leave of a mandrel: thickness by the volume of the tow, and the surface moved out by it.
#include "winding/grown_mandrel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/meridians.h"
#include "winding/meridian_geodesic.h"
#include "winding/pass_maker.h"
#include "winding/quadrature.h"

namespace afptraj {
namespace {

using std::numbers::pi;

const WindTow tow{8, 0.3};

TEST(LayerGrowth, IsTwoTowsAndTheirOverlapOnTheCylinder) {
  const Meridian tank = test::vessel(100, 250, 60);
  const double alpha = 0.5;
  const MeridianGeodesic pass(tank, 100 * std::sin(alpha), 1.5);
  const double around = 2 * pi * 100 * std::cos(alpha) / tow.width_mm;
  const LayerGrowth growth = helical_growth(tank, pass, 80, tow);
  EXPECT_NEAR(growth.thickness_mm(1.5), 2 * tow.thickness_mm * 80 / around, 1e-12);
}

// Between circles away from the turns lies the volume of the tow that runs between them.
TEST(LayerGrowth, KeepsTheVolumeOfTheTow) {
  const Meridian tank = test::vessel(100, 250, 60);
  const MeridianGeodesic pass(tank, 40, 1.5);
  const LayerGrowth growth = helical_growth(tank, pass, 70, tow);
  const std::vector<FibrePoint> points = pass.points(64);
  const FibrePoint &a = points[12], &b = points[15];  // on the first dome
  ASSERT_LT(b.t, 1);
  const double volume = integral(
      [&](double t) {
        const MeridianPoint at = tank.at(t);
        return growth.thickness_mm(t) * 2 * pi * at.r_mm * at.speed();
      },
      a.t, b.t, 1e-9);
  EXPECT_NEAR(volume, 2 * 70 * tow.width_mm * tow.thickness_mm * (b.length_mm - a.length_mm), 1e-5 * volume);
}

TEST(LayerGrowth, LevelsOffWhereTheFibreTurns) {
  const Meridian tank = test::vessel(100, 250, 60);
  const MeridianGeodesic pass(tank, 40, 1.5);
  const LayerGrowth growth = helical_growth(tank, pass, 70, tow);
  const double turn = growth.thickness_mm(pass.first().t);
  EXPECT_EQ(growth.thickness_mm(pass.first().t / 2), turn);
  double before = turn;
  for (double t = pass.first().t; t < 1; t += 0.002) {
    const double here = growth.thickness_mm(t);
    EXPECT_LE(here, before + 1e-9);
    before = here;
    // no step, and no edge: second differences fall with the square of their distance
    const auto bend = [&](double h) {
      return std::abs(growth.thickness_mm(t + h) - 2 * here + growth.thickness_mm(t - h));
    };
    EXPECT_LT(bend(1e-4), 5e-5);
  }
  // as it is one and a half tows from the turn
  const std::vector<FibrePoint> points = pass.points(2000);
  double way = 0;
  for (std::size_t i = 1; way < 1.5 * tow.width_mm; ++i) {
    way += std::hypot(points[i].z_mm - points[i - 1].z_mm, points[i].r_mm - points[i - 1].r_mm);
    const double plain =
        70 * tow.width_mm * tow.thickness_mm / (pi * points[i].r_mm * std::cos(points[i].angle_rad));
    if (way >= 1.5 * tow.width_mm) {
      EXPECT_NEAR(plain, turn, 0.02 * turn);
    }
  }
}

TEST(GrownMandrel, MovesOutAlongItsNormals) {
  const double R = 100;
  const Meridian grown = grown_mandrel(test::vessel(R, 250, R), {[](double) { return 2.5; }, {0.4, 1.3}});
  for (int i = 0; i <= 500; ++i) {
    const MeridianPoint at = grown.at(grown.first() + (grown.last() - grown.first()) * i / 500);
    const double beside = at.z_mm < 0 ? at.z_mm : std::max(at.z_mm - 250, 0.0);
    EXPECT_NEAR(std::hypot(beside, at.r_mm), R + 2.5, 1e-5);
  }
}

TEST(GrownMandrel, StaysConvexUnderHoops) {
  for (const double height : {100.0, 60.0}) {
    const Meridian tank = test::vessel(100, 250, height);
    const Meridian grown = grown_mandrel(tank, hoop_growth(tank, 1, 2, {4, 0.3}));
    EXPECT_NEAR(grown.at(grown.widest()).r_mm, 100.6, 1e-9);
    for (int i = 1; i < 1000; ++i) {
      const double t = grown.first() + (grown.last() - grown.first()) * i / 1000;
      EXPECT_GT(grown.at(t).curvature(), -1e-6) << grown.at(t).z_mm;
    }
    // far out on the dome nothing has changed
    EXPECT_NEAR(grown.at(grown.nearest(-0.9 * height, 100 * std::sqrt(0.19))).r_mm, 100 * std::sqrt(0.19),
                1e-5);
  }
}

TEST(GrownMandrel, HoopsKeepToTheWidestStretch) {
  const Meridian tank = test::vessel(100, 250, 60);
  const PassMaker hoops(tank, {0.1, {}, {}, 8, true});
  const auto found = hoops.at(89.2);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->pass.first().z_mm, 4, 1e-2);
  EXPECT_NEAR(found->pass.last().z_mm, 246, 1e-2);
  EXPECT_EQ(found->pass.first().r_mm, 100);
}

}  // namespace
}  // namespace afptraj
