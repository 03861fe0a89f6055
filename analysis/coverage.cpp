#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>

#include <tbb/parallel_for.h>

#include "analysis/course_index.h"
#include "analysis/judge_ply.h"
#include "geometry/curvature.h"

namespace afptraj {
namespace {

constexpr int no_course = std::numeric_limits<int>::min();

struct Judged {
  AreaSample sample;
  Vec3 position = Vec3::Zero();
  bool covered = true;
  double distance_mm = 0;
  int strip_of = no_course;  ///< the course off the skin whose band reaches it
};

double greatest_curvature(const SurfaceDerivatives& d, const Vec3& n) {
  if (n.isZero()) return 0;
  const Curvatures c = curvatures(d, n);
  return std::max(std::abs(c.k1), std::abs(c.k2));
}

/// Whether a curve passes within `half_width` of the sample, along the skin.
bool is_covered(const Skin& skin, const GeodesicTracer& tracer, const LaidCurves& laid, const SurfacePoint& at,
                double half_width, double* distance_mm) {
  const SurfaceDerivatives d = skin.derivatives(at);
  const Vec3 n = skin.normal(at);
  const double chord = laid.distance(d.S, n, 2.5 * half_width);
  if (distance_mm) *distance_mm = chord;
  if (chord >= half_width) return false;
  // An arc of curvature k over a chord c is longer by at most k^2 c^3 / 24 (k c < 1), doubled for a
  // curvature that grows along the way.
  const double k = greatest_curvature(d, n);
  if (k * chord < 1 && chord + k * k * chord * chord * chord / 12 < half_width) return true;
  return laid.rival(tracer, d.S, n, half_width, -1, 0, 0).has_value();
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

/// Gathers uncovered samples that lie within a band of each other and have the same cause.
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
        if (group[j] < 0 && open[j]->strip_of == open[at]->strip_of &&
            (open[j]->position - open[at]->position).norm() < band_width) {
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
    if (open[i]->distance_mm <= spot.distance_mm) continue;
    spot.distance_mm = open[i]->distance_mm;
    spot.where = open[i]->position;
    const int course = open[i]->strip_of;
    if (course != no_course)
      spot.reason = "strip at the boundary: the centre line of course " + std::string(course > 0 ? "+" : "") +
                    std::to_string(course) + " runs off the skin there, its band reaches in";
    else if (spot.distance_mm < band_width)
      spot.reason = "courses end or meet here, and the rest is narrower than a band";
    else
      spot.reason = "no geodesic from the reference path reaches this place";
  }
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
  const double W = options.band_width_mm;
  const CourseIndex index(skin, ply.courses, W, [](const Course&) { return true; });
  std::map<int, std::unique_ptr<CourseIndex>> strips;
  for (const Course& course : ply.off_skin) {
    auto& strip = strips[course.number];
    strip = std::make_unique<CourseIndex>(skin, ply.off_skin, W, [&](const Course& c) { return c.number == course.number; });
  }
  const std::vector<AreaSample> samples = spread_samples(skin, options.area_samples);
  std::vector<Judged> judged(samples.size());
  tbb::parallel_for(std::size_t{0}, samples.size(), [&](std::size_t i) {
    Judged& out = judged[i];
    out.sample = samples[i];
    out.position = skin.point(samples[i].at);
    out.covered = is_covered(skin, tracer, index.laid(), samples[i].at, W / 2, &out.distance_mm);
    if (out.covered) return;
    for (const auto& [number, strip] : strips)
      if (is_covered(skin, tracer, strip->laid(), samples[i].at, W / 2, nullptr)) {
        out.strip_of = number;
        break;
      }
  });
  Coverage out;
  double all = 0, covered = 0, reached = 0;
  for (const Judged& j : judged) {
    all += j.sample.area_mm2;
    if (j.covered) covered += j.sample.area_mm2;
    if (j.covered || j.strip_of != no_course) reached += j.sample.area_mm2;
  }
  out.covered_share = all > 0 ? covered / all : 0;
  out.reached_share = all > 0 ? reached / all : 0;
  out.uncovered = gather(judged, W);
  return out;
}

}  // namespace afptraj
