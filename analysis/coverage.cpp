#include <algorithm>
#include <cmath>
#include <limits>

#include <tbb/parallel_for.h>

#include "analysis/geodesic_way.h"
#include "analysis/judge_lines.h"
#include "geometry/curvature.h"

namespace afptraj {
namespace {

constexpr double slack_mm = 1e-3;  // bands that lie edge to edge, to the accuracy of their courses, leave no gap
constexpr int no_course = std::numeric_limits<int>::min();

struct Sample {
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

/// Finds the lines whose centre passes within W/2 of a place, along the skin.
class CoverageJudge {
 public:
  CoverageJudge(const GeodesicTracer& tracer, const std::vector<CourseLine>& lines, const ChordIndex& index,
                double half_width_mm)
      : tracer_(tracer), lines_(lines), index_(index), half_mm_(half_width_mm) {}

  /// A line on the skin, or off it, that reaches `at`; -1 where there is none.
  int reaching(const SurfacePoint& at, bool off_skin) const {
    const SurfaceDerivatives d = tracer_.skin().derivatives(at);
    const Vec3 n = tracer_.skin().normal(at);
    thread_local std::vector<ChordIndex::Hit> hits;
    index_.minima(d.S, half_mm_, [&](const CourseLine& line) { return line.off_skin == off_skin; }, hits);
    if (hits.empty()) return -1;
    // An arc of curvature k over a chord c is longer by at most k^2 c^3 / 24 (k c < 1), doubled for a
    // curvature that grows along the way.
    const double k = greatest_curvature(d, n);
    for (const ChordIndex::Hit& hit : hits) {
      const double c = hit.distance_mm;
      const bool same_side = line(hit).normals[hit.chord].dot(n) > 0.5;
      if (same_side && k * c < 1 && c + k * k * c * c * c / 12 < half_mm_) return hit.line;
    }
    for (const ChordIndex::Hit& hit : hits)
      if (reaches(hit, d.S, n)) return hit.line;
    return -1;
  }

  /// The nearest chord on the skin, or `limit_mm`.
  double chord_distance(const Vec3& p, double limit_mm) const {
    double least = limit_mm;
    index_.visit_near(p, limit_mm, [](const CourseLine& line) { return !line.off_skin; },
                      [&](const ChordIndex::Hit& hit) { least = std::min(least, hit.distance_mm); });
    return least;
  }

 private:
  const CourseLine& line(const ChordIndex::Hit& hit) const { return lines_[static_cast<std::size_t>(hit.line)]; }

  bool reaches(const ChordIndex::Hit& hit, const Vec3& p, const Vec3& n) const {
    const CourseLine& from = line(hit);
    const double t = from.t_at(hit.chord, hit.x), cosine = from.normals[hit.chord].dot(n);
    const CurveFrame foot = frame_at(tracer_.skin(), from.curve, t);
    const double side = (p - foot.frame.position).dot(foot.frame.left()) >= 0 ? 1 : -1;
    const double arc = std::max(cosine > 0.3 ? arc_of(hit.distance_mm, cosine) : half_mm_, 1e-6);
    for (const double s : {side, -side}) {
      const Way way = way_from_line(tracer_, from, {t, arc, s}, p);
      if (way.end == Way::End::foot && way.distance_mm < half_mm_) return true;
      if (way.end == Way::End::beyond_end && s == side) {
        const auto direct = way_from_point(tracer_, frame_at(tracer_.skin(), from.curve, way.t), p, arc);
        if (direct && direct->distance_mm < half_mm_) return true;
      }
      if (cosine > 0.3 && way.end != Way::End::failed) break;
    }
    return false;
  }

  const GeodesicTracer& tracer_;
  const std::vector<CourseLine>& lines_;
  const ChordIndex& index_;
  double half_mm_;
};

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
std::vector<UncoveredSpot> gather(const std::vector<Sample>& judged, double band_width) {
  std::vector<const Sample*> open;
  for (const Sample& j : judged)
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

Coverage measure_coverage(const GeodesicTracer& tracer, const std::vector<CourseLine>& lines, const ChordIndex& index,
                          const JudgeOptions& options) {
  const Skin& skin = tracer.skin();
  const double W = options.band_width_mm;
  const CoverageJudge judge(tracer, lines, index, W / 2 + slack_mm);
  const std::vector<AreaSample> samples = spread_samples(skin, options.area_samples);
  std::vector<Sample> judged(samples.size());
  tbb::parallel_for(std::size_t{0}, samples.size(), [&](std::size_t i) {
    Sample& out = judged[i];
    out.sample = samples[i];
    out.position = skin.point(samples[i].at);
    out.covered = judge.reaching(samples[i].at, false) >= 0;
    if (out.covered) return;
    out.distance_mm = judge.chord_distance(out.position, 1.25 * W);
    const int strip = judge.reaching(samples[i].at, true);
    if (strip >= 0) out.strip_of = lines[static_cast<std::size_t>(strip)].course;
  });
  Coverage out;
  double all = 0, covered = 0, reached = 0;
  for (const Sample& j : judged) {
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
