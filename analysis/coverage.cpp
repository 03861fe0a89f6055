#include <algorithm>
#include <cmath>

#include <tbb/parallel_for.h>

#include "analysis/course_index.h"
#include "analysis/judge_ply.h"
#include "geometry/curvature.h"

namespace afptraj {
namespace {

struct Judged {
  AreaSample sample;
  Vec3 position = Vec3::Zero();
  bool covered = true;
  double distance_mm = 0;
};

double greatest_curvature(const SurfaceDerivatives& d, const Vec3& n) {
  if (n.isZero()) return 0;
  const Curvatures c = curvatures(d, n);
  return std::max(std::abs(c.k1), std::abs(c.k2));
}

Judged judge(const Skin& skin, const GeodesicTracer& tracer, const LaidCurves& laid, const AreaSample& sample,
             double half_width) {
  Judged out{sample, skin.point(sample.at), true, 0};
  const SurfaceDerivatives d = skin.derivatives(sample.at);
  const Vec3 n = skin.normal(sample.at);
  const double chord = laid.distance(out.position, n, 2.5 * half_width);
  out.distance_mm = chord;
  if (chord >= half_width) {
    out.covered = false;
    return out;
  }
  // An arc of curvature k over a chord c is longer by at most k^2 c^3 / 24 (k c < 1), doubled for a
  // curvature that grows along the way.
  const double k = greatest_curvature(d, n);
  if (k * chord < 1 && chord + k * k * chord * chord * chord / 12 < half_width) return out;
  const auto near = laid.rival(tracer, out.position, n, half_width, -1, 0, 0);
  out.covered = near.has_value();
  return out;
}

std::vector<AreaSample> spread_samples(const Skin& skin, int count) {
  std::vector<AreaSample> out;
  for (int f : skin.faces()) {
    double area = 0;
    for (const AreaSample& s : area_samples(skin.part(), f, skin.trim(f), 400)) area += s.area_mm2;
    const int share = std::max(100, static_cast<int>(std::lround(count * area / skin.area())));
    const auto samples = area_samples(skin.part(), f, skin.trim(f), share);
    out.insert(out.end(), samples.begin(), samples.end());
  }
  return out;
}

/// Gathers uncovered samples that lie within a band of each other.
std::vector<UncoveredSpot> gather(const std::vector<Judged>& judged, double band_width) {
  std::vector<const Judged*> open;
  for (const Judged& j : judged)
    if (!j.covered) open.push_back(&j);
  std::vector<int> group(open.size(), -1);
  int groups = 0;
  for (std::size_t i = 0; i < open.size(); ++i) {
    if (group[i] >= 0) continue;
    std::vector<std::size_t> stack = {i};
    group[i] = groups;
    while (!stack.empty()) {
      const std::size_t at = stack.back();
      stack.pop_back();
      for (std::size_t j = 0; j < open.size(); ++j)
        if (group[j] < 0 && (open[j]->position - open[at]->position).norm() < band_width) {
          group[j] = groups;
          stack.push_back(j);
        }
    }
    ++groups;
  }
  std::vector<UncoveredSpot> out(static_cast<std::size_t>(groups));
  for (std::size_t i = 0; i < open.size(); ++i) {
    UncoveredSpot& spot = out[static_cast<std::size_t>(group[i])];
    spot.area_mm2 += open[i]->sample.area_mm2;
    if (open[i]->distance_mm > spot.distance_mm) {
      spot.distance_mm = open[i]->distance_mm;
      spot.where = open[i]->position;
    }
  }
  for (UncoveredSpot& spot : out)
    spot.reason = spot.distance_mm < band_width
                      ? "between courses that end or meet here: another course would overlap them"
                      : "no geodesic from the reference path reaches this place";
  std::sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.area_mm2 > b.area_mm2; });
  return out;
}

}  // namespace

Coverage measure_coverage(const Skin& skin, const Ply& ply, const JudgeOptions& options) {
  GeodesicOptions geodesic;
  geodesic.tolerance_mm = options.tolerance_mm;
  geodesic.outside_limit_mm = skin.diagonal();
  geodesic.margin_mm = options.band_width_mm;
  const GeodesicTracer tracer(skin, geodesic);
  const double half = 0.5 * options.band_width_mm;
  const CourseIndex index(skin, ply, options.band_width_mm, [](const Course&) { return true; });
  const std::vector<AreaSample> samples = spread_samples(skin, options.area_samples);
  std::vector<Judged> judged(samples.size());
  tbb::parallel_for(std::size_t{0}, samples.size(), [&](std::size_t i) {
    judged[i] = judge(skin, tracer, index.laid(), samples[i], half);
  });
  Coverage out;
  double all = 0, covered = 0;
  for (const Judged& j : judged) {
    all += j.sample.area_mm2;
    if (j.covered) covered += j.sample.area_mm2;
  }
  out.covered_share = all > 0 ? covered / all : 0;
  out.uncovered = gather(judged, options.band_width_mm);
  return out;
}

}  // namespace afptraj
