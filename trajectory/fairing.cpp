#include "trajectory/fairing.h"

#include <cmath>

#include <ceres/ceres.h>

#include "geometry/curvature.h"
#include "geometry/error.h"
#include "geometry/geodesic.h"
#include "trajectory/apex.h"
#include "trajectory/sideways.h"

namespace afptraj {
namespace {

constexpr double most_change = 0.3;  // of a path's direction and length in one round of moves
constexpr int most_rounds = 200;

/// residual = offset + sum of coefficient_k * w_k.
template <int N>
class LinearResidual : public ceres::CostFunction {
 public:
  LinearResidual(const double (&coefficients)[N], double offset) : offset_(offset) {
    std::copy(coefficients, coefficients + N, coefficients_);
    set_num_residuals(1);
    for (int k = 0; k < N; ++k) mutable_parameter_block_sizes()->push_back(1);
  }
  bool Evaluate(double const* const* w, double* residual, double** jacobians) const override {
    residual[0] = offset_;
    for (int k = 0; k < N; ++k) {
      residual[0] += coefficients_[k] * w[k][0];
      if (jacobians && jacobians[k]) jacobians[k][0] = coefficients_[k];
    }
    return true;
  }

 private:
  double coefficients_[N];
  double offset_;
};

/// Geodesic curvature at each inner point, from the turn of the chords about the normal, and the
/// change of it by a lateral move: w'' + K w by three-point differences.
struct Bend {
  double kappa = 0;
  double coefficient[3] = {0, 0, 0};  // of w at the point before, here, after
};

/// Neighbours along a path, round the joint of a closed one: its last point is its first again.
class Neighbours {
 public:
  explicit Neighbours(const SteppedPath& path) : points_(path.points), closed_(path.closed) {}
  /// Points that move each for itself.
  std::size_t count() const { return closed_ ? points_.size() - 1 : points_.size(); }
  bool has(std::size_t i, int step) const {
    return closed_ || (step < 0 ? i >= static_cast<std::size_t>(-step) : i + static_cast<std::size_t>(step) < count());
  }
  std::size_t at(std::size_t i, int step) const {
    const auto n = static_cast<std::ptrdiff_t>(count());
    return static_cast<std::size_t>((static_cast<std::ptrdiff_t>(i) + step + n) % n);
  }
  /// From point i to the next.
  Vec3 chord(std::size_t i) const { return points_[at(i, 1)].position - points_[i].position; }

 private:
  const std::vector<SteppedPoint>& points_;
  bool closed_;
};

std::vector<Bend> measure(const Skin& skin, const SteppedPath& path) {
  const Neighbours beside(path);
  std::vector<Bend> out(beside.count());
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (!beside.has(i, -1) || !beside.has(i, 1)) continue;
    const Vec3 a = beside.chord(beside.at(i, -1)), c = beside.chord(i);
    const double h1 = std::max(a.norm(), 1e-9), h2 = std::max(c.norm(), 1e-9);
    const Vec3 n = path.points[i].normal_sign * skin.normal(path.points[i].at);
    out[i].kappa = std::atan2(a.cross(c).dot(n), a.dot(c)) / (0.5 * (h1 + h2));
    const double K = gaussian_curvature(skin.derivatives(path.points[i].at));
    out[i].coefficient[0] = 2 / (h1 * (h1 + h2));
    out[i].coefficient[2] = 2 / (h2 * (h1 + h2));
    out[i].coefficient[1] = -out[i].coefficient[0] - out[i].coefficient[2] + K;
  }
  return out;
}

/// The moves that fair the path; `moved` are those made so far, which count as distance too.
std::vector<double> solve_moves(const SteppedPath& path, const std::vector<Bend>& bends,
                                const std::vector<double>& moved, double weight, const bool (&held)[2]) {
  const Neighbours beside(path);
  const std::size_t n = beside.count();
  std::vector<double> w(n, 0.0);
  ceres::Problem problem;
  const auto gap = [&](std::size_t i) { return std::max(beside.chord(i).norm(), 1e-9); };
  for (std::size_t i = 0; i < n; ++i) {
    const double ds =
        0.5 * ((beside.has(i, -1) ? gap(beside.at(i, -1)) : 0) + (beside.has(i, 1) ? gap(i) : 0));
    const double root = std::sqrt(ds);
    const double coefficient[1] = {root};
    problem.AddResidualBlock(new LinearResidual<1>(coefficient, root * moved[i]), nullptr, &w[i]);
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (!beside.has(i, -1) || !beside.has(i, 2)) continue;
    const double scale = std::sqrt(weight / gap(i));
    const Bend &a = bends[i], &b = bends[beside.at(i, 1)];
    const double coefficient[4] = {-scale * a.coefficient[0], scale * (b.coefficient[0] - a.coefficient[1]),
                                   scale * (b.coefficient[1] - a.coefficient[2]), scale * b.coefficient[2]};
    problem.AddResidualBlock(new LinearResidual<4>(coefficient, scale * (b.kappa - a.kappa)), nullptr,
                             &w[beside.at(i, -1)], &w[i], &w[beside.at(i, 1)], &w[beside.at(i, 2)]);
  }
  if (held[0]) problem.SetParameterBlockConstant(&w.front());
  if (held[1]) problem.SetParameterBlockConstant(&w.back());
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  solver.num_threads = 1;
  solver.initial_trust_region_radius = 1e16;  // the problem is linear: one full step solves it
  solver.max_num_iterations = 5;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  if (!summary.IsSolutionUsable())
    throw Error(ErrorCode::internal, "fairing of the reference path", "the least-squares solver failed: " + summary.message);
  return w;
}

/// The share of the moves that the linear model holds for: a move turns the path by w' and takes the part w kappa of
/// its length.
double share_that_holds(const SteppedPath& path, const std::vector<Bend>& bends, const std::vector<double>& w) {
  const Neighbours beside(path);
  double most = 0;
  for (std::size_t i = 0; i < w.size(); ++i) {
    most = std::max(most, std::abs(w[i] * bends[i].kappa));
    if (beside.has(i, 1))
      most = std::max(most, std::abs(w[beside.at(i, 1)] - w[i]) / std::max(beside.chord(i).norm(), 1e-9));
  }
  return std::min(1.0, most_change / most);
}

/// Turns an end at an apex to the side of its neighbour: the path arrives along a meridian.
void renew_at_apex(const Skin& skin, SteppedPoint& end, const SteppedPoint& neighbour) {
  for (const Pole& pole : poles_of(skin))
    if ((pole.point - end.position).norm() < 2 * beside_apex_mm)
      if (const auto renewed = beside_pole(skin, pole.point, neighbour.position, beside_apex_mm, neighbour)) end = *renewed;
}

}  // namespace

SteppedPath fair_path(const Skin& skin, const SteppedPath& stepped, const FairingOptions& options) {
  SteppedPath out = stepped;
  if (options.fairness <= 0 || stepped.points.size() < 5) return out;
  const double weight = options.fairness * std::pow(options.length_mm, 6);
  const bool at_apex[2] = {stepped.end[0] == WalkEnd::pole, stepped.end[1] == WalkEnd::pole};
  const GeodesicTracer tracer = sideways_tracer(skin, options.length_mm);
  std::vector<double> moved(out.points.size(), 0.0);
  int whole_rounds = 0;
  for (int round = 0; whole_rounds < 2 && round < most_rounds; ++round) {
    const std::vector<Bend> bends = measure(skin, out);
    std::vector<double> w = solve_moves(out, bends, moved, weight, at_apex);
    const double share = share_that_holds(out, bends, w);
    if (share < 1)
      for (double& move : w) move *= share;
    else
      ++whole_rounds;
    for (std::size_t i = 0; i < w.size(); ++i) {
      SteppedPoint& p = out.points[i];
      if (std::abs(w[i]) < 1e-12 || !move_sideways(tracer, p, w[i])) continue;
      moved[i] += w[i];
    }
    if (at_apex[0]) renew_at_apex(skin, out.points.front(), out.points[1]);
    if (at_apex[1]) renew_at_apex(skin, out.points.back(), out.points[out.points.size() - 2]);
    if (out.closed) out.points.back() = out.points.front();
    renew_directions(out.points, out.closed);
  }
  return out;
}

}  // namespace afptraj
