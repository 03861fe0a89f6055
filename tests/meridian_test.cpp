#include "winding/meridian.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "geometry/error.h"
#include "tests/meridians.h"

namespace afptraj {
namespace {

constexpr double pi = std::numbers::pi;

std::string refusal(const std::vector<MeridianRow>& rows) {
  try {
    meridian_through(rows);
    return "(made)";
  } catch (const Error& e) {
    return e.what();
  }
}

// A meridian evaluates its pieces by powers; the B-splines themselves say the same.
TEST(Meridian, IsItsPieces) {
  BSplineCurve2 high;  // degree 6, one span
  high.degree = 6;
  high.knots = {0, 0, 0, 0, 0, 0, 0, 2, 2, 2, 2, 2, 2, 2};
  high.poles = {{0, 50}, {10, 52}, {20, 57}, {30, 55}, {40, 49}, {50, 47}, {60, 50}};
  for (const Meridian& meridian :
       {test::vessel(100, 250, 60), Meridian({high}),
        meridian_through({{0, 80}, {50, 62}, {90, 58}, {150, 62}, {200, 80}, {260, 95}})}) {
    double start = 0;
    for (const BSplineCurve2& piece : meridian.pieces()) {
      for (int k = 0; k < 40; ++k) {
        const double t = (piece.last() - piece.first()) * (k + 0.3) / 40;
        const auto expected = piece.derivatives(piece.first() + t);
        const MeridianPoint at = meridian.at(start + t);
        EXPECT_NEAR(at.z_mm, expected.c.x(), 1e-11);
        EXPECT_NEAR(at.r_mm, expected.c.y(), 1e-11);
        const double scale = 1 + expected.d2.norm();
        EXPECT_NEAR(at.dz, expected.d1.x(), 1e-11 * scale);
        EXPECT_NEAR(at.dr, expected.d1.y(), 1e-11 * scale);
        EXPECT_NEAR(at.ddz, expected.d2.x(), 1e-10 * scale);
        EXPECT_NEAR(at.ddr, expected.d2.y(), 1e-10 * scale);
      }
      start += piece.last() - piece.first();
    }
  }
}

TEST(Meridian, LinesAreMetExactly) {
  for (const int n : {2, 3, 4, 9}) {
    std::vector<MeridianRow> rows;
    for (int i = 0; i < n; ++i) rows.push_back({100.0 * i / (n - 1), 50 - 20.0 * i / (n - 1)});
    const Meridian meridian = meridian_through(rows);
    EXPECT_NEAR(meridian.length_mm(), std::hypot(100, 20), 1e-10);
    for (double t = meridian.first(); t <= meridian.last(); t += 7.3) {
      const MeridianPoint at = meridian.at(t);
      EXPECT_NEAR(at.r_mm, 50 - 0.2 * at.z_mm, 1e-11);
      EXPECT_NEAR(at.speed(), 1, 1e-11);  // chord length is the way itself
    }
    EXPECT_NEAR(meridian.at(meridian.widest()).r_mm, 50, 1e-9);
    EXPECT_NEAR(meridian.at(meridian.narrowest()).r_mm, 30, 1e-9);
  }
}

// The error of the spline falls with the fourth power of the distance of its points.
TEST(Meridian, TheSplineIsOfFourthOrder) {
  const auto error = [](int n) {
    std::vector<MeridianRow> rows;
    for (int i = 0; i <= n; ++i) {
      const double angle = 0.3 + (pi - 0.6) * i / n;
      rows.push_back({-50 * std::cos(angle), 50 * std::sin(angle)});
    }
    const Meridian meridian = meridian_through(rows);
    double worst = 0;
    for (int k = 0; k <= 2000; ++k) {
      const MeridianPoint at = meridian.at(meridian.last() * k / 2000);
      worst = std::max(worst, std::abs(std::hypot(at.z_mm, at.r_mm) - 50));
    }
    return worst;
  };
  EXPECT_NEAR(std::log2(error(20) / error(40)), 4, 0.4);
  EXPECT_NEAR(std::log2(error(40) / error(80)), 4, 0.4);
}

TEST(Meridian, ARowTwiceIsACorner) {
  const Meridian meridian = meridian_through({{0, 40}, {50, 40}, {50, 40}, {80, 25}});
  for (double t = 0; t <= meridian.last(); t += 0.5) {
    const MeridianPoint at = meridian.at(t);
    EXPECT_NEAR(at.r_mm, at.z_mm <= 50 ? 40 : 40 - 0.5 * (at.z_mm - 50), 1e-11);
  }
  EXPECT_NEAR(meridian.length_mm(), 50 + std::hypot(30, 15), 1e-10);
}

TEST(Meridian, ExtremesBetweenPoints) {
  const Meridian sphere = test::vessel(50, 0, 50);
  EXPECT_NEAR(sphere.at(sphere.widest()).r_mm, 50, 1e-12);
  EXPECT_NEAR(sphere.length_mm(), pi * 50, 1e-9);
  const Meridian waist = meridian_through({{0, 50}, {20, 42}, {45, 38}, {60, 41}, {90, 55}});
  const double least = waist.at(waist.narrowest()).r_mm;
  for (double t = 0; t <= waist.last(); t += 0.01) EXPECT_GE(waist.at(t).r_mm, least - 1e-12);
  EXPECT_NEAR(waist.at(waist.narrowest()).dr, 0, 1e-6);
}

TEST(Meridian, RefusesWhatIsNoMandrel) {
  EXPECT_NE(refusal({{0, 5}}).find("fewer than two points"), std::string::npos);
  EXPECT_NE(refusal({{0, 5}, {0, 5}}).find("all its points at one place"), std::string::npos);
  EXPECT_NE(refusal({{0, 5}, {10, 5}, {5, 6}, {20, 6}}).find("goes back near z"), std::string::npos);
  EXPECT_NE(refusal({{0, 5}, {10, -1}}).find("reaches the axis"), std::string::npos);
  EXPECT_EQ(refusal({{0, 5}, {10, 0}}), "(made)");  // a point at the end
}

}  // namespace
}  // namespace afptraj
