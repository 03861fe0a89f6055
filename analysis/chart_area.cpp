#include "analysis/chart_area.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace afptraj {
namespace {

constexpr int cells_across = 12;

/// Bounds of cells: knot lines, and so many between that none is wider than a share of the box.
std::vector<double> bounds(const std::vector<double>& breaks, double period, double lo, double hi) {
  std::vector<double> lines = {lo, hi};
  const double from = period > 0 ? std::floor((lo - (breaks.empty() ? 0 : breaks.front())) / period) : 0;
  const double to = period > 0 ? std::ceil((hi - (breaks.empty() ? 0 : breaks.front())) / period) : 0;
  for (double turn = from; turn <= to; ++turn)
    for (double b : breaks)
      if (const double x = b + turn * period; x > lo && x < hi) lines.push_back(x);
  std::sort(lines.begin(), lines.end());
  const double widest = (hi - lo) / cells_across, least = 1e-9 * (hi - lo);
  std::vector<double> out = {lo};
  for (double line : lines) {
    if (line - out.back() < least) continue;
    const double from_line = out.back();
    const int n = static_cast<int>(std::ceil((line - from_line) / widest - 1e-9));
    for (int i = 1; i <= n; ++i) out.push_back(i == n ? line : from_line + (line - from_line) * i / n);
  }
  return out;
}

std::size_t cell_of(const std::vector<double>& lines, double x) {
  const auto it = std::upper_bound(lines.begin(), lines.end(), x);
  const auto i = it == lines.begin() ? 0 : static_cast<std::size_t>(it - lines.begin()) - 1;
  return std::min(i, lines.size() - 2);
}

}  // namespace

ChartArea::ChartArea(const Surface& surface, const Uv& lo, const Uv& hi)
    : u_(bounds(surface.breaks_u(), surface.period_u(), lo.x(), hi.x())),
      v_(bounds(surface.breaks_v(), surface.period_v(), lo.y(), hi.y())) {
  constexpr int n = degree + 1;
  using Matrix = Eigen::Matrix<double, n, n>;
  double node[n];
  Matrix vandermonde;
  for (int i = 0; i < n; ++i) {
    node[i] = std::cos(pi * (i + 0.5) / n);  // Chebyshev
    for (int p = 0; p < n; ++p) vandermonde(i, p) = std::pow(node[i], p);
  }
  const Matrix to_powers = vandermonde.inverse();
  const std::size_t nv = v_.size() - 1;
  cells_.resize((u_.size() - 1) * nv);
  for (std::size_t i = 0; i + 1 < u_.size(); ++i) {
    double below[n] = {};  // A on the cell's lower side, by powers of x
    for (std::size_t j = 0; j < nv; ++j) {
      const double hu = 0.5 * (u_[i + 1] - u_[i]), hv = 0.5 * (v_[j + 1] - v_[j]);
      Matrix values;
      for (int a = 0; a < n; ++a)
        for (int b = 0; b < n; ++b) {
          const SurfaceDerivatives d =
              surface.derivatives(Uv(u_[i] + hu * (1 + node[a]), v_[j] + hv * (1 + node[b])));
          values(a, b) = d.Su.cross(d.Sv).norm();
        }
      const Matrix powers = to_powers * values * to_powers.transpose();
      Cell& cell = cells_[i * nv + j];
      for (int p = 0; p < n; ++p) {
        double at_low = 0, at_high = 0;
        for (int q = 0; q < n; ++q) {
          const double c = hv * powers(p, q) / (q + 1);
          cell.a[p][q + 1] = c;
          at_high += c;
          at_low += q % 2 == 0 ? -c : c;
        }
        cell.a[p][0] = below[p] - at_low;
        below[p] += at_high - at_low;
      }
      // Between Chebyshev nodes an interpolant is worst at the corners.
      double worst = 0;
      for (const double x : {-1.0, 1.0})
        for (const double y : {-1.0, 1.0}) {
          double at_corner = 0;
          for (int p = n - 1; p >= 0; --p) {
            double row = 0;
            for (int q = n - 1; q >= 0; --q) row = row * y + powers(p, q);
            at_corner = at_corner * x + row;
          }
          const SurfaceDerivatives d = surface.derivatives(surface.span_at(Uv(u_[i] + hu, v_[j] + hv)),
                                                           Uv(u_[i] + hu * (1 + x), v_[j] + hv * (1 + y)));
          worst = std::max(worst, std::abs(at_corner - d.Su.cross(d.Sv).norm()));
        }
      error_ += 4 * hu * hv * worst;
    }
  }
}

double ChartArea::value(std::size_t i, std::size_t j, const Uv& uv) const {
  const double x = 2 * (uv.x() - u_[i]) / (u_[i + 1] - u_[i]) - 1;
  const double y = 2 * (uv.y() - v_[j]) / (v_[j + 1] - v_[j]) - 1;
  const Cell& cell = cells_[i * (v_.size() - 1) + j];
  double sum = 0;
  for (int p = degree; p >= 0; --p) {
    double row = 0;
    for (int q = degree + 1; q >= 0; --q) row = row * y + cell.a[p][q];
    sum = sum * x + row;
  }
  return sum;
}

double ChartArea::within_cell(const Uv& a, const Uv& b) const {
  // A along a line is a polynomial of degree 5 + 6: Gauss-Legendre with 6 points is exact.
  static constexpr double node[3] = {0.238619186083196909, 0.661209386466264514, 0.932469514203152028};
  static constexpr double weight[3] = {0.467913934572691047, 0.360761573048138608, 0.171324492379170345};
  const Uv middle = 0.5 * (a + b), half = 0.5 * (b - a);
  const std::size_t i = cell_of(u_, middle.x()), j = cell_of(v_, middle.y());
  double sum = 0;
  for (int g = 0; g < 3; ++g)
    sum += weight[g] * (value(i, j, middle - node[g] * half) + value(i, j, middle + node[g] * half));
  return -half.x() * sum;
}

double ChartArea::along(const Uv& a, const Uv& b) const {
  if (a.x() == b.x()) return 0;
  std::vector<double> cuts;
  const auto cross = [&](const std::vector<double>& lines, double from, double to) {
    const std::size_t lo = cell_of(lines, std::min(from, to)), hi = cell_of(lines, std::max(from, to));
    for (std::size_t k = lo + 1; k <= hi; ++k)
      if (const double x = (lines[k] - from) / (to - from); x > 0 && x < 1) cuts.push_back(x);
  };
  cross(u_, a.x(), b.x());
  cross(v_, a.y(), b.y());
  if (cuts.empty()) return within_cell(a, b);
  std::sort(cuts.begin(), cuts.end());
  cuts.push_back(1);
  double sum = 0;
  Uv from = a;
  for (const double x : cuts) {
    const Uv to = x == 1 ? b : Uv(a + x * (b - a));
    sum += within_cell(from, to);
    from = to;
  }
  return sum;
}

}  // namespace afptraj
