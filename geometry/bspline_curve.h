#pragma once

#include <vector>

#include <Eigen/Core>

namespace afptraj {

/// A B-spline curve of the plane (D = 2: a pcurve, or a course in (u, v)) or of space (D = 3).
///
/// Knots are flat (repeated, size poles + degree + 1) and clamped; `weights` is empty for a
/// non-rational curve, else one positive weight a pole. The domain is [first(), last()]; outside
/// of it the end polynomial is extrapolated.
/// Source: Piegl & Tiller, The NURBS Book, algorithms A2.1, A2.3, A4.2.
template <int D>
struct BSplineCurve {
  using Point = Eigen::Matrix<double, D, 1>;
  struct Derivatives {
    Point c, d1, d2;
  };

  int degree = 1;
  std::vector<double> knots;
  std::vector<Point> poles;
  std::vector<double> weights;

  double first() const { return knots[static_cast<std::size_t>(degree)]; }
  double last() const { return knots[knots.size() - 1 - static_cast<std::size_t>(degree)]; }
  Point point(double t) const { return derivatives(t).c; }
  Derivatives derivatives(double t) const;
  /// The distinct knots from first() to last().
  std::vector<double> breaks() const;
};

using BSplineCurve2 = BSplineCurve<2>;
using BSplineCurve3 = BSplineCurve<3>;

/// The straight segment from `a` to `b` over t in [t0, t1].
BSplineCurve2 line_segment(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double t0 = 0, double t1 = 1);

extern template struct BSplineCurve<2>;
extern template struct BSplineCurve<3>;

/// Values, first and second derivatives of the degree + 1 B-spline basis functions that do not
/// vanish on knot span `span` (knots[span] <= t < knots[span + 1]); `out[d][i]` is the d-th
/// derivative of function span - degree + i. Requires degree <= 25 (`max_degree`).
inline constexpr int max_degree = 25;
void basis_functions(const std::vector<double>& knots, int degree, int span, double t,
                     double out[3][max_degree + 1]);
/// The span of `t`, ends included: the last non-empty span with knots[span] <= t, clamped to the domain.
int find_span(const std::vector<double>& knots, int degree, double t);

}  // namespace afptraj
