#include "trajectory/geodesic_chart.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/curvature.h"
#include "tests/pole_specimens.h"

namespace afptraj {
namespace {

/// About the great circle that passes the pole of a sphere 0.3 mm beside it.
constexpr double R = 60;
const Vec3 m = Vec3(0, std::cos(0.3 / R), std::sin(0.3 / R));  // its axis
GeodesicChart chart_past_pole(const Skin& skin) {
  const Vec3 up = Vec3(0, -std::sin(0.3 / R), std::cos(0.3 / R));
  const auto at = skin.closest_point().closest(R * up)->at;
  return GeodesicChart(skin, at, up.cross(-m), 1, 50, 70, {});
}

// On a sphere w is the latitude over the great circle and s the longitude along it: y = cos(w / R), lines of
// constant w have the geodesic curvature tan(w / R) / R, and all of it runs past the pole as if it were not
// there.
TEST(GeodesicChart, IsLongitudeAndLatitudeOnASphere) {
  const Skin skin = sphere_skin(R);
  const GeodesicChart chart = chart_past_pole(skin);
  EXPECT_NEAR(chart.length_mm(), 120, 1e-9);
  EXPECT_NEAR(chart.origin().x(), 50, 1e-9);
  const Vec3 axis = m;  // to the left
  const Vec3 start = chart.place(Uv(0, 0)).d.S;
  for (const double s : {1.0, 49.9, 50.0, 50.3, 77.0, 119.0})
    for (const double w : {-20.0, -0.3, 0.0, 0.2, 15.0}) {
      const GeodesicChart::Place place = chart.place(Uv(s, w));
      const Vec3 foot = std::cos(s / R) * start + std::sin(s / R) * axis.cross(start);
      const Vec3 truth = std::cos(w / R) * foot + R * std::sin(w / R) * axis;
      EXPECT_LT((place.d.S - truth).norm(), 1e-7) << s << " " << w;
      EXPECT_LT((place.normal - truth / R).norm(), 1e-9) << s << " " << w;
      EXPECT_NEAR(place.d.Su.norm(), std::cos(w / R), 1e-8) << s << " " << w;
      const auto back = chart.coordinates(truth, Uv(s + 0.5, w - 0.5));
      ASSERT_TRUE(back) << s << " " << w;
      EXPECT_LT((*back - Uv(s, w)).norm(), 1e-6) << s << " " << w;
      EXPECT_NEAR(geodesic_curvature(place.d, place.normal, Uv(2, 0), Uv(0.7, 0)), std::tan(w / R) / R, 1e-8)
          << s << " " << w;
    }
}

// Any curve through the chart: velocity and geodesic curvature are those of its positions, by differences.
TEST(GeodesicChart, DerivativesAreThoseOfItsPlaces) {
  const Skin skin = ellipsoid_nose(60, 45, 90);
  const auto at = skin.closest_point().closest(Vec3(0.4, 0.9, 90))->at;
  const GeodesicChart chart(skin, at, Vec3(1, 0.3, 0), 1, 60, 60, {});
  const auto curve = [](double t) { return Uv(t + 3 * std::sin(t / 20), 4 + 6 * std::cos(t / 15)); };
  const double e = 1e-3;
  for (double t = 5; t < 110; t += 3.1) {
    const Uv d1 = (curve(t + e) - curve(t - e)) / (2 * e);
    const Uv d2 = (curve(t + e) - 2 * curve(t) + curve(t - e)) / (e * e);
    const GeodesicChart::Place f = chart.place(curve(t));
    const double h = 0.02;
    const Vec3 a = chart.place(curve(t - h)).d.S, p = f.d.S, b = chart.place(curve(t + h)).d.S;
    const Vec3 velocity = uv_to_tangent(f.d, d1), acceleration = (b - 2 * p + a) / (h * h);
    EXPECT_LT((velocity - (b - a) / (2 * h)).norm(), 1e-5) << t;
    EXPECT_NEAR(geodesic_curvature(f.d, f.normal, d1, d2),
                velocity.cross(acceleration).dot(f.normal) / std::pow(velocity.norm(), 3), 2e-5)
        << t;
  }
}

}  // namespace
}  // namespace afptraj
