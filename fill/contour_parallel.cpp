#include "fill/contour_parallel.h"

#include <cmath>

#include "fill/axis_paths.h"
#include "fill/voids.h"

namespace afptraj {
namespace {

// The boundary itself.
std::vector<ArcRing> boundary(const Slice& slice) {
  std::vector<ArcRing> rings;
  for (const SliceRing& ring : slice.rings()) {
    ArcRing out;
    for (const Vec2& p : ring.points) out.pieces.push_back({p, p, 0});
    rings.push_back(std::move(out));
  }
  return rings;
}

std::vector<Vec2> corners_of(const ArcRing& ring) {
  std::vector<Vec2> points;
  for (const ArcRing::Piece& piece : ring.pieces) points.push_back(piece.from);
  return points;
}

bool within(const std::vector<Vec2>& ring, const ArcRing& other) {
  return contains(Slice({{ring, 0}}), other.pieces.front().from);
}

// The rings of a level with convex corners rounded. Where the area within is too thin somewhere for such
// corners its rings stay as they are.
std::vector<ArcRing> rounded(const std::vector<ArcRing>& rings, const std::vector<ArcRing>& deeper,
                             double corner_mm) {
  std::vector<ArcRing> out;
  for (const ArcRing& outline : rings) {
    if (signed_area(outline) <= 0) continue;
    const std::vector<Vec2> corners = corners_of(outline);
    std::vector<const ArcRing*> now, then;
    for (const ArcRing& ring : rings) {
      if (&ring == &outline || (signed_area(ring) < 0 && within(corners, ring))) now.push_back(&ring);
    }
    int outlines = 0;
    for (const ArcRing& ring : deeper) {
      if (!within(corners, ring)) continue;
      then.push_back(&ring);
      outlines += signed_area(ring) > 0;
    }
    const bool same = outlines == 1 && now.size() == then.size();
    for (const ArcRing* ring : same ? then : now) out.push_back(same ? moved_back(*ring, corner_mm) : *ring);
  }
  return out;
}

// The middle lines of strips that the first ring would run along twice in one place.
std::vector<Polyline> exact_strips(const DistanceDiagram& diagram, double distance, double thin) {
  if (distance <= 0) return {};
  DistanceDiagram::MedialAxis axis = diagram.medial_axis();
  std::erase_if(axis.edges, [&](const DistanceDiagram::AxisEdge& edge) {
    return std::abs(axis.nodes[edge.from].radius_mm - distance) > 2 * thin ||
           std::abs(axis.nodes[edge.to].radius_mm - distance) > 2 * thin;
  });
  return trimmed_axis(axis, 0);
}

}  // namespace

std::vector<ArcRing> offset_rings(const Slice& slice, double distance_mm, double tolerance_mm) {
  if (distance_mm == 0) return boundary(slice);
  return DistanceDiagram::of(slice, std::max(0.0, -distance_mm)).level(distance_mm, tolerance_mm);
}

std::vector<FillPath> outermost_paths(const Slice& slice, const DistanceDiagram& diagram, double first_mm,
                                      double tolerance_mm) {
  const double thin = 4 * diagram.unit_mm();
  std::vector<FillPath> paths;
  for (const ArcRing& ring : first_mm == 0 ? boundary(slice) : diagram.level(first_mm, thin)) {
    Polyline line = flattened(ring, tolerance_mm);
    if (line.points.size() >= 3) paths.push_back({std::move(line), PathKind::outline, 0});
  }
  for (Polyline& line : exact_strips(diagram, first_mm, thin))
    paths.push_back({std::move(line), PathKind::centre, 0});
  return paths;
}

Fill contour_parallel(const Slice& slice, const ContourOptions& options) {
  Fill fill;
  const DistanceDiagram diagram = DistanceDiagram::of(slice, std::max(0.0, -options.first_mm));
  const double thin = 4 * diagram.unit_mm();  // rings thinner than rounding are none
  for (int k = 0;; ++k) {
    const double distance = options.first_mm + k * options.spacing_mm;
    // Where a ring would run along both sides of next to nothing it is left to a path along the middle.
    const double least = k == 0 ? thin : std::max(thin, options.spacing_mm / 50);
    if (distance > 0 && distance + least > diagram.greatest_mm()) break;
    std::vector<ArcRing> rings = distance == 0 ? boundary(slice) : diagram.level(distance, least);
    // what the outermost ring leaves bare at a corner nothing else could fill: its corners stay
    if (k > 0 && options.corner_mm > 0 && distance + options.corner_mm > 0)
      rings = rounded(rings, diagram.level(distance + options.corner_mm, thin), options.corner_mm);
    for (const ArcRing& ring : rings)
      fill.paths.push_back({flattened(ring, options.tolerance_mm), PathKind::ring, k});
  }
  std::erase_if(fill.paths, [](const FillPath& path) { return path.line.points.size() < 3; });
  for (Polyline& line : exact_strips(diagram, options.first_mm, thin))
    fill.paths.push_back({std::move(line), PathKind::centre, 0});
  fill_voids(fill, slice, options.spacing_mm, 3 * options.tolerance_mm,
             options.least_void_share * options.spacing_mm * options.spacing_mm);
  return fill;
}

}  // namespace afptraj
