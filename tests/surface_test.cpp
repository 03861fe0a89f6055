#include "geometry/surface.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "geometry/bspline_curve.h"
#include "geometry/curvature.h"

namespace afptraj {
namespace {

std::vector<double> random_knots(std::mt19937& rng, int degree, int poles, bool multiple) {
  std::uniform_real_distribution<double> step(0.2, 1.0);
  std::vector<double> knots(static_cast<std::size_t>(degree + 1), 0.0);
  double t = 0;
  while (static_cast<int>(knots.size()) < poles) {
    t += step(rng);
    const int left = poles - static_cast<int>(knots.size());
    const int times = multiple ? std::min(left, 1 + static_cast<int>(rng() % static_cast<unsigned>(degree))) : 1;
    for (int i = 0; i < times; ++i) knots.push_back(t);
  }
  t += step(rng);
  for (int i = 0; i <= degree; ++i) knots.push_back(t);
  return knots;
}

BSplineSurface random_spline(unsigned seed, int p, int q, bool rational, bool multiple) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> noise(-40, 40), weight(0.5, 2);
  BSplineSurface s;
  s.degree_u = p;
  s.degree_v = q;
  const int nu = p + 1 + 5, nv = q + 1 + 4;
  s.knots_u = random_knots(rng, p, nu, multiple);
  s.knots_v = random_knots(rng, q, nv, multiple);
  for (int i = 0; i < nu; ++i)
    for (int j = 0; j < nv; ++j) {
      s.poles.emplace_back(100.0 * i, 90.0 * j, noise(rng));
      if (rational) s.weights.push_back(weight(rng));
    }
  return s;
}

/// The definition: sums of Cox-de Boor basis functions, derivatives by the quotient rule.
SurfaceDerivatives by_definition(const BSplineSurface& s, const Uv& uv) {
  const int su = find_span(s.knots_u, s.degree_u, uv.x()), sv = find_span(s.knots_v, s.degree_v, uv.y());
  double nu[3][max_degree + 1], nv[3][max_degree + 1];
  basis_functions(s.knots_u, s.degree_u, su, uv.x(), nu);
  basis_functions(s.knots_v, s.degree_v, sv, uv.y(), nv);
  Eigen::Vector4d a[3][3];
  for (auto& row : a)
    for (auto& x : row) x.setZero();
  for (int i = 0; i <= s.degree_u; ++i)
    for (int j = 0; j <= s.degree_v; ++j) {
      const auto k = static_cast<std::size_t>((su - s.degree_u + i) * s.count_v() + sv - s.degree_v + j);
      const double w = s.weights.empty() ? 1 : s.weights[k];
      Eigen::Vector4d h;
      h << w * s.poles[k], w;
      for (int m = 0; m < 3; ++m)
        for (int n = 0; n < 3; ++n) a[m][n] += nu[m][i] * nv[n][j] * h;
    }
  const auto A = [&](int m, int n) { return Vec3(a[m][n].head<3>()); };
  const auto w = [&](int m, int n) { return a[m][n].w(); };
  SurfaceDerivatives d;
  d.S = A(0, 0) / w(0, 0);
  d.Su = (A(1, 0) - w(1, 0) * d.S) / w(0, 0);
  d.Sv = (A(0, 1) - w(0, 1) * d.S) / w(0, 0);
  d.Suu = (A(2, 0) - 2 * w(1, 0) * d.Su - w(2, 0) * d.S) / w(0, 0);
  d.Suv = (A(1, 1) - w(1, 0) * d.Sv - w(0, 1) * d.Su - w(1, 1) * d.S) / w(0, 0);
  d.Svv = (A(0, 2) - 2 * w(0, 1) * d.Sv - w(0, 2) * d.S) / w(0, 0);
  return d;
}

double greatest_difference(const SurfaceDerivatives& a, const SurfaceDerivatives& b) {
  return std::max({(a.S - b.S).norm(), (a.Su - b.Su).norm(), (a.Sv - b.Sv).norm(), (a.Suu - b.Suu).norm(),
                   (a.Suv - b.Suv).norm(), (a.Svv - b.Svv).norm()});
}

struct Case {
  int p, q;
  bool rational, multiple;
};

class SplineLaws : public testing::TestWithParam<Case> {};

// The pieces are the same function as the sum of basis functions. Horner on centred monomials
// loses about (1 + sqrt 2)^(p + q) units in the last place of the pole size (1000 mm) in S;
// second derivatives gain (2/span)^2 p^2 on top. Bernstein pieces (degree > 9) lose far less.
TEST_P(SplineLaws, PiecesEqualTheDefinition) {
  const auto [p, q, rational, multiple] = GetParam();
  std::mt19937 rng(7);
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const BSplineSurface data = random_spline(seed, p, q, rational, multiple);
    const Surface surface = Surface::bspline(data);
    const Interval du = surface.domain_u(), dv = surface.domain_v();
    std::uniform_real_distribution<double> u(du.lo, du.hi), v(dv.lo, dv.hi);
    const int degree = std::max(p, q) > 9 ? 4 : p + q;
    const double scale = 1000 * std::pow(2.42, degree) * 2.2e-16 * (rational ? 8 : 1);
    for (int i = 0; i < 200; ++i) {
      const Uv uv(u(rng), v(rng));
      const SurfaceDerivatives a = surface.derivatives(uv), b = by_definition(data, uv);
      EXPECT_LT((a.S - b.S).norm(), scale);
      EXPECT_LT(greatest_difference(a, b), scale * 100 * 4 * std::max(p * p, q * q));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Degrees, SplineLaws,
                         testing::Values(Case{1, 1, false, false}, Case{3, 3, false, false}, Case{3, 3, true, true},
                                         Case{2, 5, true, false}, Case{8, 3, true, true}, Case{9, 6, false, true},
                                         Case{12, 4, false, false}, Case{25, 2, true, false}));

TEST(Surface, ContinuesLinearlyBeyondItsEnds) {
  const Surface surface = Surface::bspline(random_spline(3, 3, 3, true, false));
  const double hi = surface.domain_u().hi, v = 0.4 * surface.domain_v().hi;
  const SurfaceDerivatives edge = surface.derivatives(Uv(hi, v));
  const SurfaceDerivatives out = surface.derivatives(Uv(hi + 1e-9, v));
  EXPECT_LT((out.S - edge.S).norm(), 1e-5);  // 1e-9 parameters at some 1000 mm per parameter
  EXPECT_LT((out.Su - edge.Su).norm(), 1e-5);
  // A straight line: Suu is parallel to Su (a rational line runs at varying speed).
  const SurfaceDerivatives far = surface.derivatives(Uv(hi + 0.05, v));
  EXPECT_LT(far.Suu.cross(far.Su).norm(), 1e-8 * far.Su.squaredNorm());
}

TEST(Surface, AnalyticDerivativesAreThoseOfThePoints) {
  // Central differences of the derivative one order lower: error h^2/6 * third derivative.
  Frame f;
  f.origin = Vec3(10, -20, 30);
  f.z = Vec3(1, 2, 3).normalized();
  f.x = Vec3(3, 0, -1).normalized();
  f.y = f.z.cross(f.x);
  const Surface all[] = {Surface::plane(f), Surface::cylinder(f, 350), Surface::cone(f, 200, 0.35),
                         Surface::sphere(f, 1000), Surface::torus(f, 1000, 200)};
  const double h = 1e-5;
  for (const Surface& s : all)
    for (const Uv& uv : {Uv(0.3, 0.7), Uv(2.9, -0.6), Uv(5.1, 1.2)}) {
      const SurfaceDerivatives d = s.derivatives(uv);
      const SurfaceDerivatives up = s.derivatives(uv + Uv(h, 0)), um = s.derivatives(uv - Uv(h, 0));
      const SurfaceDerivatives vp = s.derivatives(uv + Uv(0, h)), vm = s.derivatives(uv - Uv(0, h));
      const double tol = 1e-6;  // 1200 h^2 / 6 and 1e-13 * 1200 / h
      EXPECT_LT(((up.S - um.S) / (2 * h) - d.Su).norm(), tol) << to_string(s.kind());
      EXPECT_LT(((vp.S - vm.S) / (2 * h) - d.Sv).norm(), tol) << to_string(s.kind());
      EXPECT_LT(((up.Su - um.Su) / (2 * h) - d.Suu).norm(), tol) << to_string(s.kind());
      EXPECT_LT(((vp.Su - vm.Su) / (2 * h) - d.Suv).norm(), tol) << to_string(s.kind());
      EXPECT_LT(((vp.Sv - vm.Sv) / (2 * h) - d.Svv).norm(), tol) << to_string(s.kind());
    }
}

TEST(Curvature, KnownSurfaces) {
  const auto at = [](const Surface& s, const Uv& uv) {
    const SurfaceDerivatives d = s.derivatives(uv);
    return curvatures(d, unit_normal(d));
  };
  const Curvatures sphere = at(Surface::sphere({}, 500), Uv(1, 0.3));
  EXPECT_NEAR(sphere.k1, -1 / 500.0, 1e-15);
  EXPECT_NEAR(sphere.k2, -1 / 500.0, 1e-15);
  const Curvatures cylinder = at(Surface::cylinder({}, 350), Uv(1, 5));
  EXPECT_NEAR(cylinder.k1, 0, 1e-15);
  EXPECT_NEAR(cylinder.k2, -1 / 350.0, 1e-15);
  EXPECT_NEAR(std::abs(cylinder.direction1.z()), 1, 1e-12);
  const double v = 0.8;  // torus: K = cos v / (r (R + r cos v)), H with the outward normal
  const Curvatures torus = at(Surface::torus({}, 1000, 200), Uv(0.2, v));
  EXPECT_NEAR(torus.gaussian, std::cos(v) / (200 * (1000 + 200 * std::cos(v))), 1e-16);
  EXPECT_NEAR(torus.mean, -0.5 * (1 / 200.0 + std::cos(v) / (1000 + 200 * std::cos(v))), 1e-15);
}

TEST(Curvature, CircleOnASphereHasItsGeodesicCurvature) {
  // A parallel at latitude b turns with kappa_g = tan b / R; walking east, the pole lies to the left (b = n x t).
  const double R = 1000, b = 0.5;
  const SurfaceDerivatives d = Surface::sphere({}, R).derivatives(Uv(0.4, b));
  EXPECT_NEAR(geodesic_curvature(d, unit_normal(d), Uv(2, 0), Uv(0, 0)), std::tan(b) / R, 1e-15);
  EXPECT_NEAR(normal_curvature(d, unit_normal(d), d.Su), -1 / R, 1e-15);
}

}  // namespace
}  // namespace afptraj
