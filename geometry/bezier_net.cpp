#include "geometry/bezier_net.h"

#include <cmath>

#include "geometry/bezier.h"

namespace afptraj::bezier {

std::vector<SpanMatrix> span_matrices(const std::vector<double>& knots, int degree) {
  std::vector<SpanMatrix> result;
  std::vector<Eigen::VectorXd> unit;
  for (int i = 0; i <= degree; ++i) unit.push_back(Eigen::VectorXd::Unit(degree + 1, i));
  for (int span = degree; span + degree + 1 < static_cast<int>(knots.size()); ++span) {
    const double lo = knots[static_cast<std::size_t>(span)], hi = knots[static_cast<std::size_t>(span) + 1];
    if (!(lo < hi)) continue;
    const std::vector<Eigen::VectorXd> rows = from_span(knots, degree, span, unit);
    SpanMatrix m{lo, hi, span - degree, static_cast<int>(result.size()),
                 Eigen::MatrixXd(degree + 1, degree + 1)};
    for (int i = 0; i <= degree; ++i) m.to_bezier.row(i) = rows[static_cast<std::size_t>(i)].transpose();
    result.push_back(std::move(m));
  }
  return result;
}

Net bezier_net(const BSplineSurface& s, const SpanMatrix& u, const SpanMatrix& v) {
  const int p = s.degree_u, q = s.degree_v;
  Net half(static_cast<std::size_t>((p + 1) * (q + 1)), Eigen::Vector4d::Zero());
  Net net = half;
  for (int i = 0; i <= p; ++i) {
    for (int k = 0; k <= q; ++k) {
      const auto pole = static_cast<std::size_t>((u.first_pole + i) * s.count_v() + v.first_pole + k);
      const double w = s.weights.empty() ? 1 : s.weights[pole];
      const Eigen::Vector4d h = (Eigen::Vector4d() << w * s.poles[pole], w).finished();
      for (int j = 0; j <= q; ++j) half[static_cast<std::size_t>(i * (q + 1) + j)] += v.to_bezier(j, k) * h;
    }
  }
  for (int i = 0; i <= p; ++i) {
    for (int k = 0; k <= p; ++k) {
      const double w = u.to_bezier(i, k);
      for (int j = 0; j <= q; ++j) {
        net[static_cast<std::size_t>(i * (q + 1) + j)] += w * half[static_cast<std::size_t>(k * (q + 1) + j)];
      }
    }
  }
  return net;
}

Net split_net(Net& net, int p, int q, bool along_u) {
  Net lower(net.size());
  const int lines = along_u ? q + 1 : p + 1;
  const int count = along_u ? p + 1 : q + 1;
  std::vector<Eigen::Vector4d> line(static_cast<std::size_t>(count));
  for (int l = 0; l < lines; ++l) {
    const auto at = [&](int k) {
      return static_cast<std::size_t>(along_u ? k * (q + 1) + l : l * (q + 1) + k);
    };
    for (int k = 0; k < count; ++k) line[static_cast<std::size_t>(k)] = net[at(k)];
    const std::vector<Eigen::Vector4d> low = split_half(line);
    for (int k = 0; k < count; ++k) {
      lower[at(k)] = low[static_cast<std::size_t>(k)];
      net[at(k)] = line[static_cast<std::size_t>(k)];
    }
  }
  return lower;
}

std::vector<double> shifts(double period, double lo, double hi, double box_lo, double box_hi) {
  if (period <= 0) return {0.0};
  std::vector<double> result;
  const int first = static_cast<int>(std::ceil((box_lo - hi) / period - 1e-9));
  const int last = static_cast<int>(std::floor((box_hi - lo) / period + 1e-9));
  for (int k = first; k <= last; ++k) result.push_back(k * period);
  return result;
}

}  // namespace afptraj::bezier
