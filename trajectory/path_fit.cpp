#include "trajectory/path_fit.h"

#include <algorithm>
#include <cmath>

#include <ceres/ceres.h>

#include "geometry/curvature.h"
#include "geometry/error.h"
#include "trajectory/fairing.h"
#include "trajectory/path_runs.h"

namespace afptraj {
namespace {

/// Distance of the curve from a point, in the metric of the surface there: linear in the poles.
class PointResidual : public ceres::SizedCostFunction<2, 2, 2, 2, 2> {
 public:
  PointResidual(const double* basis, const Uv& uv, const Eigen::Matrix2d& root) : uv_(uv), root_(root) {
    std::copy(basis, basis + 4, basis_);
  }
  bool Evaluate(double const* const* poles, double* residual, double** jacobians) const override {
    Uv c = -uv_;
    for (int k = 0; k < 4; ++k) c += basis_[k] * Uv(poles[k][0], poles[k][1]);
    Eigen::Map<Eigen::Vector2d> r(residual);
    r = root_ * c;
    if (jacobians)
      for (int k = 0; k < 4; ++k)
        if (jacobians[k]) {
          Eigen::Map<Eigen::Matrix<double, 2, 2, Eigen::RowMajor>> J(jacobians[k]);
          J = root_ * basis_[k];
        }
    return true;
  }

 private:
  double basis_[4];
  Uv uv_;
  Eigen::Matrix2d root_;
};

/// Second difference of three poles: a weak hold that keeps the system well posed.
class BendResidual : public ceres::SizedCostFunction<2, 2, 2, 2> {
 public:
  explicit BendResidual(const Eigen::Matrix2d& root) : root_(root) {}
  bool Evaluate(double const* const* poles, double* residual, double** jacobians) const override {
    static constexpr double weight[3] = {1, -2, 1};
    Uv sum = Uv::Zero();
    for (int k = 0; k < 3; ++k) {
      sum += weight[k] * Uv(poles[k][0], poles[k][1]);
      if (jacobians && jacobians[k]) {
        Eigen::Map<Eigen::Matrix<double, 2, 2, Eigen::RowMajor>> J(jacobians[k]);
        J = weight[k] * root_;
      }
    }
    Eigen::Map<Eigen::Vector2d> r(residual);
    r = root_ * sum;
    return true;
  }

 private:
  Eigen::Matrix2d root_;
};

/// The basis of a cubic at one parameter.
struct Site {
  int span = 3;
  double basis[3][max_degree + 1];
};

/// Sine of the angle between the curve's end and a wanted tangent.
struct TangentResidual {
  const Skin* skin;
  const PathChart* chart;
  Uv inward;  ///< to the run's side, where the end stands on a crease
  Site site;
  Vec3 tangent;
  double weight;
  bool operator()(const double* p0, const double* p1, const double* p2, const double* p3, double* residual) const {
    const double* poles[4] = {p0, p1, p2, p3};
    Uv c = Uv::Zero(), d1 = Uv::Zero();
    for (int k = 0; k < 4; ++k) {
      c += site.basis[0][k] * Uv(poles[k][0], poles[k][1]);
      d1 += site.basis[1][k] * Uv(poles[k][0], poles[k][1]);
    }
    const SurfaceDerivatives d = chart->place(*skin, c, inward).d;
    const Vec3 n = unit_normal(d);
    const Vec3 velocity = uv_to_tangent(d, d1);
    const Vec3 wanted = (tangent - tangent.dot(n) * n).normalized();
    residual[0] = velocity.norm() > 0 && !n.isZero() ? weight * velocity.normalized().cross(wanted).dot(n) : 0;
    return std::isfinite(residual[0]);
  }
};

BSplineCurve2 uniform_cubic(double t0, double t1, int spans) {
  BSplineCurve2 curve;
  curve.degree = 3;
  curve.knots.assign(4, t0);
  for (int i = 1; i < spans; ++i) curve.knots.push_back(t0 + (t1 - t0) * i / spans);
  curve.knots.insert(curve.knots.end(), 4, t1);
  curve.poles.resize(static_cast<std::size_t>(spans + 3));
  return curve;
}

Site site_at(const BSplineCurve2& curve, double t) {
  Site site;
  site.span = find_span(curve.knots, 3, t);
  basis_functions(curve.knots, 3, site.span, t, site.basis);
  return site;
}

Uv interpolate(const Run& run, double t) {
  const auto it = std::upper_bound(run.t.begin(), run.t.end(), t);
  const auto i = static_cast<std::size_t>(
      std::clamp<std::ptrdiff_t>(it - run.t.begin() - 1, 0, static_cast<std::ptrdiff_t>(run.t.size()) - 2));
  const double x = (t - run.t[i]) / (run.t[i + 1] - run.t[i]);
  return (1 - x) * run.at[i] + x * run.at[i + 1];
}

/// The matrix R with |R d|^2 = I(d, d): R^T R is the first fundamental form.
Eigen::Matrix2d metric_root(const SurfaceDerivatives& d) {
  const FirstForm I = first_form(d);
  const double a = std::sqrt(std::max(I.E, 1e-300));
  Eigen::Matrix2d root;
  root << a, I.F / a, 0, std::sqrt(std::max(I.G - I.F * I.F / (a * a), 0.0));
  return root;
}

BSplineCurve2 fit_run(const Skin& skin, const Run& run, const FitOptions& options) {
  const double length = run.t.back() - run.t.front();
  const int by_spacing = static_cast<int>(std::ceil(length / options.knot_spacing_mm));
  const int by_points = static_cast<int>(run.t.size()) / 3;
  const int spans = std::max(1, std::min(by_spacing, by_points));
  BSplineCurve2 curve = uniform_cubic(run.t.front(), run.t.back(), spans);
  const std::size_t count = curve.poles.size();
  for (std::size_t i = 0; i < count; ++i)  // Greville abscissae: the curve starts on the polyline
    curve.poles[i] = interpolate(run, (curve.knots[i + 1] + curve.knots[i + 2] + curve.knots[i + 3]) / 3);

  std::vector<double> poles(2 * count);
  for (std::size_t i = 0; i < count; ++i) {
    poles[2 * i] = curve.poles[i].x();
    poles[2 * i + 1] = curve.poles[i].y();
  }
  ceres::Problem problem;
  const auto block = [&](int i) { return poles.data() + 2 * i; };
  for (std::size_t i = 0; i < count; ++i) problem.AddParameterBlock(poles.data() + 2 * i, 2);
  for (std::size_t i = 0; i < run.t.size(); ++i) {
    const Site site = site_at(curve, run.t[i]);
    const double ds = 0.5 * (run.t[std::min(i + 1, run.t.size() - 1)] - run.t[i > 0 ? i - 1 : 0]);
    const Eigen::Matrix2d root = metric_root(run.chart.place(skin, run.at[i]).d) * std::sqrt(ds);
    const int k = site.span - 3;
    problem.AddResidualBlock(new PointResidual(site.basis[0], run.at[i], root), nullptr, block(k), block(k + 1),
                             block(k + 2), block(k + 3));
  }
  // Poles that few points see are held by the least bending of the control polygon.
  for (int j = 0; j + 2 < static_cast<int>(count); ++j) {
    const Eigen::Matrix2d root = metric_root(run.chart.place(skin, curve.poles[static_cast<std::size_t>(j) + 1]).d);
    problem.AddResidualBlock(new BendResidual(1e-6 * root), nullptr, block(j), block(j + 1), block(j + 2));
  }
  for (int end = 0; end < 2; ++end) {
    if (!run.fixed[end]) continue;
    const int pole = end == 0 ? 0 : static_cast<int>(count) - 1;
    const Uv& at = end == 0 ? run.at.front() : run.at.back();
    block(pole)[0] = at.x();
    block(pole)[1] = at.y();
    problem.SetParameterBlockConstant(block(pole));
    if (run.tangent[end].isZero()) continue;
    const Uv inward = (end == 0 ? run.at[1] : run.at[run.at.size() - 2]) - at;
    const double t = end == 0 ? run.t.front() : run.t.back();
    const Site site = site_at(curve, t);
    const int k = site.span - 3;
    problem.AddResidualBlock(
        new ceres::NumericDiffCostFunction<TangentResidual, ceres::CENTRAL, 1, 2, 2, 2, 2>(
            new TangentResidual{&skin, &run.chart, inward, site, run.tangent[end], 1e4}),
        nullptr, block(k), block(k + 1), block(k + 2), block(k + 3));
  }
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  solver.num_threads = 1;
  solver.max_num_iterations = 50;
  solver.function_tolerance = 1e-12;
  solver.parameter_tolerance = 1e-12;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  if (!summary.IsSolutionUsable())
    throw Error(ErrorCode::internal, "fit of the reference path", "the least-squares solver failed: " + summary.message);
  for (std::size_t i = 0; i < count; ++i) curve.poles[i] = Uv(poles[2 * i], poles[2 * i + 1]);
  return curve;
}

/// Greatest and mean distance of points from the polyline of a path, across it.
void measure_deviation(const SteppedPath& from, const SteppedPath& to, PathFit& out) {
  double sum = 0;
  for (std::size_t i = 0; i < from.points.size() && i < to.points.size(); ++i) {
    Vec3 miss = from.points[i].position - to.points[i].position;
    const Vec3& along = to.points[i].direction;
    miss -= miss.dot(along) * along;
    sum += miss.squaredNorm();
    out.max_mm = std::max(out.max_mm, miss.norm());
  }
  out.rms_mm = std::sqrt(sum / static_cast<double>(from.points.size()));
}

/// Distance of a run's points from its spline, across it.
double spline_deviation(const Skin& skin, const Run& run, const BSplineCurve2& curve) {
  double worst = 0;
  for (std::size_t i = 0; i < run.t.size(); ++i) {
    const auto c = curve.derivatives(run.t[i]);
    const SurfaceDerivatives d = run.chart.place(skin, c.c).d;
    const Vec3 tangent = uv_to_tangent(d, c.d1).normalized();
    Vec3 miss = run.chart.place(skin, run.at[i]).d.S - d.S;
    miss -= miss.dot(tangent) * tangent;  // along the path only the parameter differs
    worst = std::max(worst, miss.norm());
  }
  return worst;
}

}  // namespace

PathFit fit_path(const Skin& skin, const SteppedPath& stepped, const FitOptions& options) {
  FairingOptions fairing;
  fairing.fairness = options.fairness;
  fairing.length_mm = options.length_mm;
  const SteppedPath fair = fair_path(skin, stepped, fairing);
  PathFit out;
  measure_deviation(stepped, fair, out);
  std::vector<SplinePath::Piece> pieces;
  double spline_mm = 0;
  for (const Run& run : split_runs(skin, fair, options.knot_spacing_mm, options.length_mm)) {
    pieces.push_back({run.chart, fit_run(skin, run, options)});
    spline_mm = std::max(spline_mm, spline_deviation(skin, run, pieces.back().curve));
  }
  out.max_mm += spline_mm;
  out.spline_mm = spline_mm;
  out.path = std::make_shared<const SplinePath>(skin, std::move(pieces), stepped.closed);
  return out;
}

}  // namespace afptraj
