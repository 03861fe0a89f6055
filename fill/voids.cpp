#include "fill/voids.h"

#include <algorithm>
#include <cmath>

#include "fill/axis_paths.h"
#include "fill/distance_diagram.h"

namespace afptraj {
namespace {

// The part of an open chain between the lengths s0 and s1.
Polyline stretch(const Polyline& line, double s0, double s1) {
  Polyline out;
  double s = 0;
  for (std::size_t i = 0; i + 1 < line.points.size(); ++i) {
    const Vec2 &a = line.points[i], &b = line.points[i + 1];
    const double step = (b - a).norm();
    if (s + step > s0 && s < s1) {
      if (out.points.empty()) out.points.push_back(a + (b - a) * std::clamp((s0 - s) / step, 0.0, 1.0));
      out.points.push_back(a + (b - a) * std::clamp((s1 - s) / step, 0.0, 1.0));
    }
    s += step;
  }
  return out;
}

// The point of a void that is farthest from its edge.
Vec2 deepest(const Void& place) {
  const auto axis = DistanceDiagram::of(place.region, 0).medial_axis();
  const DistanceDiagram::AxisNode* best = nullptr;
  for (const auto& node : axis.nodes) {
    if (best == nullptr || node.radius_mm > best->radius_mm) best = &node;
  }
  return best == nullptr ? place.region.rings().front().points.front() : best->point;
}

}  // namespace

std::vector<Void> voids(const std::vector<Polyline>& paths, double width_mm, double tolerance_mm) {
  std::vector<Void> out;
  if (paths.empty()) return out;
  const DistanceDiagram diagram = DistanceDiagram::of(paths, width_mm);
  std::vector<std::vector<Vec2>> loops;
  for (const ArcRing& ring : diagram.level(-width_mm / 2, tolerance_mm)) {
    Polyline loop = flattened(ring, width_mm / 1000);
    if (loop.points.size() >= 3) loops.push_back(std::move(loop.points));
  }
  const Slice cover = nested_slice(loops);
  const auto& rings = cover.rings();
  for (std::size_t i = 0; i < rings.size(); ++i) {
    if (rings[i].depth % 2 == 0) continue;
    // a hole of the cover, with the islands of cover in it
    std::vector<std::vector<Vec2>> region{rings[i].points};
    const Slice whole = nested_slice(region);
    for (const SliceRing& ring : rings) {
      if (ring.depth == rings[i].depth + 1 && contains(whole, ring.points.front()))
        region.push_back(ring.points);
    }
    Void place{nested_slice(region), 0};
    place.area_mm2 = place.region.area_mm2();
    out.push_back(std::move(place));
  }
  return out;
}

std::vector<Polyline> void_paths(const Void& place, double width_mm) {
  const auto axis = DistanceDiagram::of(place.region, 0).medial_axis();
  std::vector<Polyline> paths = trimmed_axis(axis, width_mm / 2);
  // what the bead along a longer path covers in passing needs no branch of its own
  std::erase_if(paths, [&](const Polyline& path) { return length_mm(path) < width_mm; });
  if (!paths.empty()) return paths;
  const Polyline way = longest_way(axis);
  const double length = length_mm(way), half = std::min(place.area_mm2 / width_mm, length) / 2;
  if (way.points.size() < 2) return {};
  return {stretch(way, length / 2 - half, length / 2 + half)};
}

void fill_voids(Fill& fill, const Slice& slice, double width_mm, double tolerance_mm, double least_area_mm2) {
  for (const Void& place : voids(lines_of(fill.paths), width_mm, tolerance_mm)) {
    const Vec2 middle = deepest(place);
    if (!contains(slice, middle)) continue;
    const bool opens = std::any_of(slice.rings().begin(), slice.rings().end(), [&](const SliceRing& ring) {
      return contains(place.region, ring.points.front());
    });
    std::vector<Polyline> paths;
    if (place.area_mm2 >= least_area_mm2 && !opens) paths = void_paths(place, width_mm);
    if (paths.empty()) fill.leftovers.push_back({middle, place.area_mm2});
    for (const Polyline& path : paths)
      fill.paths.push_back({simplified(path, width_mm / 50), PathKind::centre, 0});
  }
}

std::vector<Polyline> lines_of(const std::vector<FillPath>& paths) {
  std::vector<Polyline> lines;
  for (const FillPath& path : paths) lines.push_back(path.line);
  return lines;
}

}  // namespace afptraj
