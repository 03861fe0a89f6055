#include "analysis/judge_fill.h"

#include <algorithm>
#include <cmath>

#include "analysis/region_areas.h"
#include "fill/contour_parallel.h"
#include "fill/distance_diagram.h"

namespace afptraj {
namespace {

double least_turning_radius(const Polyline& path) {
  double least = HUGE_VAL;
  const std::size_t n = path.points.size();
  for (std::size_t i = path.closed ? 0 : 1; i + (path.closed ? 0 : 1) < n; ++i) {
    const Vec2 a = path.points[i] - path.points[(i + n - 1) % n],
               b = path.points[(i + 1) % n] - path.points[i];
    const double turn = std::abs(std::atan2(cross(a, b), a.dot(b)));
    if (turn > 1e-12) least = std::min(least, (a.norm() + b.norm()) / 2 / turn);
  }
  return least;
}

// What all discs of the beads' width within the slice cover together.
double reachable_mm2(const Slice& slice, double width_mm) {
  std::vector<std::vector<Vec2>> rings;
  for (const ArcRing& ring : offset_rings(slice, width_mm / 2, 0)) {
    Polyline line = flattened(ring, width_mm / 1e5);
    if (line.points.size() >= 3) rings.push_back(std::move(line.points));
  }
  if (rings.empty()) return 0;
  double area = 0;
  for (const ArcRing& ring : offset_rings(nested_slice(rings), -width_mm / 2, 0)) area += signed_area(ring);
  return area;
}

}  // namespace

FillReport judge_fill(const Slice& slice, const std::vector<FillPath>& paths, double width_mm,
                      const SharpCornerOptions& sharp) {
  FillReport report;
  report.slice_mm2 = slice.area_mm2();
  report.paths = static_cast<int>(paths.size());
  report.min_turning_radius_mm = HUGE_VAL;
  const Vec2* last = nullptr;
  for (const FillPath& path : paths) {
    const auto& points = path.line.points;
    report.length_mm += length_mm(path.line);
    if (last != nullptr) report.travel_mm += (points.front() - *last).norm();
    last = path.line.closed ? &points.front() : &points.back();
    report.sharp_corners += static_cast<int>(sharp_corners(path.line, sharp).size());
    report.min_turning_radius_mm = std::min(report.min_turning_radius_mm, least_turning_radius(path.line));
  }
  std::vector<ArcRing> cover;
  if (!paths.empty()) {
    const DistanceDiagram diagram = DistanceDiagram::of(lines_of(paths), width_mm);
    cover = diagram.level(-width_mm / 2, 4 * diagram.unit_mm());
  }
  const RegionAreas areas = region_areas(cover, offset_rings(slice, 0, 0));
  report.covered_mm2 = areas.both + areas.only_first;
  report.underfill = areas.only_second / report.slice_mm2;
  report.unreachable = std::max(0.0, 1 - reachable_mm2(slice, width_mm) / report.slice_mm2);
  report.outside = areas.only_first / report.slice_mm2;
  report.overfill = (report.length_mm * width_mm - report.covered_mm2) / report.slice_mm2;
  const auto open =
      std::count_if(paths.begin(), paths.end(), [](const FillPath& path) { return !path.line.closed; });
  report.overfill_with_ends =
      report.overfill + static_cast<double>(open) * pi * width_mm * width_mm / 4 / report.slice_mm2;
  return report;
}

}  // namespace afptraj
