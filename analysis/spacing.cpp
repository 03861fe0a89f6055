#include <cmath>
#include <map>
#include <memory>

#include <tbb/parallel_for.h>

#include "analysis/course_index.h"
#include "analysis/judge_ply.h"
#include "boundary/clip.h"

namespace afptraj {
namespace {

struct Probe {
  int course;
  CurveFrame at;
};

std::vector<Probe> probes_of(const Skin& skin, const Ply& ply, int count) {
  std::vector<Probe> all;
  for (const Course& course : ply.courses) {
    if (course.number == 0) continue;
    for (const CourseSegment& segment : course.segments) {
      const SurfaceCurve curve = curve_of(skin, segment);
      for (const auto& piece : curve.pieces)
        for (std::size_t i = 0; i + 1 < piece.size(); ++i) all.push_back({course.number, frame_at(skin, piece, i, 0.5)});
    }
  }
  const std::size_t stride = std::max<std::size_t>(1, all.size() / static_cast<std::size_t>(std::max(1, count)));
  std::vector<Probe> out;
  for (std::size_t i = stride / 2; i < all.size(); i += stride) out.push_back(all[i]);
  return out;
}

}  // namespace

SpacingError measure_spacing(const Skin& skin, const Ply& ply, const JudgeOptions& options) {
  GeodesicOptions geodesic;
  geodesic.tolerance_mm = options.tolerance_mm;
  geodesic.outside_limit_mm = skin.diagonal();
  geodesic.margin_mm = options.band_width_mm;
  const GeodesicTracer tracer(skin, geodesic);
  const double W = options.band_width_mm;
  const std::vector<Probe> probes = probes_of(skin, ply, options.spacing_samples);
  std::map<int, std::unique_ptr<CourseIndex>> parents;
  for (const Probe& probe : probes) {
    const int parent = probe.course > 0 ? probe.course - 1 : probe.course + 1;
    auto& index = parents[parent];
    if (index) continue;
    const auto is_parent = [&](const Course& c) { return c.number == parent; };
    index = std::make_unique<CourseIndex>(skin, ply.courses, W, is_parent);
    index->add(skin, ply.off_skin, is_parent);
  }
  std::vector<double> errors(probes.size(), -1);
  tbb::parallel_for(std::size_t{0}, probes.size(), [&](std::size_t i) {
    const Probe& probe = probes[i];
    const CourseIndex& parent = *parents.at(probe.course > 0 ? probe.course - 1 : probe.course + 1);
    // Beyond 1.05 W the foot lies past the end of the neighbour: another stationary point was found.
    const auto near = parent.laid().rival(tracer, probe.at.frame.position, probe.at.frame.normal, 1.05 * W, -1, 0, 0);
    if (near) errors[i] = std::abs(std::abs(near->foot.distance_mm) - W);
  });
  SpacingError out;
  for (std::size_t i = 0; i < probes.size(); ++i) {
    if (errors[i] < 0) continue;
    ++out.checked;
    if (errors[i] > out.worst_mm) {
      out.worst_mm = errors[i];
      out.worst_course = probes[i].course;
      out.where = probes[i].at.frame.position;
    }
  }
  return out;
}

}  // namespace afptraj
