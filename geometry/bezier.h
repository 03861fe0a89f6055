#pragma once

#include <Eigen/Core>
#include <vector>

/// Bezier form of B-spline pieces: inside a piece the curve lies in the hull of its control
/// points, which gives sound bounds. Internal to this room.
namespace afptraj::bezier {

template <int N>
using Points = std::vector<Eigen::Matrix<double, N, 1>>;

/// The value of the blossom (polar form) of the polynomial on knot span `span` at `arguments`
/// (one per degree), from its degree + 1 local poles. Source: Ramshaw, Blossoms are polar forms.
template <class Point>
Point blossom(const std::vector<double>& knots, int degree, int span, std::vector<Point> poles,
              const std::vector<double>& arguments) {
  for (int r = 1; r <= degree; ++r) {
    for (int j = degree; j >= r; --j) {
      const auto i = static_cast<std::size_t>(span - degree + j);
      const double lo = knots[i];
      const double hi = knots[i + static_cast<std::size_t>(degree - r + 1)];
      const double w = (arguments[static_cast<std::size_t>(r - 1)] - lo) / (hi - lo);
      const auto k = static_cast<std::size_t>(j);
      poles[k] = (1 - w) * poles[k - 1] + w * poles[k];
    }
  }
  return poles[static_cast<std::size_t>(degree)];
}

/// Control points over [knots[span], knots[span + 1]] of the polynomial with these local poles.
template <class Point>
std::vector<Point> from_span(const std::vector<double>& knots, int degree, int span,
                             const std::vector<Point>& poles) {
  std::vector<double> arguments(static_cast<std::size_t>(degree), knots[static_cast<std::size_t>(span)]);
  std::vector<Point> control;
  control.push_back(blossom(knots, degree, span, poles, arguments));
  for (int k = degree - 1; k >= 0; --k) {
    arguments[static_cast<std::size_t>(k)] = knots[static_cast<std::size_t>(span) + 1];
    control.push_back(blossom(knots, degree, span, poles, arguments));
  }
  return control;
}

/// Splits at the middle by de Casteljau: `control` becomes the right half, the left is returned.
template <class Point>
std::vector<Point> split_half(std::vector<Point>& control) {
  const std::size_t n = control.size();
  std::vector<Point> left(n);
  for (std::size_t k = 0; k < n; ++k) {
    left[k] = control[0];
    for (std::size_t i = 0; i + k + 1 < n; ++i) control[i] = 0.5 * (control[i] + control[i + 1]);
  }
  return left;
}

/// Value and derivative at s in [0, 1].
template <class Point>
void evaluate(const Point* control, int degree, double s, Point& value, Point& derivative) {
  // The triangle is worked in place; degrees of pcurves are small, 26 is the most allowed.
  Point work[26];
  for (int i = 0; i <= degree; ++i) work[i] = control[i];
  for (int r = degree; r > 1; --r) {
    for (int i = 0; i < r; ++i) work[i] += s * (work[i + 1] - work[i]);
  }
  if (degree == 0) {
    value = work[0];
    derivative = Point::Zero();
    return;
  }
  derivative = degree * (work[1] - work[0]);
  value = work[0] + s * (work[1] - work[0]);
}

}  // namespace afptraj::bezier
