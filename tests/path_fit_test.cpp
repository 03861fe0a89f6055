#include "trajectory/path_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/curvature.h"
#include "tests/specimens.h"
#include "trajectory/fairing.h"

namespace afptraj {
namespace {

/// A path of stepped points every 2 mm over `length`, along a geodesic from (u, v), each moved sideways by
/// `offset(s)`.
template <typename Offset>
SteppedPath path_beside_geodesic(const Skin& skin, const Uv& from, const Vec3& direction, double length,
                                 Offset offset) {
  const GeodesicTracer tracer(skin, {});
  GeodesicState g = tracer.start({0, from}, direction);
  SteppedPath path;
  for (double s = 0; s <= length; s += 2) {
    const PathFrame f = frame_of(skin, g);
    SteppedPoint p{g.at, f.position, f.tangent, 1, s};
    if (const double w = offset(s); w != 0) {
      GeodesicState side = tracer.start(g.at, std::copysign(1.0, w) * f.left());
      EXPECT_EQ(tracer.advance(side, std::abs(w)), TraceEnd::reached);
      p.at = side.at;
      p.position = skin.point(side.at);
    }
    path.points.push_back(p);
    EXPECT_EQ(tracer.advance(g, 2), TraceEnd::reached);
  }
  return path;
}

/// Noise as a measured table of directions gives it: no two neighbours alike, the same in every run.
auto noise(double size) {
  return [size, rng = std::mt19937(11)](double) mutable {
    return std::uniform_real_distribution<double>(-size, size)(rng);
  };
}

/// The waves of a path between ply points: 120 mm long.
auto waves(double size) {
  return [size](double s) { return size * std::sin(2 * pi * s / 120); };
}

/// The integral of (d kappa_g / ds)^2 over the path, from its exact curvature every 2 mm.
double curvature_variation(const SourceCurve& path) {
  const int count = static_cast<int>((path.last() - path.first()) / 2);
  const double dt = (path.last() - path.first()) / count;
  double sum = 0, before = path.at(path.first()).kg_per_mm;
  for (int i = 1; i <= count; ++i) {
    const SourceCurve::Frame f = path.at(path.first() + i * dt);
    const double ds = f.speed * dt;
    sum += (f.kg_per_mm - before) * (f.kg_per_mm - before) / ds;
    before = f.kg_per_mm;
  }
  return sum;
}

/// Distance of p from the path: along the tangent to the foot, from t.
double distance(const SourceCurve& path, const Vec3& p, double t) {
  for (int iteration = 0; iteration < 50; ++iteration) {
    const SourceCurve::Frame f = path.at(t);
    const double dt = (p - f.frame.position).dot(f.frame.tangent) / f.speed;
    const double next = std::clamp(t + dt, path.first(), path.last());
    if (std::abs(next - t) < 1e-11) break;
    t = next;
  }
  return (p - path.at(t).frame.position).norm();
}

struct Residual {
  double rms = 0, max = 0;
};
Residual residual_of(const SourceCurve& path, const SteppedPath& stepped) {
  Residual out;
  double t = 0;
  for (std::size_t i = 0; i < stepped.points.size(); ++i) {
    if (i > 0) t += (stepped.points[i].position - stepped.points[i - 1].position).norm();
    const double d = distance(path, stepped.points[i].position, t);
    out.max = std::max(out.max, d);
    out.rms += d * d;
  }
  out.rms = std::sqrt(out.rms / static_cast<double>(stepped.points.size()));
  return out;
}

const Uv from(0.1, 0.4);
const Vec3 direction(1, 0.15, 0);

FitOptions with_fairness(double fairness) {
  FitOptions o;
  o.fairness = fairness;
  return o;
}

// What is reported is what is found on the path itself. The points are measured from the faired points, and
// the spline's deviation from those is added to the maximum: so the maximum is a bound, and neither is off by
// more than the spline's deviation, to the second order of the slopes (noise / step, some 1e-2 here).
TEST(PathFit, ReportsTheResidualThatIsThere) {
  const Skin skin = make_skin(gentle_surface(), {0, 1}, {0, 1});
  for (const double size : {0.02, 0.2}) {
    const SteppedPath stepped = path_beside_geodesic(skin, from, direction, 700, noise(size));
    for (const double fairness : {0.0, 1e-6, 1e-3, 1.0}) {
      const PathFit fit = fit_path(skin, stepped, with_fairness(fairness));
      const Residual found = residual_of(*fit.path, stepped);
      const double slack = fit.spline_mm + 0.01 * found.max;
      EXPECT_NEAR(fit.rms_mm, found.rms, slack) << size << " " << fairness;
      EXPECT_LE(found.max, fit.max_mm * (1 + 1e-6)) << size << " " << fairness;
      EXPECT_NEAR(fit.max_mm, found.max, fit.spline_mm + slack) << size << " " << fairness;
      EXPECT_GE(fit.max_mm, fit.spline_mm);
    }
  }
}

// Waves of 120 mm: smooth enough for the spline, so the residual is that of the fairing alone.
TEST(PathFit, ReportsHowFarItMovedWaves) {
  const Skin skin = make_skin(gentle_surface(), {0, 1}, {0, 1});
  const SteppedPath stepped = path_beside_geodesic(skin, from, direction, 700, waves(1));
  const PathFit fit = fit_path(skin, stepped, with_fairness(1e-3));
  const Residual found = residual_of(*fit.path, stepped);
  EXPECT_GT(found.max, 0.3);
  EXPECT_LT(fit.spline_mm, 0.01);
  EXPECT_NEAR(fit.rms_mm, found.rms, fit.spline_mm + 0.005 * found.rms);
  EXPECT_NEAR(fit.max_mm, found.max, 2 * fit.spline_mm + 0.005 * found.max);
}

// The variation of the curvature falls as the weight grows, and the residual grows: the two sides of a
// least-squares balance.
TEST(PathFit, FairsANoisyPath) {
  const Skin skin = make_skin(gentle_surface(), {0, 1}, {0, 1});
  const SteppedPath stepped = path_beside_geodesic(skin, from, direction, 700, noise(0.2));
  double variation = curvature_variation(*fit_path(skin, stepped, with_fairness(0)).path), rms = 0;
  const double raw = variation;
  for (const double fairness : {1e-7, 1e-5, 1e-3, 1e-1}) {
    const PathFit fit = fit_path(skin, stepped, with_fairness(fairness));
    const double now = curvature_variation(*fit.path);
    EXPECT_LT(now, 0.5 * variation) << fairness;
    EXPECT_GT(fit.rms_mm, rms) << fairness;
    variation = now, rms = fit.rms_mm;
  }
  // White noise of +-0.2 has an rms of 0.115; a fair path goes through its middle.
  EXPECT_LT(rms, 0.13);
  EXPECT_LT(variation, 1e-6 * raw);
}

// The answer to a wave of length l: w'' and w''' turn the balance into 1 : fairness length^6 (2 pi / l)^6, so
// that share of the wave is taken away. On a plane, where the balance is exact; in the middle, away from the
// ends.
TEST(PathFit, DampsAWaveByItsSixthPower) {
  const Skin skin = make_skin(Surface::plane({}), {-1000, 3000}, {-500, 500});
  for (const double wave : {100.0, 150.0, 250.0}) {
    const SteppedPath stepped = path_beside_geodesic(
        skin, Uv(0, 0), Vec3(1, 0, 0), 2000, [&](double s) { return 0.1 * std::sin(2 * pi * s / wave); });
    FairingOptions options;
    const SteppedPath fair = fair_path(skin, stepped, options);
    const double load = options.fairness * std::pow(options.length_mm * 2 * pi / wave, 6);
    double most = 0;
    for (const SteppedPoint& p : fair.points)
      if (p.position.x() > 700 && p.position.x() < 1300) most = std::max(most, std::abs(p.position.y()));
    // Three-point differences over 2 mm are off by (2 pi 2 / wave)^2 / 12, thrice in the third derivative;
    // the samples miss the crest by as much; slopes of 6e-3 count squared.
    const double relative = std::pow(4 * pi / wave, 2) + 1e-4;
    EXPECT_NEAR(most, 0.1 / (1 + load), 0.1 / (1 + load) * relative) << wave;
  }
}

// An arc of constant kappa_g is left where it is, and so is a geodesic; without weight every path is.
TEST(PathFit, LeavesAFairPathAlone) {
  const Skin plate = make_skin(Surface::plane({}), {-1000, 1000}, {-1000, 1000});
  SteppedPath arc;
  for (int i = 0; i <= 400; ++i) {
    const double a = 2.0 * i / 700;
    SteppedPoint p;
    p.at = {0, 700 * Uv(std::cos(a), std::sin(a))};
    p.position = plate.point(p.at);
    p.direction = Vec3(-std::sin(a), std::cos(a), 0);
    p.s_mm = 2.0 * i;
    arc.points.push_back(p);
  }
  for (const SteppedPoint& p : fair_path(plate, arc, {}).points) EXPECT_NEAR(p.position.norm(), 700, 1e-9);

  const Skin skin = make_skin(gentle_surface(), {0, 1}, {0, 1});
  const SteppedPath geodesic = path_beside_geodesic(skin, from, direction, 700, [](double) { return 0; });
  const SteppedPath fair = fair_path(skin, geodesic, {});
  // The turn of the chords about the normal is kappa_g to O(h^2): h^2 / 12 times a product of three
  // curvatures, some 1e-10 here, which moves a wave of W by W^2 times that.
  double most = 0;
  for (std::size_t i = 0; i < fair.points.size(); ++i)
    most = std::max(most, (fair.points[i].position - geodesic.points[i].position).norm());
  EXPECT_LT(most, 1e-6);

  FairingOptions none;
  none.fairness = 0;
  const SteppedPath noisy = path_beside_geodesic(skin, from, direction, 700, noise(0.2));
  const SteppedPath same = fair_path(skin, noisy, none);
  for (std::size_t i = 0; i < same.points.size(); ++i)
    EXPECT_EQ(same.points[i].position, noisy.points[i].position);
}

// The faired points stay on the skin and keep their order; the spline begins and ends where they do.
TEST(PathFit, KeepsTheEndsAndTheOrder) {
  const Skin skin = make_skin(gentle_surface(), {0, 1}, {0, 1});
  const SteppedPath stepped = path_beside_geodesic(skin, from, direction, 700, waves(1));
  const SteppedPath fair = fair_path(skin, stepped, {});
  for (std::size_t i = 0; i < fair.points.size(); ++i) {
    EXPECT_LT((skin.point(fair.points[i].at) - fair.points[i].position).norm(), 1e-12);
    if (i == 0) continue;
    EXPECT_GT((fair.points[i].position - fair.points[i - 1].position).dot(fair.points[i].direction), 0);
    EXPECT_GT(fair.points[i].s_mm, fair.points[i - 1].s_mm);
  }
  const PathFit fit = fit_path(skin, stepped, {});
  EXPECT_FALSE(fit.path->closed());
  EXPECT_LE((fit.path->at(fit.path->first()).frame.position - fair.points.front().position).norm(),
            fit.spline_mm + 1e-6);
  EXPECT_LE((fit.path->at(fit.path->last()).frame.position - fair.points.back().position).norm(),
            fit.spline_mm + 1e-6);
}

/// A ring round a cylinder of radius 350 at height 500 + offset, from angle `start` on, in some 1100 chords.
template <typename Offset>
SteppedPath ring(const Skin& skin, int start, Offset offset) {
  constexpr int n = 1100;
  SteppedPath path;
  path.closed = true;
  for (int i = 0; i <= n; ++i) {
    const int k = (start + i) % n;
    SteppedPoint p;
    p.at = {0, Uv(2 * pi * k / n, 500 + offset(k))};
    p.position = skin.point(p.at);
    p.direction = skin.derivatives(p.at).Su.normalized();
    p.s_mm = 350 * 2 * pi * i / n;
    path.points.push_back(p);
  }
  return path;
}

// A closed path has no ends: faired from another start it is the same, and its spline is smooth at the joint too.
TEST(PathFit, OfAClosedPathKnowsNoStart) {
  const Skin skin = make_skin(Surface::cylinder({}, 350), {0, 2 * pi}, {0, 1000});
  std::vector<double> offsets;
  auto random = noise(0.2);
  for (int k = 0; k < 1100; ++k) offsets.push_back(random(0));
  const auto offset = [&](int k) { return offsets[static_cast<std::size_t>(k)]; };
  const SteppedPath a = fair_path(skin, ring(skin, 0, offset), {}), b = fair_path(skin, ring(skin, 417, offset), {});
  double most = 0;
  for (std::size_t k = 0; k < 1100; ++k) {
    // The least-squares solver sums in another order: its condition times rounding.
    EXPECT_NEAR((a.points[(k + 417) % 1100].position - b.points[k].position).norm(), 0, 1e-7) << k;
    most = std::max(most, std::abs(b.points[k].position.z() - 500));
  }
  // Waves shorter than 2 pi 50.8 fairness^(1/6) = 101 mm are taken away, of all above 4 mm: 0.115 rms of white noise
  // become 0.023, and 4 times that are not passed in some 20 such waves.
  EXPECT_LT(most, 0.092);
  EXPECT_EQ(a.points.front().position, a.points.back().position);

  const PathFit fit = fit_path(skin, ring(skin, 417, offset), with_fairness(0));
  const SourceCurve::Frame first = fit.path->at(fit.path->first()), last = fit.path->at(fit.path->last() - 1e-9);
  EXPECT_LT((first.frame.position - last.frame.position).norm(), 1e-8);  // 1e-9 mm before the joint
  // The direction is held by least squares with a weight of 1e4.
  EXPECT_LT((first.frame.tangent - last.frame.tangent).norm(), 1e-6);
}

// A plane in strips of 8 to 30 mm, each with the same range of v: the speed of v jumps from one to the next. A straight
// path that crosses the lines between at 5 degrees stays straight.
TEST(PathFit, KeepsAStraightPathStraightOverLinesOfMereContinuity) {
  BSplineSurface s;
  s.degree_u = 1;
  s.degree_v = 3;
  s.knots_u = {0, 0, 1, 1};
  const std::vector<double> lines = {0, 10, 40, 48, 73};
  s.knots_v.push_back(0);
  for (std::size_t k = 0; k < lines.size(); ++k) s.knots_v.insert(s.knots_v.end(), 3, static_cast<double>(k));
  s.knots_v.push_back(static_cast<double>(lines.size() - 1));
  for (const double y : {0.0, 700.0})
    for (std::size_t k = 0; k + 1 < lines.size(); ++k)
      for (int j = k == 0 ? 0 : 1; j <= 3; ++j) s.poles.emplace_back(lines[k] + j * (lines[k + 1] - lines[k]) / 3, y, 0);
  const Skin skin = make_skin(Surface::bspline(s), {0, 1}, {0, 4});
  const double angle = 5 * pi / 180;
  const SteppedPath stepped =
      path_beside_geodesic(skin, Uv(0.01, 0.3), Vec3(std::sin(angle), std::cos(angle), 0), 650, [](double) { return 0.0; });
  const PathFit fit = fit_path(skin, stepped, with_fairness(1e-3));
  double worst = 0;
  for (double t = fit.path->first(); t < fit.path->last(); t += 0.1)
    worst = std::max(worst, std::abs(fit.path->at(t).kg_per_mm));
  EXPECT_LT(worst, 1e-6);
}

}  // namespace
}  // namespace afptraj
