#include "geometry/bspline_curve.h"

#include <algorithm>
#include <cmath>

namespace afptraj {

int find_span(const std::vector<double>& knots, int degree, double t) {
  const auto begin = knots.begin() + degree;
  const auto end = knots.end() - degree;  // one past last()
  auto it = std::upper_bound(begin, end, t);
  int span = static_cast<int>(it - knots.begin()) - 1;
  span = std::clamp(span, degree, static_cast<int>(knots.size()) - degree - 2);
  while (span > degree && knots[static_cast<std::size_t>(span)] == knots[static_cast<std::size_t>(span) + 1]) --span;
  return span;
}

void basis_functions(const std::vector<double>& knots, int degree, int span, double t,
                     double out[3][max_degree + 1]) {
  // The triangle of lower-degree functions; rows p, p-1 and p-2 give the derivatives.
  double n[3][max_degree + 2] = {};  // degree p, p-1, p-2 (as they become available)
  double row[max_degree + 2] = {};
  const auto knot = [&](int i) { return knots[static_cast<std::size_t>(i)]; };
  row[0] = 1;
  for (int d = 0; d <= degree; ++d) {
    if (degree - d <= 2) std::copy(row, row + d + 1, n[degree - d]);
    if (d == degree) break;
    double saved = 0;
    for (int r = 0; r <= d; ++r) {
      const double right = knot(span + r + 1) - t;
      const double left = t - knot(span - d + r);
      const double q = row[r] / (right + left);
      row[r] = saved + right * q;
      saved = left * q;
    }
    row[d + 1] = saved;
  }
  const auto difference = [&](int p, int i) { return knot(span - degree + i + p) - knot(span - degree + i); };
  for (int i = 0; i <= degree; ++i) {
    out[0][i] = n[0][i];
    out[1][i] = out[2][i] = 0;
  }
  if (degree < 1) return;
  // First derivative: N' = p (N_{i,p-1}/(t_{i+p}-t_i) - N_{i+1,p-1}/(t_{i+p+1}-t_{i+1})).
  const auto lower = [&](int level, int i, int p) { return i >= 0 && i <= p ? n[level][i] : 0.0; };
  for (int i = 0; i <= degree; ++i) {
    double d1 = 0, d2 = 0;
    const double a = i > 0 ? degree / difference(degree, i) : 0;
    const double b = i < degree ? degree / difference(degree, i + 1) : 0;
    d1 = a * lower(1, i - 1, degree - 1) - b * lower(1, i, degree - 1);
    if (degree >= 2) {
      const auto derivative_of_lower = [&](int j) {  // of the (p-1) function with index j in 0..p-1 (local)
        // local index j of degree p-1 is function span-(p-1)+j = (span-degree)+(j+1)
        const double c = j > 0 ? (degree - 1) / difference(degree - 1, j + 1) : 0;
        const double e = j < degree - 1 ? (degree - 1) / difference(degree - 1, j + 2) : 0;
        return c * lower(2, j - 1, degree - 2) - e * lower(2, j, degree - 2);
      };
      if (i > 0) d2 += a * derivative_of_lower(i - 1);
      if (i < degree) d2 -= b * derivative_of_lower(i);
    }
    out[1][i] = d1;
    out[2][i] = d2;
  }
}

template <int D>
typename BSplineCurve<D>::Derivatives BSplineCurve<D>::derivatives(double t) const {
  const int span = find_span(knots, degree, t);
  double n[3][max_degree + 1];
  basis_functions(knots, degree, span, t, n);
  Point a[3] = {Point::Zero(), Point::Zero(), Point::Zero()};
  double w[3] = {1, 0, 0};
  if (!weights.empty()) w[0] = 0;
  for (int i = 0; i <= degree; ++i) {
    const auto index = static_cast<std::size_t>(span - degree + i);
    const double weight = weights.empty() ? 1 : weights[index];
    for (int d = 0; d < 3; ++d) {
      a[d] += n[d][i] * weight * poles[index];
      if (!weights.empty()) w[d] += n[d][i] * weight;
    }
  }
  Derivatives out;
  out.c = a[0] / w[0];
  out.d1 = (a[1] - w[1] * out.c) / w[0];
  out.d2 = (a[2] - 2 * w[1] * out.d1 - w[2] * out.c) / w[0];
  return out;
}

template <int D>
std::vector<double> BSplineCurve<D>::breaks() const {
  std::vector<double> out(knots.begin() + degree, knots.end() - degree);
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

BSplineCurve2 line_segment(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double t0, double t1) {
  BSplineCurve2 line;
  line.degree = 1;
  line.knots = {t0, t0, t1, t1};
  line.poles = {a, b};
  return line;
}

template struct BSplineCurve<2>;
template struct BSplineCurve<3>;

}  // namespace afptraj
