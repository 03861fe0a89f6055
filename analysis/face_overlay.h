#pragma once

#include <utility>
#include <vector>

#include "analysis/region_shape.h"
#include "analysis/tow_strips.h"
#include "geometry/skin.h"

namespace afptraj {

/// A region of one face, or beside it, under the same bands.
struct OverlayRegion {
  std::vector<std::size_t> bands;  ///< that cover it, one that lies over itself several times; empty: a gap
  bool on_skin = true;
  double area_mm2 = 0;
  std::vector<Uv> outline;  ///< outer boundary in (u, v), anticlockwise
  // Of gaps and overlaps on the skin that are wider somewhere than twice the slack:
  bool wide = false;
  bool at_boundary = false;  ///< a loop of the face is part of its outline
  RegionShape shape;
  std::vector<std::pair<int, int>> tows;  ///< course and tow of the edges within the slack of its outline
};

struct FaceOverlay {
  std::vector<OverlayRegion> regions;
  double face_mm2 = 0;        ///< within the loops, from their boundary alone
  double strips_mm2 = 0;      ///< of all strips, from their boundaries alone
  double boundary_mm = 0;     ///< length of the tow edges that part one cover from another
  double loops_mm = 0;        ///< length of the loops
  double ends_mm2 = 0;        ///< bounds what straight lines of (u, v) miss of the cuts
  double area_error_mm2 = 0;  ///< of the integration, see chart_area.h
  double grid_mm = 0;         ///< what the grid may move a point by, at the middle of the face
};

/// Overlays the strips of a face and its loops in (u, v) by one sweep (Boost.Polygon: exact predicates on a
/// grid of 2^-28 of the box of face and strips) and measures the regions on the surface (chart_area.h). Edges
/// that neighbouring tows of a band share drop out first.
///
/// `chord_mm`: loops become chords within a fifth of it. `slack_mm`: how near an edge must pass to count as a
/// neighbour.
FaceOverlay overlay(const Skin& skin, int face, const std::vector<const TowStrip*>& strips, double chord_mm,
                    double slack_mm);

}  // namespace afptraj
