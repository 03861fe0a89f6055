#include "trajectory/path_fit.h"

#include <algorithm>
#include <cmath>

#include <ceres/ceres.h>

#include "geometry/curvature.h"
#include "geometry/error.h"
#include "trajectory/fairing.h"

namespace afptraj {
namespace {

/// The points of the path on one chart, with the crossing points at its ends.
struct Run {
  int face = -1;
  int normal_sign = 1;
  std::vector<double> t;
  std::vector<Uv> uv;
  bool fixed[2] = {false, false};        // the end is a crossing point
  Vec3 tangent[2] = {Vec3::Zero(), Vec3::Zero()};
};

/// Where the step from p to q leaves p's chart, and where it arrives on the next one.
struct Passage {
  SurfacePoint out, in;
  int normal_sign = 1;
};

bool same_chart(const Skin& skin, const SteppedPoint& p, const SteppedPoint& q) {
  if (p.at.face != q.at.face || crease_between(skin.face(p.at.face).surface, p.at.uv, q.at.uv)) return false;
  // The straight (u, v) segment must be as long on the surface as the step in space.
  const SurfaceDerivatives d = skin.derivatives({p.at.face, 0.5 * (p.at.uv + q.at.uv)});
  const double along = uv_to_tangent(d, q.at.uv - p.at.uv).norm();
  return along < 1.5 * (q.position - p.position).norm() + 1e-9;
}

/// Where the straight way over the surface from p to q crosses a line on which the parametrisation is only
/// continuous, from a guess on it: as far along the line as both sides laid flat say. A segment in (u, v) crosses it
/// elsewhere, as the speeds of the parametrisation on the two sides differ.
Uv straight_crossing(const Surface& surface, const CreaseCrossing& crease, Uv uv, const Vec3& p, const Vec3& q) {
  const int along = 1 - crease.axis;
  for (int iteration = 0; iteration < 20; ++iteration) {
    const SurfaceDerivatives d = surface.derivatives(uv);
    const Vec3 line = along == 0 ? d.Su : d.Sv;
    const Vec3 e = line.normalized(), to_p = p - d.S, to_q = q - d.S;
    const double off_p = to_p.cross(e).norm(), off_q = to_q.cross(e).norm();
    const double move = (to_p.dot(e) * off_q + to_q.dot(e) * off_p) / (off_p + off_q);
    if (!std::isfinite(move / line.norm())) break;
    uv[along] += move / line.norm();
    if (std::abs(move) < 1e-9) break;
  }
  return uv;
}

/// Follows the segment p -> q over edges to q's chart; at most a few faces lie between.
std::vector<Passage> passages(const Skin& skin, const SteppedPoint& p, const SteppedPoint& q) {
  std::vector<Passage> out;
  SurfacePoint at = p.at;
  Vec3 carried = p.normal_sign * skin.normal(p.at);
  for (int hop = 0; hop < 8; ++hop) {
    const Surface& surface = skin.face(at.face).surface;
    const SurfaceDerivatives d = surface.derivatives(at.uv);
    Uv seed = at.uv + tangent_to_uv(d, q.position - d.S);
    if (!seed.allFinite()) seed = at.uv;
    const auto foot = foot_point(surface, q.position, seed);
    const UvCubic path = UvCubic::line(at.uv, foot ? *foot : seed);
    const auto hit = skin.trim(at.face).first_crossing(path, true);
    const auto crease = crease_between(surface, at.uv, path.point(1));
    if (crease && (!hit || crease->x < hit->x)) {
      Uv uv = at.uv + crease->x * (path.point(1) - at.uv);
      uv[crease->axis] = crease->value;
      uv = straight_crossing(surface, *crease, uv, d.S, q.position);
      out.push_back({{at.face, uv}, {at.face, uv}, skin.normal(at).dot(carried) >= 0 ? 1 : -1});
      at.uv = uv;
      SteppedPoint here{at, skin.point(at), Vec3::Zero(), 1, 0};
      if (same_chart(skin, here, q)) return out;
      continue;
    }
    if (!hit) return out;
    const EdgeUse use{at.face, hit->loop, hit->coedge};
    Passage passage;
    passage.out = {at.face, hit->uv};
    if (!skin.mate(use)) return out;
    passage.in = skin.across(use, hit->t, surface.point(hit->uv));
    const Vec3 n = skin.normal(passage.in);
    passage.normal_sign = n.dot(carried) >= 0 ? 1 : -1;
    if (!n.isZero()) carried = passage.normal_sign * n;
    out.push_back(passage);
    at = passage.in;
    SteppedPoint here{at, skin.point(at), Vec3::Zero(), 1, 0};
    if (same_chart(skin, here, q)) return out;
  }
  return out;
}

/// Splits the path into charts and puts the passages between them.
std::vector<Run> split_runs(const Skin& skin, const SteppedPath& stepped) {
  const auto& points = stepped.points;
  std::vector<double> t(points.size(), 0.0);
  for (std::size_t i = 1; i < points.size(); ++i)
    t[i] = t[i - 1] + (points[i].position - points[i - 1].position).norm();
  std::vector<Run> runs;
  const auto open_run = [&](int face, int sign) {
    runs.emplace_back();
    runs.back().face = face;
    runs.back().normal_sign = sign;
  };
  const auto add = [&](double at, const Uv& uv) {
    runs.back().t.push_back(at);
    runs.back().uv.push_back(uv);
  };
  open_run(points[0].at.face, points[0].normal_sign);
  add(t[0], points[0].at.uv);
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (!same_chart(skin, points[i - 1], points[i])) {
      const auto between = passages(skin, points[i - 1], points[i]);
      const Vec3 along = (points[std::min(i + 1, points.size() - 1)].position -
                          points[i >= 2 ? i - 2 : 0].position).normalized();
      for (const Passage& passage : between) {
        const Vec3 x = skin.point(passage.out);
        const double a = (x - points[i - 1].position).norm(), b = (points[i].position - x).norm();
        const double at = t[i - 1] + (t[i] - t[i - 1]) * a / std::max(a + b, 1e-12);
        // A stepped point on the very edge would make a span of no length: the passage replaces it.
        while (runs.back().t.size() > 1 && at - runs.back().t.back() < 1e-3) {
          runs.back().t.pop_back();
          runs.back().uv.pop_back();
        }
        add(std::max(at, runs.back().t.back() + 1e-6), passage.out.uv);
        const double reached = runs.back().t.back();
        runs.back().fixed[1] = true;
        runs.back().tangent[1] = along;
        open_run(passage.in.face, passage.normal_sign);
        add(reached, passage.in.uv);
        runs.back().fixed[0] = true;
        runs.back().tangent[0] = along;
      }
      if (between.empty()) open_run(points[i].at.face, points[i].normal_sign);
    }
    if (!runs.back().t.empty() && t[i] - runs.back().t.back() < 1e-3 && i + 1 < points.size()) continue;
    add(runs.back().t.empty() ? t[i] : std::max(t[i], runs.back().t.back() + 1e-6), points[i].at.uv);
  }
  if (stepped.closed) {
    const Vec3 along = (points[1].position - points[points.size() - 2].position).normalized();
    runs.front().fixed[0] = runs.back().fixed[1] = true;
    runs.front().tangent[0] = runs.back().tangent[1] = along;
  }
  // A run of a single point (a touch of a chart) carries no curve.
  std::erase_if(runs, [](const Run& r) { return r.t.size() < 2; });
  return runs;
}

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
  const Face* face;
  Span span;  ///< the run's side, where the end stands on a line of mere continuity
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
    const SurfaceDerivatives d = face->surface.derivatives(span, c);
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
  return (1 - x) * run.uv[i] + x * run.uv[i + 1];
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
  const Face& face = skin.face(run.face);
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
    const Eigen::Matrix2d root = metric_root(face.surface.derivatives(run.uv[i])) * std::sqrt(ds);
    const int k = site.span - 3;
    problem.AddResidualBlock(new PointResidual(site.basis[0], run.uv[i], root), nullptr, block(k), block(k + 1),
                             block(k + 2), block(k + 3));
  }
  // Poles that few points see are held by the least bending of the control polygon.
  for (int j = 0; j + 2 < static_cast<int>(count); ++j) {
    const Eigen::Matrix2d root = metric_root(face.surface.derivatives(curve.poles[static_cast<std::size_t>(j) + 1]));
    problem.AddResidualBlock(new BendResidual(1e-6 * root), nullptr, block(j), block(j + 1), block(j + 2));
  }
  for (int end = 0; end < 2; ++end) {
    if (!run.fixed[end]) continue;
    const int pole = end == 0 ? 0 : static_cast<int>(count) - 1;
    const Uv& uv = end == 0 ? run.uv.front() : run.uv.back();
    block(pole)[0] = uv.x();
    block(pole)[1] = uv.y();
    problem.SetParameterBlockConstant(block(pole));
    if (run.tangent[end].isZero()) continue;
    const Span span = face.surface.span_at(uv, (end == 0 ? run.uv[1] : run.uv[run.uv.size() - 2]) - uv);
    const double t = end == 0 ? run.t.front() : run.t.back();
    const Site site = site_at(curve, t);
    const int k = site.span - 3;
    problem.AddResidualBlock(
        new ceres::NumericDiffCostFunction<TangentResidual, ceres::CENTRAL, 1, 2, 2, 2, 2>(
            new TangentResidual{&face, span, site, run.tangent[end], 1e4}),
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

}  // namespace

namespace {

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
  const Surface& surface = skin.face(run.face).surface;
  for (std::size_t i = 0; i < run.t.size(); ++i) {
    const auto c = curve.derivatives(run.t[i]);
    const SurfaceDerivatives d = surface.derivatives(c.c);
    const Vec3 tangent = uv_to_tangent(d, c.d1).normalized();
    Vec3 miss = surface.point(run.uv[i]) - d.S;
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
  for (const Run& run : split_runs(skin, fair)) {
    pieces.push_back({run.face, run.normal_sign, fit_run(skin, run, options)});
    spline_mm = std::max(spline_mm, spline_deviation(skin, run, pieces.back().curve));
  }
  out.max_mm += spline_mm;
  out.spline_mm = spline_mm;
  out.path = std::make_shared<const SplinePath>(skin, std::move(pieces), stepped.closed);
  return out;
}

}  // namespace afptraj
