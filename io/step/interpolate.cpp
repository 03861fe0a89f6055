#include "io/step/interpolate.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

namespace afptraj::step {
namespace {

constexpr int top = interpolation_degree;
using Matrix = Eigen::MatrixXd;

double bernstein(int n, int i, double t) {
  double value = 1;
  for (int k = 1; k <= i; ++k) value *= static_cast<double>(n - i + k) / k;
  return value * std::pow(t, i) * std::pow(1 - t, n - i);
}

/// Nodes in [0, 1] and the matrices that turn values at the nodes into Bernstein and Chebyshev
/// coefficients, for one degree.
struct Basis {
  std::vector<double> nodes;
  Matrix to_bernstein, to_chebyshev;
  Matrix at_probes;  ///< values between the nodes from values at the nodes
  std::vector<double> probes;

  explicit Basis(int n) {
    using LongMatrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
    for (int k = 0; k <= n; ++k) nodes.push_back(n == 0 ? 0.5 : 0.5 * (1 - std::cos(pi * k / n)));
    for (int k = 0; k < n; ++k) probes.push_back(0.5 * (1 - std::cos(pi * (k + 0.5) / n)));
    LongMatrix b(n + 1, n + 1), c(n + 1, n + 1);
    Matrix between(n, n + 1);
    for (int k = 0; k <= n; ++k) {
      const double t = nodes[static_cast<std::size_t>(k)];
      for (int i = 0; i <= n; ++i) {
        b(k, i) = bernstein(n, i, t);
        c(k, i) = std::cos(i * std::acos(std::clamp(2 * t - 1, -1.0, 1.0)));
      }
    }
    for (int k = 0; k < n; ++k) {
      for (int i = 0; i <= n; ++i) between(k, i) = bernstein(n, i, probes[static_cast<std::size_t>(k)]);
    }
    to_bernstein = b.fullPivLu().inverse().cast<double>();
    to_chebyshev = c.fullPivLu().inverse().cast<double>();
    at_probes = between * to_bernstein;
  }
};

const Basis& basis(int n) {
  static const auto all = [] {
    std::vector<Basis> made;
    for (int k = 0; k <= top; ++k) made.emplace_back(k);
    return made;
  }();
  return all[static_cast<std::size_t>(n)];
}

double at(double lo, double hi, double t) { return t <= 0 ? lo : t >= 1 ? hi : lo + t * (hi - lo); }

/// The knots of cells that meet with multiplicity `degree`.
std::vector<double> flat_knots(const std::vector<double>& breaks, int degree) {
  std::vector<double> knots;
  for (const double b : breaks) knots.insert(knots.end(), static_cast<std::size_t>(degree), b);
  knots.insert(knots.begin(), breaks.front());
  knots.push_back(breaks.back());
  return knots;
}

/// Halves the marked cells.
void split(std::vector<double>& breaks, const std::vector<bool>& marked) {
  std::vector<double> finer;
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
    finer.push_back(breaks[i]);
    if (marked[i]) finer.push_back(0.5 * (breaks[i] + breaks[i + 1]));
  }
  finer.push_back(breaks.back());
  breaks = std::move(finer);
}

/// Greatest coefficient of order above `degree` along the rows of a matrix of coefficients.
double tail(const Matrix& coefficients, int degree) {
  const auto rows = coefficients.rows() - 1 - degree;
  return rows > 0 ? coefficients.bottomRows(rows).cwiseAbs().maxCoeff() : 0;
}

/// What is known of one cell of a surface.
struct Cell {
  double error = 0;
  double tail_u = 0, tail_v = 0;                     ///< of the two highest orders: the direction to split
  std::array<double, top + 1> above_u{}, above_v{};  ///< greatest coefficient above each order
  double size = 0;
};

using Values = std::array<Matrix, 3>;

Values sample(const std::function<Vec3(double, double)>& point, const std::vector<double>& ts,
              const std::vector<double>& ss, double u0, double u1, double v0, double v1) {
  Values values;
  for (Matrix& m : values)
    m.resize(static_cast<Eigen::Index>(ts.size()), static_cast<Eigen::Index>(ss.size()));
  for (std::size_t i = 0; i < ts.size(); ++i) {
    for (std::size_t j = 0; j < ss.size(); ++j) {
      const Vec3 p = point(at(u0, u1, ts[i]), at(v0, v1, ss[j]));
      for (int k = 0; k < 3; ++k)
        values[static_cast<std::size_t>(k)](static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
            p[k];
    }
  }
  return values;
}

Cell examine(const std::function<Vec3(double, double)>& point, double u0, double u1, double v0, double v1) {
  const Basis& b = basis(top);
  const Values nodes = sample(point, b.nodes, b.nodes, u0, u1, v0, v1);
  const Values probes = sample(point, b.probes, b.probes, u0, u1, v0, v1);
  Cell cell;
  for (std::size_t k = 0; k < 3; ++k) {
    const Matrix difference = b.at_probes * nodes[k] * b.at_probes.transpose() - probes[k];
    cell.error = std::max(cell.error, difference.cwiseAbs().maxCoeff());
    const Matrix c = b.to_chebyshev * nodes[k] * b.to_chebyshev.transpose();
    cell.tail_u = std::max(cell.tail_u, tail(c, top - 2));
    cell.tail_v = std::max(cell.tail_v, tail(c.transpose(), top - 2));
    for (int d = 0; d <= top; ++d) {
      auto& above_u = cell.above_u[static_cast<std::size_t>(d)];
      auto& above_v = cell.above_v[static_cast<std::size_t>(d)];
      above_u = std::max(above_u, tail(c, d));
      above_v = std::max(above_v, tail(c.transpose(), d));
    }
    cell.size = std::max(cell.size, nodes[k].cwiseAbs().maxCoeff());
  }
  if (!std::isfinite(cell.error)) cell.error = std::numeric_limits<double>::infinity();
  return cell;
}

/// The lowest degree above which every cell has rounding only.
template <class Above>
int sufficient_degree(const std::vector<Cell>& cells, Above above, double rounding) {
  for (int d = 1; d < top; ++d) {
    if (std::all_of(cells.begin(), cells.end(),
                    [&](const Cell& c) { return (c.*above)[static_cast<std::size_t>(d)] <= rounding; }))
      return d;
  }
  return top;
}

BSplineSurface assemble(const std::function<Vec3(double, double)>& point, const std::vector<double>& us,
                        const std::vector<double>& vs, int du, int dv) {
  BSplineSurface spline;
  spline.degree_u = du, spline.degree_v = dv;
  spline.knots_u = flat_knots(us, du), spline.knots_v = flat_knots(vs, dv);
  const auto count_v = static_cast<std::size_t>(spline.count_v());
  spline.poles.resize(static_cast<std::size_t>(spline.count_u()) * count_v);
  const Basis &bu = basis(du), &bv = basis(dv);
  for (std::size_t iu = 0; iu + 1 < us.size(); ++iu) {
    for (std::size_t iv = 0; iv + 1 < vs.size(); ++iv) {
      const Values values = sample(point, bu.nodes, bv.nodes, us[iu], us[iu + 1], vs[iv], vs[iv + 1]);
      for (std::size_t k = 0; k < 3; ++k) {
        const Matrix poles = bu.to_bernstein * values[k] * bv.to_bernstein.transpose();
        for (int i = 0; i <= du; ++i) {
          for (int j = 0; j <= dv; ++j) {
            const std::size_t row = iu * static_cast<std::size_t>(du) + static_cast<std::size_t>(i);
            const std::size_t column = iv * static_cast<std::size_t>(dv) + static_cast<std::size_t>(j);
            spline.poles[row * count_v + column][static_cast<Eigen::Index>(k)] = poles(i, j);
          }
        }
      }
    }
  }
  return spline;
}

}  // namespace

SurfaceInterpolation interpolate_surface(const std::function<Vec3(double, double)>& point,
                                         std::vector<double> breaks_u, std::vector<double> breaks_v,
                                         double tolerance, int max_cells) {
  std::map<std::tuple<double, double, double, double>, Cell> known;
  while (true) {
    std::vector<bool> split_u(breaks_u.size() - 1, false), split_v(breaks_v.size() - 1, false);
    std::vector<Cell> cells;
    double error = 0, size = 0;
    bool done = true;
    for (std::size_t i = 0; i + 1 < breaks_u.size(); ++i) {
      for (std::size_t j = 0; j + 1 < breaks_v.size(); ++j) {
        const std::tuple key{breaks_u[i], breaks_u[i + 1], breaks_v[j], breaks_v[j + 1]};
        auto found = known.find(key);
        if (found == known.end()) {
          found =
              known.emplace(key, examine(point, breaks_u[i], breaks_u[i + 1], breaks_v[j], breaks_v[j + 1]))
                  .first;
        }
        const Cell& cell = found->second;
        cells.push_back(cell);
        error = std::max(error, cell.error);
        size = std::max(size, cell.size);
        if (cell.error <= tolerance) continue;
        done = false;
        if (!(cell.tail_u < 0.1 * cell.tail_v)) split_u[i] = true;
        if (!(cell.tail_v < 0.1 * cell.tail_u)) split_v[j] = true;
      }
    }
    if (done || static_cast<int>(cells.size()) > max_cells) {
      const double rounding = 4e-15 * size;
      const int du = sufficient_degree(cells, &Cell::above_u, rounding);
      const int dv = sufficient_degree(cells, &Cell::above_v, rounding);
      return {assemble(point, breaks_u, breaks_v, du, dv), error};
    }
    split(breaks_u, split_u);
    split(breaks_v, split_v);
  }
}

namespace {

/// One polynomial piece of a curve, known by its points at the nodes.
struct CurveCell {
  double t0, t1;
  Matrix nodes;
  double error = 0, allowed = 0;
  bool good() const { return error <= allowed; }
};

Matrix sample_curve(const std::function<Uv(double)>& point, const std::vector<double>& ts, double t0,
                    double t1) {
  Matrix values(static_cast<Eigen::Index>(ts.size()), 2);
  for (std::size_t k = 0; k < ts.size(); ++k)
    values.row(static_cast<Eigen::Index>(k)) = point(at(t0, t1, ts[k])).transpose();
  return values;
}

/// The lowest degree that changes no cell by more than a small part of what it is allowed.
int sufficient_degree(const std::vector<CurveCell>& cells) {
  int degree = 1;
  for (const CurveCell& cell : cells) {
    const Matrix coefficients = basis(top).to_chebyshev * cell.nodes;
    while (degree < top && tail(coefficients, degree) > 0.02 * cell.allowed) ++degree;
  }
  return degree;
}

}  // namespace

CurveInterpolation interpolate_curve(const std::function<Uv(double)>& point, std::vector<double> breaks,
                                     const std::function<double(double, double)>& tolerance, int max_cells) {
  const Basis& b = basis(top);
  const auto examine_cell = [&](double t0, double t1) {
    CurveCell cell{t0, t1, sample_curve(point, b.nodes, t0, t1), 0, tolerance(t0, t1)};
    cell.error = (b.at_probes * cell.nodes - sample_curve(point, b.probes, t0, t1)).cwiseAbs().maxCoeff();
    return cell;
  };
  std::vector<CurveCell> cells;
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i) cells.push_back(examine_cell(breaks[i], breaks[i + 1]));
  while (static_cast<int>(cells.size()) < max_cells &&
         !std::all_of(cells.begin(), cells.end(), [](const CurveCell& c) { return c.good(); })) {
    std::vector<CurveCell> finer;
    for (CurveCell& cell : cells) {
      if (cell.good()) {
        finer.push_back(std::move(cell));
        continue;
      }
      const double middle = 0.5 * (cell.t0 + cell.t1);
      finer.push_back(examine_cell(cell.t0, middle));
      finer.push_back(examine_cell(middle, cell.t1));
    }
    cells = std::move(finer);
  }
  CurveInterpolation result;
  const Basis& low = basis(sufficient_degree(cells));
  const int degree = static_cast<int>(low.nodes.size()) - 1;
  breaks.assign(1, cells.front().t0);
  for (const CurveCell& cell : cells) {
    result.error = std::max(result.error, cell.error);
    breaks.push_back(cell.t1);
    const Matrix poles =
        low.to_bernstein * (degree == top ? cell.nodes : sample_curve(point, low.nodes, cell.t0, cell.t1));
    for (int k = result.curve.poles.empty() ? 0 : 1; k <= degree; ++k)
      result.curve.poles.push_back(poles.row(k).transpose());
  }
  result.curve.degree = degree;
  result.curve.knots = flat_knots(breaks, degree);
  return result;
}

}  // namespace afptraj::step
