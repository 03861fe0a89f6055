#pragma once

#include <vector>

#include "fill/planar.h"

namespace afptraj {

/// What a path of a fill is for.
enum class PathKind {
  ring,     ///< a contour-parallel or non-equidistant ring
  outline,  ///< the outermost ring beside a line pattern
  line,     ///< of a raster or zigzag
  centre,   ///< along the middle of a place that the others leave bare
  joined,   ///< several of these connected
};

/// The centre line of one bead, laid without lifting the head.
struct FillPath {
  Polyline line;
  PathKind kind = PathKind::ring;
  int level = 0;  ///< rings: 0 is the outermost
};

/// A place that stays bare.
struct Leftover {
  Vec2 where;
  double area_mm2 = 0;
};

/// What joins paths: stretches along the boundary of a zigzag, from ring to ring of a connected fill.
struct Links {
  int count = 0;
  double length_mm = 0, longest_mm = 0;
  void add(double mm) {
    ++count;
    length_mm += mm;
    longest_mm = mm > longest_mm ? mm : longest_mm;
  }
};

/// What a pattern lays; a value.
struct Fill {
  std::vector<FillPath> paths;
  Links links;                      ///< parts of the paths
  std::vector<Leftover> leftovers;  ///< holes in the cover that are too small for a path of their own
};

std::vector<Polyline> lines_of(const std::vector<FillPath>& paths);

}  // namespace afptraj
