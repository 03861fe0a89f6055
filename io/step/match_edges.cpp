#include "io/step/match_edges.h"

#include <algorithm>
#include <cmath>

#include "io/step/interpolate.h"

namespace afptraj::step {
namespace {

/// The parameter in (t0, t1) where coordinate k of the pcurve passes `value`; the ends lie on
/// different sides of it. Regula falsi with the Illinois step.
double crossing(const BSplineCurve2& curve, int k, double value, double t0, double t1) {
  double f0 = curve.point(t0)[k] - value, f1 = curve.point(t1)[k] - value;
  for (int n = 0; n < 60 && t1 - t0 > 1e-15 * std::abs(t1); ++n) {
    const double t = std::clamp((f1 * t0 - f0 * t1) / (f1 - f0), t0, t1);
    const double f = curve.point(t)[k] - value;
    if (f == 0) return t;
    if ((f > 0) == (f1 > 0)) {
      t1 = t, f1 = f, f0 *= 0.5;
    } else {
      t0 = t, f0 = f, f1 *= 0.5;
    }
  }
  return 0.5 * (t0 + t1);
}

/// Parameters where the space curve may be less than smooth: knots of the pcurve, and where it
/// crosses knots of the surface.
std::vector<double> smooth_breaks(const SpaceCurve& curve) {
  std::vector<double> breaks = curve.pcurve->breaks();
  const std::vector<double> corners = breaks;
  const int pieces = curve.pcurve->degree == 1 ? 1 : 4;
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    for (int piece = 0; piece < pieces; ++piece) {
      const double t0 = corners[i] + (corners[i + 1] - corners[i]) * piece / pieces;
      const double t1 = corners[i] + (corners[i + 1] - corners[i]) * (piece + 1) / pieces;
      const Uv p = curve.pcurve->point(t0), q = curve.pcurve->point(t1);
      for (int k = 0; k < 2; ++k) {
        const std::vector<double>& knots = k == 0 ? curve.surface->breaks_u() : curve.surface->breaks_v();
        for (auto knot = std::upper_bound(knots.begin(), knots.end(), std::min(p[k], q[k]));
             knot != knots.end() && *knot < std::max(p[k], q[k]); ++knot) {
          breaks.push_back(crossing(*curve.pcurve, k, *knot, t0, t1));
        }
      }
    }
  }
  return breaks;
}

/// Sorted, without near repetitions, ends kept.
std::vector<double> tidy(std::vector<double> ts, double first, double last) {
  std::sort(ts.begin(), ts.end());
  const double least = 1e-9 * (last - first);
  std::vector<double> kept = {first};
  for (const double t : ts) {
    if (t > kept.back() + least && t < last - least) kept.push_back(t);
  }
  kept.push_back(last);
  return kept;
}

double interpolate_table(const std::vector<double>& xs, const std::vector<double>& ys, double x) {
  const auto upper = std::upper_bound(xs.begin() + 1, xs.end() - 1, x);
  const auto i = static_cast<std::size_t>(upper - xs.begin());
  const double width = xs[i] - xs[i - 1];
  return width > 0 ? ys[i - 1] + (ys[i] - ys[i - 1]) * (x - xs[i - 1]) / width : ys[i - 1];
}

/// Gauss-Newton steps end when they get this short; the next one would be shorter by the distance
/// times the curvature.
constexpr double converged_mm = 1e-12;

double refine_nearest(const SpaceCurve& curve, double t, const Vec3& p) {
  const double range = curve.last() - curve.first();
  for (int k = 0; k < 40; ++k) {
    const auto [point, d] = curve.tangent(t);
    const double squared = d.squaredNorm();
    if (!(squared > 0)) break;
    const double step = std::clamp((p - point).dot(d) / squared, -0.05 * range, 0.05 * range);
    t = std::clamp(t + step, curve.first() - 0.01 * range, curve.last() + 0.01 * range);
    if (std::abs(step) * std::sqrt(squared) <= converged_mm || std::abs(step) <= 1e-15 * range) break;
  }
  return t;
}

/// The map from the parameters of `a` to those of `b`: nearest points, corrected so that ends meet ends.
class ParameterMap {
 public:
  ParameterMap(const SpaceCurve& a, const SpaceCurve& b, bool opposite)
      : a_(a), b_(b), opposite_(opposite), samples_a_(sample_curve(a, 64)), samples_b_(sample_curve(b, 64)) {
    at_first_ = (opposite_ ? b.last() : b.first()) - nearest(a.first());
    at_last_ = (opposite_ ? b.first() : b.last()) - nearest(a.last());
  }

  double operator()(double t) const {
    if (t <= a_.first()) return opposite_ ? b_.last() : b_.first();
    if (t >= a_.last()) return opposite_ ? b_.first() : b_.last();
    const double x = (t - a_.first()) / (a_.last() - a_.first());
    return std::clamp(nearest(t) + (1 - x) * at_first_ + x * at_last_, b_.first(), b_.last());
  }

  /// The t that maps to `tau`: regula falsi with the Illinois step (the map is monotonic).
  double inverse(double tau) const {
    double lo = a_.first(), hi = a_.last();
    double f_lo = (*this)(lo)-tau, f_hi = (*this)(hi)-tau;
    if ((f_lo > 0) == (f_hi > 0)) return std::abs(f_lo) < std::abs(f_hi) ? lo : hi;
    for (int k = 0; k < 40 && hi - lo > 1e-14 * (a_.last() - a_.first()); ++k) {
      const double t = std::clamp((f_hi * lo - f_lo * hi) / (f_hi - f_lo), lo, hi);
      const double f = (*this)(t)-tau;
      if (std::abs(f) <= 1e-14 * (b_.last() - b_.first())) return t;
      if ((f > 0) == (f_hi > 0)) {
        hi = t, f_hi = f, f_lo *= 0.5;
      } else {
        lo = t, f_lo = f, f_hi *= 0.5;
      }
    }
    return 0.5 * (lo + hi);
  }

 private:
  double nearest(double t) const {
    const double part =
        interpolate_table(samples_a_.t, samples_a_.s, t) / std::max(samples_a_.length(), 1e-300);
    const double along = (opposite_ ? 1 - part : part) * samples_b_.length();
    return refine_nearest(b_, interpolate_table(samples_b_.s, samples_b_.t, along), a_.point(t));
  }

  const SpaceCurve& a_;
  const SpaceCurve& b_;
  bool opposite_;
  SampledCurve samples_a_, samples_b_;
  double at_first_ = 0, at_last_ = 0;
};

BSplineCurve2 affine(const BSplineCurve2& curve, double first, double last, bool opposite) {
  BSplineCurve2 result = curve;
  const double a = curve.first(), b = curve.last();
  for (double& knot : result.knots) {
    const double x = opposite ? (b - knot) / (b - a) : (knot - a) / (b - a);
    knot = knot == (opposite ? b : a)   ? first
           : knot == (opposite ? a : b) ? last
                                        : first + x * (last - first);
  }
  if (opposite) {
    std::reverse(result.knots.begin(), result.knots.end());
    std::reverse(result.poles.begin(), result.poles.end());
    std::reverse(result.weights.begin(), result.weights.end());
  }
  return result;
}

/// Errors of interpolated pcurves, in space.
constexpr double error_mm = 1e-9;

/// Rounding of (u, v) on a curve, with room for what the search for nearest points adds.
double uv_rounding(const SpaceCurve& curve) {
  double far = 0;
  for (const Uv& pole : curve.pcurve->poles) far = std::max(far, pole.cwiseAbs().maxCoeff());
  return 4e-14 * far;
}

/// The error in (u, v) that shows as error_mm over [t0, t1]: where a curve is slow more is allowed.
double uv_tolerance(const SpaceCurve& curve, double t0, double t1) {
  double speed = 0;
  for (const double t : {t0, 0.5 * (t0 + t1), t1}) {
    const SurfaceDerivatives d = curve.surface->derivatives(curve.pcurve->point(t));
    speed = std::max({speed, d.Su.norm(), d.Sv.norm()});
  }
  return error_mm / std::max(speed, 1e-300);
}

/// The same for errors along the trace of the pcurve only.
double uv_tolerance_along(const SpaceCurve& curve, double t0, double t1) {
  double speed = 0;
  for (const double t : {t0, 0.5 * (t0 + t1), t1}) {
    const double uv_speed = curve.pcurve->derivatives(t).d1.norm();
    if (uv_speed > 0) speed = std::max(speed, curve.tangent(t).derivative.norm() / uv_speed);
  }
  return error_mm / std::max(speed, 1e-300);
}
constexpr int most_cells = 400;

double trace_distance(const SpaceCurve& a, const SpaceCurve& b, double t) {
  const Vec3 p = a.point(t);
  return (b.point(nearest_parameter(b, sample_curve(b, 128), p)) - p).norm();
}

/// The foot of `p` on a surface from a near start; Gauss-Newton, enough where p is near the surface.
Uv foot(const Surface& surface, const Vec3& p, Uv uv) {
  for (int k = 0; k < 20; ++k) {
    const SurfaceDerivatives d = surface.derivatives(uv);
    const double e = d.Su.squaredNorm(), f = d.Su.dot(d.Sv), g = d.Sv.squaredNorm();
    const double determinant = e * g - f * f;
    if (!(determinant > 1e-12 * e * g)) break;
    const Vec3 r = p - d.S;
    const double x = r.dot(d.Su), y = r.dot(d.Sv);
    const Uv step((g * x - f * y) / determinant, (e * y - f * x) / determinant);
    uv += step;
    if ((d.Su * step.x() + d.Sv * step.y()).norm() <= converged_mm) break;
  }
  return uv;
}

BSplineCurve2 with_ends(BSplineCurve2 curve, const Uv& first, const Uv& last) {
  curve.poles.front() = first;
  curve.poles.back() = last;
  return curve;
}

BSplineCurve2 along_trace(const SpaceCurve& a, const SpaceCurve& b, bool opposite) {
  const ParameterMap map(a, b, opposite);
  const double rounding = uv_rounding(b);
  std::vector<double> breaks = smooth_breaks(a);
  for (const double tau : smooth_breaks(b)) breaks.push_back(map.inverse(tau));
  breaks = tidy(std::move(breaks), a.first(), a.last());
  BSplineCurve2 curve = interpolate_curve([&](double t) { return b.pcurve->point(map(t)); }, breaks,
                                          [&](double t0, double t1) {
                                            const double tau0 = std::min(map(t0), map(t1)),
                                                         tau1 = std::max(map(t0), map(t1));
                                            return std::max(uv_tolerance_along(b, tau0, tau1), rounding);
                                          },
                                          most_cells)
                            .curve;
  return with_ends(std::move(curve), b.pcurve->point(opposite ? b.last() : b.first()),
                   b.pcurve->point(opposite ? b.first() : b.last()));
}

}  // namespace

SpaceCurve::Tangent SpaceCurve::tangent(double t) const {
  const auto c = pcurve->derivatives(t);
  const SurfaceDerivatives d = surface->derivatives(c.c);
  return {d.S, d.Su * c.d1.x() + d.Sv * c.d1.y()};
}

SampledCurve sample_curve(const SpaceCurve& curve, int pieces) {
  SampledCurve samples;
  samples.lo = Vec3::Constant(1e300), samples.hi = Vec3::Constant(-1e300);
  for (int k = 0; k <= pieces; ++k) {
    const double t = k == pieces ? curve.last() : curve.first() + (curve.last() - curve.first()) * k / pieces;
    const Vec3 p = curve.point(t);
    samples.s.push_back(k == 0 ? 0 : samples.s.back() + (p - samples.points.back()).norm());
    samples.t.push_back(t);
    samples.points.push_back(p);
    samples.lo = samples.lo.cwiseMin(p), samples.hi = samples.hi.cwiseMax(p);
  }
  return samples;
}

double nearest_parameter(const SpaceCurve& curve, const SampledCurve& samples, const Vec3& p) {
  std::size_t best = 0;
  double least = 1e300;
  for (std::size_t i = 0; i < samples.points.size(); ++i) {
    if (const double d = (samples.points[i] - p).squaredNorm(); d < least) least = d, best = i;
  }
  return refine_nearest(curve, samples.t[best], p);
}

Gap greatest_gap(const SpaceCurve& a, const SpaceCurve& b) {
  std::vector<double> breaks = a.pcurve->breaks();
  const std::vector<double> more = b.pcurve->breaks();
  breaks.insert(breaks.end(), more.begin(), more.end());
  breaks = tidy(std::move(breaks), a.first(), a.last());
  Gap gap;
  const auto look = [&](double t) {
    if (const double d = (a.point(t) - b.point(t)).norm(); d > gap.distance) gap = {d, t};
  };
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
    for (int k = 0; k < 8; ++k) look(breaks[i] + (breaks[i + 1] - breaks[i]) * k / 8);
  }
  look(a.last());
  return gap;
}

BSplineCurve2 in_parameters_of(const SpaceCurve& a, const SpaceCurve& b, bool opposite) {
  constexpr double good_mm = 1e-9;     // rounding at the size of parts
  constexpr double visible_mm = 1e-6;  // below this a foot instead of the file's own pcurve brings nothing
  BSplineCurve2 best = affine(*b.pcurve, a.first(), a.last(), opposite);
  Gap gap = greatest_gap(a, {b.surface, &best});
  if (gap.distance <= good_mm) return best;
  const auto take = [&](BSplineCurve2 other, double factor) {
    const Gap after = greatest_gap(a, {b.surface, &other});
    if (after.distance > factor * gap.distance) return;
    best = std::move(other);
    gap = after;
  };
  const double off_trace = trace_distance(a, b, gap.t);
  if (off_trace < 0.5 * gap.distance) take(along_trace(a, b, opposite), 0.7);
  if (gap.distance > visible_mm &&
      foot_distance(*b.surface, a.point(gap.t), best.point(gap.t)) < 0.7 * gap.distance) {
    take(pcurve_of_feet([&](double t) { return a.point(t); }, smooth_breaks(a), {b.surface, &best}), 0.7);
  }
  return best;
}

double foot_distance(const Surface& surface, const Vec3& point, const Uv& start) {
  return (surface.point(foot(surface, point, start)) - point).norm();
}

BSplineCurve2 pcurve_of_feet(const std::function<Vec3(double)>& curve, const std::vector<double>& breaks,
                             const SpaceCurve& seed) {
  const Uv first = seed.pcurve->point(seed.first()), last = seed.pcurve->point(seed.last());
  const Uv at_first = first - foot(*seed.surface, curve(seed.first()), first);
  const Uv at_last = last - foot(*seed.surface, curve(seed.last()), last);
  const double rounding = uv_rounding(seed);
  BSplineCurve2 result = *seed.pcurve;
  // Twice, because where the curve crosses the knots of the surface is known only from the first.
  for (const double loosen : {1e4, 1.0}) {
    const BSplineCurve2 start = result;
    std::vector<double> all = smooth_breaks({seed.surface, &start});
    all.insert(all.end(), breaks.begin(), breaks.end());
    const auto feet = [&](double t) {
      const double x = (t - seed.first()) / (seed.last() - seed.first());
      return Uv(foot(*seed.surface, curve(t), start.point(t)) + (1 - x) * at_first + x * at_last);
    };
    const auto tolerance = [&](double t0, double t1) {
      return loosen * std::max(uv_tolerance({seed.surface, &start}, t0, t1), rounding);
    };
    result =
        interpolate_curve(feet, tidy(std::move(all), seed.first(), seed.last()), tolerance, most_cells).curve;
  }
  return with_ends(std::move(result), first, last);
}

std::pair<BSplineCurve2, BSplineCurve2> split_curve(const BSplineCurve2& curve, double t) {
  // Boehm's insertion in homogeneous coordinates until `t` has multiplicity degree.
  const int p = curve.degree;
  std::vector<double> knots = curve.knots;
  std::vector<Vec3> poles;
  for (std::size_t i = 0; i < curve.poles.size(); ++i) {
    const double w = curve.weights.empty() ? 1 : curve.weights[i];
    poles.push_back({w * curve.poles[i].x(), w * curve.poles[i].y(), w});
  }
  while (std::count(knots.begin(), knots.end(), t) < p) {
    const auto k =
        static_cast<std::size_t>(std::upper_bound(knots.begin(), knots.end(), t) - knots.begin()) - 1;
    const auto degree = static_cast<std::size_t>(p);
    std::vector<Vec3> finer(poles.size() + 1);
    for (std::size_t i = 0; i < finer.size(); ++i) {
      if (i + degree <= k) {
        finer[i] = poles[i];
      } else if (i > k) {
        finer[i] = poles[i - 1];
      } else {
        const double width = knots[i + degree] - knots[i];
        const double x = width > 0 ? (t - knots[i]) / width : 0;
        finer[i] = x * poles[i] + (1 - x) * poles[i - 1];
      }
    }
    poles = std::move(finer);
    knots.insert(knots.begin() + static_cast<std::ptrdiff_t>(k) + 1, t);
  }
  const auto begin =
      static_cast<std::size_t>(std::lower_bound(knots.begin(), knots.end(), t) - knots.begin());
  const auto end = static_cast<std::size_t>(std::upper_bound(knots.begin(), knots.end(), t) - knots.begin());
  const auto build = [&](std::vector<double> ks, std::size_t first, std::size_t count) {
    BSplineCurve2 part;
    part.degree = p;
    part.knots = std::move(ks);
    for (std::size_t i = first; i < first + count; ++i) {
      part.poles.push_back(poles[i].head<2>() / poles[i].z());
      if (!curve.weights.empty()) part.weights.push_back(poles[i].z());
    }
    return part;
  };
  std::vector<double> left(knots.begin(), knots.begin() + static_cast<std::ptrdiff_t>(end));
  left.push_back(t);
  std::vector<double> right(knots.begin() + static_cast<std::ptrdiff_t>(begin), knots.end());
  right.insert(right.begin(), t);
  const std::size_t left_count = left.size() - static_cast<std::size_t>(p) - 1;
  const std::size_t right_count = right.size() - static_cast<std::size_t>(p) - 1;
  return {build(std::move(left), 0, left_count),
          build(std::move(right), poles.size() - right_count, right_count)};
}

}  // namespace afptraj::step
