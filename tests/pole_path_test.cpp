#include <gtest/gtest.h>

#include <cmath>

#include "geometry/curvature.h"
#include "tests/pole_specimens.h"
#include "trajectory/apex.h"
#include "trajectory/path_fit.h"

namespace afptraj {
namespace {

/// A path along the cut of a surface by the plane m . x = height: points every 2 mm from psi = first to last,
/// where `curve` gives the points of the cut.
template <typename Curve>
SteppedPath along(const Skin& skin, Curve curve, double length) {
  SteppedPath path;
  const int count = static_cast<int>(length / 2);
  for (int i = 0; i <= count; ++i) {
    SteppedPoint p;
    const Vec3 x = curve(2 * i - length / 2 + 0.7);  // no point stands on the middle, where the pole is
    p.at = skin.closest_point().closest(x)->at;
    p.position = skin.point(p.at);
    p.direction = (curve(2 * i - length / 2 + 0.7 + 1e-3) - x).normalized();
    p.s_mm = i == 0 ? 0 : path.points.back().s_mm + (p.position - path.points.back().position).norm();
    path.points.push_back(p);
  }
  return path;
}

struct Worst {
  double off = 0, turned = 0, kg = 0, speed = 0;
};

/// Compares the path, every 0.1 mm, with the cut by the plane through `on` across m: what it is off the
/// plane, its direction off the cut's, its geodesic curvature off that `expected(position)`, its speed off
/// that of differences.
template <typename Expected>
Worst compare(const SourceCurve& path, const Vec3& m, double height, Expected expected) {
  Worst out;
  for (double t = path.first() + 0.05; t < path.last() - 0.05; t += 0.1) {
    const SourceCurve::Frame f = path.at(t);
    const Vec3& n = f.frame.normal;
    const Vec3 wanted = m.cross(n).normalized();
    const double slope = m.cross(n).norm();  // a move along the skin changes m . x by this
    out.off = std::max(out.off, std::abs(m.dot(f.frame.position) - height) / slope);
    out.turned = std::max(out.turned, (f.frame.tangent - wanted).norm());
    out.kg = std::max(out.kg, std::abs(f.kg_per_mm - expected(f.frame.position)));
    const double dt = 1e-3;
    const double by_differences =
        (path.at(t + dt).frame.position - path.at(t - dt).frame.position).norm() / (2 * dt);
    out.speed = std::max(out.speed, std::abs(f.speed - by_differences));
  }
  return out;
}

/// Whether the geodesic curvature is that of the path's own frames: the turn of the tangent about the normal.
double curvature_off_its_frames(const SourceCurve& path) {
  double worst = 0;
  const double dt = 5e-3;
  for (double t = path.first() + 0.07; t < path.last() - 0.07; t += 0.53) {
    const SourceCurve::Frame a = path.at(t - dt), f = path.at(t), b = path.at(t + dt);
    const double turn = (b.frame.tangent - a.frame.tangent).dot(f.frame.left()) / (2 * dt * f.speed);
    // At a knot or a join the curvature has a corner or a small step within the difference.
    const double change = std::abs(b.kg_per_mm - a.kg_per_mm);
    worst = std::max(worst, std::abs(turn - f.kg_per_mm) - change);
  }
  return worst;
}

// Circles on a sphere, great and small, that pass the pole at a distance, in every azimuth. Polar coordinates
// along a line have fourth derivatives of up to 6 / d^3 (d phi) and 3 / d^3 (d): cubics with knots of h = 8
// mm hold the path in (u, v), used from d = 8 h on, to h^4 / 384, its direction to h^3 sqrt(3) / 216 (by
// interpolation; least squares at twice that) and its curvature to h^2 / 12 of sqrt(45) / d^3. Nearer to the
// pole the chart about a geodesic does not turn at all.
TEST(PolePath, CirclesPassThePoleOfASphere) {
  const double R = 80, h = 8, fourth = std::sqrt(45.0) / std::pow(8 * h, 3);
  const Skin skin = sphere_skin(R);
  FitOptions options;
  options.knot_spacing_mm = h;
  for (const double beta : {pi / 2, 1.2})
    for (const double beside : {0.0, 0.5, 5.0, 30.0})
      for (const double azimuth : {0.0, 0.3, 1.9, 4.0}) {
        // The circle's axis m leans by beta from the direction in which it passes the pole.
        const double lean = beta - beside / R;
        const Vec3 side(-std::sin(azimuth), std::cos(azimuth), 0),
            ahead(std::cos(azimuth), std::sin(azimuth), 0);
        const Vec3 m = std::cos(lean) * Vec3::UnitZ() + std::sin(lean) * side;
        const Vec3 up = std::sin(lean) * Vec3::UnitZ() - std::cos(lean) * side;
        const double radius = R * std::sin(beta), height = R * std::cos(beta);
        const Vec3 forward = m.cross(up);
        const SteppedPath stepped = along(
            skin,
            [&](double s) -> Vec3 {
              const double psi = s / radius;
              return height * m + radius * (std::cos(psi) * up + std::sin(psi) * forward);
            },
            180);
        const PathFit fit = fit_path(skin, stepped, options);
        const Worst worst =
            compare(*fit.path, m, height, [&](const Vec3&) { return 1 / std::tan(beta) / R; });
        const auto where = [&] {
          return testing::Message() << "beta " << beta << ", " << beside << " mm beside, azimuth " << azimuth;
        };
        EXPECT_LT(worst.off, std::pow(h, 4) / 384 * fourth) << where();
        EXPECT_LT(worst.turned, 2 * std::sqrt(3.0) / 216 * std::pow(h, 3) * fourth) << where();
        EXPECT_LT(worst.kg, h * h / 12 * fourth) << where();
        EXPECT_LT(worst.speed, 1e-6) << where();
        EXPECT_LT(curvature_off_its_frames(*fit.path), 1e-5) << where();
        // What is reported at the points is about what is there between them too.
        EXPECT_GE(fit.max_mm, 0.5 * worst.off - 1e-9) << where();
        EXPECT_LT(fit.max_mm, 1e-3) << where();
      }
}

// The nose of an ellipsoid, made of two faces: plane cuts that pass it in every azimuth, over the shared
// meridians or along them. The curvature of the cut follows from the surface: x^2/a^2 + y^2/b^2 + z^2/c^2 =
// 1.
TEST(PolePath, CutsPassTheNoseOfAnEllipsoid) {
  const double a = 60, b = 45, c = 90;
  const Skin skin = ellipsoid_nose(a, b, c);
  FitOptions options;
  options.fairness = 0;  // the curvature of a cut changes: it would be faired
  for (const double beside : {0.0, 0.5, 6.0})
    for (const double azimuth : {0.0, 0.02, 0.8, 1.5, 3.6}) {
      const Vec3 side(-std::sin(azimuth), std::cos(azimuth), 0),
          ahead(std::cos(azimuth), std::sin(azimuth), 0);
      const Vec3 m = (side + 0.1 * Vec3::UnitZ()).normalized();
      const Vec3 nose(0, 0, c);
      const double height = m.dot(nose) + beside;
      // The cut, by steps along m x gradient and back to both of its equations.
      const auto gradient = [&](const Vec3& x) {
        return Vec3(x.x() / (a * a), x.y() / (b * b), x.z() / (c * c));
      };
      const auto onto = [&](Vec3 x) {
        for (int i = 0; i < 20; ++i) {
          const Vec3 g = gradient(x);
          Eigen::Matrix<double, 2, 3> J;
          J << m.transpose(), 2 * g.transpose();
          const Eigen::Vector2d miss(height - m.dot(x), 1 - x.dot(g));
          x += J.transpose() * (J * J.transpose()).inverse() * miss;
        }
        return x;
      };
      const auto curve = [&](double s) {
        Vec3 x = onto(nose);
        const int count = std::max(1, static_cast<int>(std::abs(s) / 0.5));
        for (int i = 0; i < count; ++i) x = onto(x + s / count * m.cross(gradient(x)).normalized());
        return x;
      };
      const auto kg = [&](const Vec3& at) {
        const auto tangent = [&](const Vec3& x) { return Vec3(m.cross(gradient(x)).normalized()); };
        const double e = 1e-3;
        const Vec3 x = onto(at), t = tangent(x), n = gradient(x).normalized();
        return (tangent(onto(x + e * t)) - tangent(onto(x - e * t))).dot(n.cross(t)) / (2 * e);
      };
      const PathFit fit = fit_path(skin, along(skin, curve, 120), options);
      const Worst worst = compare(*fit.path, m, height, kg);
      // The curvature of the cut itself changes within some 20 mm here: h^4 / 384 of its fourth derivative.
      EXPECT_LT(worst.off, 2e-3) << beside << " " << azimuth;
      EXPECT_LT(worst.kg, 1e-3) << beside << " " << azimuth;
      EXPECT_LT(worst.speed, 1e-5) << beside << " " << azimuth;
      EXPECT_LT(curvature_off_its_frames(*fit.path), 1e-5) << beside << " " << azimuth;
      EXPECT_GE(fit.max_mm, 0.5 * worst.off) << beside << " " << azimuth;
    }
}

// Field lines of one direction on a sphere are great circles: they pass the pole, also where a step ends on it
// to a rounding error, and also where it is one of two B-spline faces.
TEST(PolePath, TheWalkPassesASmoothPole) {
  const double R = 100;
  const Vec3 ahead(std::cos(0.3), std::sin(0.3), 0), side(-std::sin(0.3), std::cos(0.3), 0);
  for (const Skin& skin : {sphere_skin(R), ellipsoid_nose(R, R, R)})
    for (const double beside : {0.0, 1e-6, 0.5}) {
      const DirectionField field({{Vec3(0, 0, R), ahead, Vec3::Zero()}}, 1e4);
      const double back = 40 / R, lean = beside / R;  // 20 steps from the pole
      const Vec3 up = std::sin(lean) * side + std::cos(lean) * Vec3::UnitZ();
      const Vec3 start = R * (std::cos(back) * up - std::sin(back) * ahead);
      const SteppedPath path =
          step_reference_path(skin, field, skin.closest_point().closest(start)->at, StepOptions{});
      EXPECT_EQ(path.end[0], WalkEnd::singular_field) << beside << " " << to_string(path.end[0]);
      EXPECT_EQ(path.end[1], WalkEnd::singular_field) << beside << " " << to_string(path.end[1]);
      EXPECT_GT(path.points.back().position.dot(ahead), 0.9 * R) << beside;
      EXPECT_LT(path.points.front().position.dot(ahead), -0.9 * R) << beside;
      const Vec3 m = ahead.cross(up);
      for (const SteppedPoint& q : path.points) EXPECT_NEAR(m.dot(q.position), 0, 1e-6) << beside;
    }
}

/// Directions along the axis of a cone: the asked ones are its meridians, and at the apex they part to all
/// sides.
DirectionField along_axis(const Skin& skin) {
  PlyOrientation ply{"P", {}, 0};
  for (int i = 0; i < 12; ++i) ply.points.push_back({skin.point({0, Uv(i * pi / 6, 200)}), Vec3::UnitZ(), 0});
  return make_direction_field(skin, ply, 1e4, 5, "");
}

// Over a blunt apex the walk goes on where it leaves as much of the cone to its left as to its right: on the
// opposite meridian. The arc between and the path fitted to it stay beside the apex and bend as the arc does.
TEST(PolePath, GoesOnBeyondABluntApex) {
  const double W = 25.4;
  for (const double half_angle : {1.3, 1.1, 0.9, 0.6}) {
    const Skin skin = cone_skin(half_angle, 300);
    const DirectionField field = along_axis(skin);
    for (const double azimuth : {0.2, 2.0, 5.3}) {
      StepOptions stepping;
      stepping.band_width_mm = W;
      const SteppedPath path = step_reference_path(skin, field, {0, Uv(azimuth, 200)}, stepping);
      EXPECT_EQ(path.end[0], WalkEnd::boundary);
      EXPECT_EQ(path.end[1], WalkEnd::boundary);
      const Vec3 a = path.points.front().position, b = path.points.back().position;
      EXPECT_NEAR((a.x() * b.x() + a.y() * b.y()) / a.head<2>().norm() / b.head<2>().norm(), -1, 1e-6);
      EXPECT_GT(a.head<2>().norm(), 290 * std::sin(half_angle));
      EXPECT_GT(b.head<2>().norm(), 290 * std::sin(half_angle));
      FitOptions fitting;
      fitting.length_mm = W;
      const PathFit fit = fit_path(skin, path, fitting);
      const double half_turn = pi / 2 * (1 - std::sin(half_angle));
      const double bend = std::tan(half_turn) / (W / 2);
      double nearest = 1e9;
      for (double t = fit.path->first(); t < fit.path->last(); t += 0.1) {
        const SourceCurve::Frame f = fit.path->at(t);
        nearest = std::min(nearest, f.frame.position.norm());
        EXPECT_NEAR(f.speed, 1, 0.02);
        EXPECT_LT(std::abs(f.kg_per_mm), 1.2 * bend);
      }
      EXPECT_GT(nearest, 0.5 * (W / 2) * std::tan(half_turn / 2));
      EXPECT_LT(curvature_off_its_frames(*fit.path), 1e-5);
      EXPECT_LT(fit.spline_mm, 0.01);
      EXPECT_LT(fit.max_mm, nearest);
    }
  }
}

// At a sharp apex it ends, and the path that is fitted to it arrives there along a meridian, straight.
TEST(PolePath, EndsAtASharpApex) {
  for (const double half_angle : {0.1, 0.3, 0.5})
    for (const double azimuth : {0.2, 2.0, 5.3}) {
      const Skin skin = cone_skin(half_angle, 300);
      const SteppedPath path =
          step_reference_path(skin, along_axis(skin), {0, Uv(azimuth, 200)}, StepOptions{});
      const int up = path.end[0] == WalkEnd::pole ? 0 : 1;
      EXPECT_EQ(path.end[up], WalkEnd::pole) << half_angle << " " << azimuth;
      EXPECT_EQ(path.end[1 - up], WalkEnd::boundary) << half_angle << " " << azimuth;
      const PathFit fit = fit_path(skin, path, {});
      const double end[2] = {fit.path->first(), fit.path->last()};
      EXPECT_LT(fit.path->at(end[up]).frame.position.norm(), 1e-6) << half_angle << " " << azimuth;
      for (double t = end[0]; t <= end[1]; t += 0.1) {
        const SourceCurve::Frame f = fit.path->at(t);
        EXPECT_NEAR(f.speed, 1, 1e-3) << half_angle << " " << azimuth;
        EXPECT_LT(std::abs(f.kg_per_mm), 1e-4) << half_angle << " " << azimuth;
      }
    }
}

// Fairing moves the points before an apex, not the end on it: that turns to the side from which the path now comes. Else
// the path would go round the apex on its last step.
TEST(PolePath, ArrivesAtAnApexAfterFairing) {
  const double half_angle = 0.3, last = 2;
  const Skin skin = cone_skin(half_angle, 300);
  SteppedPath path;
  path.end[0] = WalkEnd::boundary;
  path.end[1] = WalkEnd::pole;
  for (double r = 200; r > last - 1; r -= 2) {
    const double sideways = 0.5 * std::sin(r / 6);
    const SurfacePoint at{0, Uv(0.4 + sideways / (r * std::sin(half_angle)), r)};
    path.points.push_back({at, skin.point(at), -skin.point(at).normalized(), 1, 200 - r});
  }
  const SteppedPoint before = path.points.back();
  path.points.push_back(*beside_pole(skin, Vec3::Zero(), before.position, beside_apex_mm, before));
  const PathFit fit = fit_path(skin, path, {});
  EXPECT_LT(fit.path->at(fit.path->last()).frame.position.norm(), 1e-6);
  for (double t = fit.path->last() - 20; t <= fit.path->last(); t += 0.05) {
    const SourceCurve::Frame f = fit.path->at(t);
    EXPECT_NEAR(f.speed, 1, 0.05) << t;
    EXPECT_LT(std::abs(f.kg_per_mm), 0.01) << t;
  }
}

}  // namespace
}  // namespace afptraj
