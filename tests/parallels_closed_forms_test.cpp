// Parallels where the answer is known, or where a symmetry or an isometry maps it onto another one.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "tests/parallel_curves.h"
#include "tests/specimens.h"

namespace afptraj {
namespace {

using test::distance_to;
using test::exact_options;
using test::for_each_midpoint;
using test::length_of;
using test::on_skin;
using test::uv_line;
using test::W;

/// A geodesic from a point to both sides, `length` mm each.
std::shared_ptr<const GeodesicPath> geodesic(const GeodesicTracer& tracer, const SurfacePoint& from,
                                             const Vec3& direction, double length) {
  GeodesicState g = tracer.start(from, -direction);
  EXPECT_EQ(tracer.advance(g, length), TraceEnd::reached);
  g.duv = -g.duv;
  g.s_mm = 0;
  std::vector<GeodesicState> states{g};
  for (int i = 1; i <= 100; ++i) {
    EXPECT_EQ(tracer.advance(g, length / 50), TraceEnd::reached);
    states.push_back(g);
  }
  return std::make_shared<const GeodesicPath>(tracer, states, false);
}

// R3, R11: in the unrolled plane of a cone a geodesic is a straight line and its parallels are its
// offsets. Half angle 20 degrees, from r = 200 at 45 degrees.
TEST(ParallelsClosedForms, AreOffsetsInTheUnrolledPlaneOfACone) {
  const double half = 20 * pi / 180, r0 = 200, sine = std::sin(half);
  const Skin skin = make_skin(Surface::cone({}, r0, half), {-0.8, 2.4}, {-150, 1000});
  ParallelOptions options = exact_options(skin);
  options.geodesic.outside_limit_mm = 300;  // the cone goes on round; its other side is none of this
  const GeodesicTracer tracer(skin, options.geodesic);
  const SurfacePoint start{0, Uv(0.5, 0)};
  const SurfaceDerivatives d = skin.derivatives(start);
  const auto reference = geodesic(tracer, start, (d.Su.normalized() + d.Sv).normalized(), 140);

  // Unrolled: polar coordinates (distance from the apex, u sin(half)). The normal of a cone points
  // outward and (Su, Sv) is right-handed about it, so left stays left.
  const auto unrolled = [&](const Uv& uv) {
    const double rho = r0 / sine + uv.y();
    return Uv(rho * std::cos(uv.x() * sine), rho * std::sin(uv.x() * sine));
  };
  // Polar radius and angle turn anticlockwise as (v, u), which is left-handed: left in the plane is right on
  // the cone.
  const Uv p0 = unrolled(start.uv);
  const Uv radial = p0.normalized(), around(-radial.y(), radial.x());
  const Uv along = (radial + around).normalized(), right(-along.y(), along.x());

  const Parallels parallels = geodesic_parallels(skin, reference, options);
  int counted = 0, levels = 0;
  double total = 0, longest = 0;
  for (const LevelCurve& level : parallels.levels) {
    const auto stretches = on_skin(skin, level);
    levels += !stretches.empty();
    double length = 0;
    for (const SurfaceCurve& stretch : stretches) length += length_of(skin, stretch);
    total += length;
    longest = std::max(longest, length);
    for (const SurfaceCurve& stretch : stretches)
      for_each_midpoint(skin, stretch, [&](const CurveFrame& f) {
        ++counted;
        EXPECT_NEAR(-(unrolled(f.at.uv) - p0).dot(right), level.number * W, 1e-6) << level.number;
        EXPECT_NEAR(f.kg_per_mm, 0, 1e-9);
      });
  }
  EXPECT_GT(levels, 15);
  // They cover the sheet: the sum of widths W over its chords, which grow to the longest and fall again, is
  // off from its area by W times the longest at most.
  EXPECT_NEAR(total * W, skin.area(), W * longest);
  EXPECT_GT(counted, 1000);

  // R3: course 0 reaches r = 500 under 16.42994 degrees after 988.7189 mm and 83.533267 degrees.
  const auto zero = on_skin(skin, *test::level(parallels, 0));
  bool reached = false;
  for (const SurfaceCurve& stretch : zero)
    for_each_midpoint(skin, stretch, [&](const CurveFrame& f) {
      const double r = std::hypot(f.frame.position.x(), f.frame.position.y());
      const double clairaut = std::asin(r0 * std::sin(pi / 4) / r);
      const SurfaceDerivatives e = skin.derivatives(f.at);
      EXPECT_NEAR(std::asin(std::abs(f.frame.tangent.dot(e.Su.normalized()))), clairaut, 1e-7);
      reached = reached || r > 400;
    });
  EXPECT_TRUE(reached);
}

// Of the outer equator of a torus: circles of latitude at v = k W / r, until both sides meet on the inner
// equator.
TEST(ParallelsClosedForms, OfATorusEquatorAreCircles) {
  const double R = 1000, r = 200;
  const Skin skin = make_skin(Surface::torus({}, R, r), {0, 2 * pi}, {0, 2 * pi});
  const Parallels parallels =
      geodesic_parallels(skin, uv_line(skin, Uv(0, 0), Uv(2 * pi, 0), true), exact_options(skin));
  // pi r / W = 12.37: 12 on each side.
  ASSERT_EQ(parallels.levels.size(), 25u);
  for (const LevelCurve& level : parallels.levels) {
    const double v = level.number * W / r, radius = R + r * std::cos(v);
    ASSERT_EQ(level.curves.size(), 1u) << level.number;
    EXPECT_TRUE(level.curves[0].closed) << level.number;
    EXPECT_NEAR(length_of(skin, level.curves[0]), 2 * pi * radius, 1e-6) << level.number;
    for_each_midpoint(skin, level.curves[0], [&](const CurveFrame& f) {
      EXPECT_NEAR(std::hypot(f.frame.position.x(), f.frame.position.y()), radius, 1e-6) << level.number;
      EXPECT_NEAR(f.frame.position.z(), r * std::sin(v), 1e-6) << level.number;
      // They turn toward the side where they get shorter: left above the equator.
      EXPECT_NEAR(f.kg_per_mm, std::sin(v) / radius, 1e-9) << level.number;
    });
  }
}

/// The curves of each level, mapped by `image`, lie on those of the level of opposite number.
template <typename Image>
void expect_symmetry(const Skin& skin, const Parallels& parallels, Image image, int least) {
  int counted = 0;
  double worst = 0;
  for (const LevelCurve& level : parallels.levels) {
    const auto stretches = on_skin(skin, level);
    if (stretches.empty()) continue;
    const LevelCurve* other = test::level(parallels, -level.number);
    ASSERT_TRUE(other) << level.number;
    for (const SurfaceCurve& stretch : stretches)
      for_each_midpoint(skin, stretch, [&](const CurveFrame& f) {
        const double d = distance_to(skin, other->curves, image(f.frame.position));
        worst = std::max(worst, d);
        ++counted;
      });
  }
  EXPECT_LT(worst, 1e-6);
  EXPECT_GT(counted, least);
}

// Parallels of a meridian of the torus are no circles, but mirror images to both sides.
TEST(ParallelsClosedForms, OfATorusMeridianAreMirrorImages) {
  const double R = 400, r = 150;
  const Skin skin = make_skin(Surface::torus({}, R, r), {-0.9, 0.9}, {-1.2, 1.2});
  ParallelOptions options = exact_options(skin);
  options.geodesic.outside_limit_mm = 200;  // the tube goes on round; its other side is none of this
  const Parallels parallels = geodesic_parallels(skin, uv_line(skin, Uv(0, -1.2), Uv(0, 1.2)), options);
  expect_symmetry(
      skin, parallels, [](const Vec3& p) { return Vec3(p.x(), -p.y(), p.z()); }, 600);
}

/// The greatest |distance to the level before - W| between samples, by an independent tolerance.
double spacing_error(const Skin& skin, const Parallels& parallels, double spacing, int* checked) {
  GeodesicOptions fine;
  fine.tolerance_mm = 1e-13;
  fine.outside_limit_mm = skin.diagonal();
  fine.margin_mm = spacing;
  const GeodesicTracer tracer(skin, fine);
  double worst = 0;
  for (const LevelCurve& level : parallels.levels) {
    if (level.number == 0) continue;
    LaidCurves laid(skin, spacing);
    for (SurfaceCurve& s :
         on_skin(skin, *test::level(parallels, level.number > 0 ? level.number - 1 : level.number + 1)))
      laid.add(std::move(s), level.number);
    for (const SurfaceCurve& stretch : on_skin(skin, level))
      for_each_midpoint(skin, stretch, [&](const CurveFrame& f) {
        const auto near = laid.rival(tracer, f.frame.position, f.frame.normal, 1.02 * spacing, -1, 0, 0);
        if (!near) return;
        worst = std::max(worst, std::abs(std::abs(near->foot.distance_mm) - spacing));
        ++*checked;
      });
  }
  return worst;
}

// The saddle z = x y / c, an exact bilinear patch. Its rulings are geodesics; about the ruling y = 0 a half
// turn maps it onto itself, and so the parallels of that ruling: left onto right. Rays part (K < 0): no fold.
TEST(ParallelsClosedForms, OfARulingOfASaddleTurnIntoEachOther) {
  const double side = 350, c = 600;
  BSplineSurface s;
  s.knots_u = s.knots_v = {-side, -side, side, side};
  for (const double x : {-side, side})
    for (const double y : {-side, side}) s.poles.emplace_back(x, y, x * y / c);
  const Skin skin = make_skin(Surface::bspline(s), {-side, side}, {-side, side});
  const ParallelOptions options = exact_options(skin);
  const Parallels parallels = geodesic_parallels(skin, uv_line(skin, Uv(-side, 0), Uv(side, 0)), options);
  expect_symmetry(
      skin, parallels, [](const Vec3& p) { return Vec3(p.x(), -p.y(), -p.z()); }, 1000);
  int checked = 0;
  // Cubics and rays as asked for (exact_options), both on the level and on the one before.
  EXPECT_LT(spacing_error(skin, parallels, W, &checked), 1e-6);
  EXPECT_GT(checked, 1000);
}

/// One polynomial patch of degree n x n through Chebyshev points over a rectangle.
template <typename Point>
Surface interpolated(const Interval& u, const Interval& v, int n, Point point) {
  using Real = long double;
  using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
  Matrix bernstein(n + 1, n + 1);
  std::vector<double> x(static_cast<std::size_t>(n) + 1);
  for (int i = 0; i <= n; ++i) {
    const double t = 0.5 - 0.5 * std::cos(pi * i / n);
    x[static_cast<std::size_t>(i)] = t;
    Real binomial = 1;
    for (int k = 0; k <= n; ++k) {
      bernstein(i, k) = binomial * std::pow(Real(t), Real(k)) * std::pow(1 - Real(t), Real(n - k));
      binomial = binomial * (n - k) / (k + 1);
    }
  }
  const Matrix inverse = bernstein.inverse();
  BSplineSurface s;
  s.degree_u = s.degree_v = n;
  for (int end = 0; end < 2; ++end)
    for (int i = 0; i <= n; ++i) {
      s.knots_u.push_back(end == 0 ? u.lo : u.hi);
      s.knots_v.push_back(end == 0 ? v.lo : v.hi);
    }
  s.poles.resize(static_cast<std::size_t>((n + 1) * (n + 1)));
  for (int axis = 0; axis < 3; ++axis) {
    Matrix values(n + 1, n + 1);
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j <= n; ++j)
        values(i, j) = point(u.lo + u.length() * x[static_cast<std::size_t>(i)],
                             v.lo + v.length() * x[static_cast<std::size_t>(j)])[axis];
    const Matrix poles = inverse * values * inverse.transpose();
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j <= n; ++j)
        s.poles[static_cast<std::size_t>(i * (n + 1) + j)][axis] = static_cast<double>(poles(i, j));
  }
  return Surface::bspline(s);
}

constexpr double waist = 300;
Vec3 on_catenoid(double u, double v) {
  return {waist * std::cosh(v) * std::cos(u), waist * std::cosh(v) * std::sin(u), waist * v};
}
Vec3 on_helicoid(double u, double v) {
  return {waist * std::sinh(v) * std::cos(u), waist * std::sinh(v) * std::sin(u), waist * u};
}

/// Greatest distance of a patch from what it stands for, and of its first form from waist^2 cosh^2 v (E = G,
/// F = 0).
template <typename Point>
double patch_error(const Surface& surface, const Interval& u, const Interval& v, Point point, double* form) {
  double most = 0;
  for (int i = 0; i <= 40; ++i)
    for (int j = 0; j <= 40; ++j) {
      const Uv uv(u.lo + u.length() * i / 40, v.lo + v.length() * j / 40);
      const SurfaceDerivatives d = surface.derivatives(uv);
      most = std::max(most, (d.S - point(uv.x(), uv.y())).norm());
      const FirstForm I = first_form(d);
      const double g = std::pow(waist * std::cosh(uv.y()), 2);
      *form = std::max({*form, std::abs(I.E - g) / g, std::abs(I.G - g) / g, std::abs(I.F) / g});
    }
  return most;
}

// R12: catenoid and helicoid are isometric at equal (u, v), and parallels know nothing but the metric. The
// curves of one, taken over by (u, v), must be those of the other. The patches' first forms agree to 1e-11,
// which moves a distance of 300 mm by half of that: nothing beside the 1e-6 of the curves.
TEST(ParallelsClosedForms, OfCatenoidAndHelicoidAreIsometric) {
  const Interval u{-0.7, 0.7}, v{-0.75, 0.75};
  const Surface catenoid = interpolated(u, v, 14, on_catenoid),
                helicoid = interpolated(u, v, 14, on_helicoid);
  double form = 0;
  EXPECT_LT(patch_error(catenoid, u, v, on_catenoid, &form), 1e-10);
  EXPECT_LT(patch_error(helicoid, u, v, on_helicoid, &form), 1e-10);
  EXPECT_LT(form, 1e-11);

  // The skins end well within the patches, so that rays from the reference and its extension reach all of
  // them. What a level curve adds at its ends beyond the rays starts where the last ray left, found to some
  // 1e-4 mm.
  const Interval iu{-0.35, 0.35}, iv{-0.4, 0.4};
  const Skin skins[2] = {make_skin(catenoid, iu, iv), make_skin(helicoid, iu, iv)};
  ParallelOptions options = exact_options(skins[0], 25.4);
  options.geodesic.outside_limit_mm = 90;
  // At a slant across both, so that no symmetry helps.
  const Uv a(-0.35, -0.25), b(0.35, 0.1);
  Parallels parallels[2];
  for (int i = 0; i < 2; ++i) parallels[i] = geodesic_parallels(skins[i], uv_line(skins[i], a, b), options);

  int counted = 0;
  double worst = 0;
  for (const int from : {0, 1}) {
    const int to = 1 - from;
    for (const LevelCurve& level : parallels[from].levels) {
      const auto stretches = on_skin(skins[from], level);
      if (stretches.empty()) continue;
      const LevelCurve* other = test::level(parallels[to], level.number);
      ASSERT_TRUE(other) << level.number;
      for (const SurfaceCurve& stretch : stretches)
        for_each_midpoint(skins[from], stretch, [&](const CurveFrame& f) {
          const double d = distance_to(skins[to], other->curves, skins[to].point({0, f.at.uv}));
          worst = std::max(worst, d);
          ++counted;
        });
    }
  }
  EXPECT_LT(worst, 1e-6);
  EXPECT_GT(counted, 1000);
}

}  // namespace
}  // namespace afptraj
