#pragma once

#include <cmath>
#include <memory>
#include <random>

#include "geometry/skin.h"

namespace afptraj {

/// Surfaces and skins that several tests share.

inline Skin make_skin(const Surface& surface, const Interval& u, const Interval& v) {
  return Skin(std::make_shared<const Part>(make_rectangular_part(surface, u, v)), {0});
}

inline std::vector<double> uniform_knots(int degree, int poles) {
  std::vector<double> knots(static_cast<std::size_t>(degree), 0.0);
  const int spans = poles - degree;
  for (int i = 0; i <= spans; ++i) knots.push_back(static_cast<double>(i) / spans);
  knots.insert(knots.end(), static_cast<std::size_t>(degree), 1.0);
  return knots;
}

/// A bicubic panel over width x depth with heights z(x, y) at the poles.
template <typename Height>
Surface height_field(double width, double depth, int nu, int nv, Height z) {
  BSplineSurface s;
  s.degree_u = s.degree_v = 3;
  s.knots_u = uniform_knots(3, nu);
  s.knots_v = uniform_knots(3, nv);
  const auto greville = [](const std::vector<double>& k, int i) {
    const auto j = static_cast<std::size_t>(i);
    return (k[j + 1] + k[j + 2] + k[j + 3]) / 3;
  };
  for (int i = 0; i < nu; ++i)
    for (int j = 0; j < nv; ++j) {
      const double x = width * greville(s.knots_u, i), y = depth * greville(s.knots_v, j);
      s.poles.emplace_back(x, y, z(x, y));
    }
  return Surface::bspline(s);
}

/// 1 x 0.6 m with bumps of some 70 mm: 1/sqrt(K) falls to about 140 mm, fronts fold.
inline Surface bumpy_surface() {
  return height_field(1000, 600, 20, 20, [](double x, double y) {
    return 45 * std::sin(0.013 * x + 0.4) * std::cos(0.017 * y - 0.3) + 30 * std::cos(0.007 * x + 0.011 * y);
  });
}
inline Skin make_bumpy_skin() { return make_skin(bumpy_surface(), {0, 1}, {0, 1}); }

/// 1 x 0.6 m, gentle: no fold within the part.
inline Surface gentle_surface() {
  return height_field(1000, 600, 20, 20, [](double x, double y) {
    return 60 * std::sin(0.0045 * x + 0.2) * std::cos(0.005 * y - 0.4);
  });
}

/// A whole cylinder as a rational quadratic B-spline of four arcs (u in [0, 4], v in [0, 1]).
inline Surface nurbs_cylinder(double radius, double length) {
  BSplineSurface s;
  s.degree_u = 2;
  s.degree_v = 1;
  s.knots_u = {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4};
  s.knots_v = {0, 0, 1, 1};
  s.periodic_u = true;
  const double c = std::sqrt(0.5);
  for (int i = 0; i <= 8; ++i) {
    const double a = i * pi / 4, r = i % 2 == 0 ? radius : radius / c;
    for (int j = 0; j < 2; ++j) {
      s.poles.emplace_back(r * std::cos(a), r * std::sin(a), j * length);
      s.weights.push_back(i % 2 == 0 ? 1 : c);
    }
  }
  return Surface::bspline(s);
}

}  // namespace afptraj
