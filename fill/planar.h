#pragma once

#include <vector>

#include "geometry/types.h"

namespace afptraj {

/// A point or direction of the plane of a slice, mm where it is a length.
using Vec2 = Eigen::Vector2d;

inline double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }
/// `v` turned a quarter to the left.
inline Vec2 left_of(const Vec2& v) { return {-v.y(), v.x()}; }

/// A chain of straight pieces; a closed one goes on from its last point to its first, which is not repeated.
struct Polyline {
  std::vector<Vec2> points;
  bool closed = false;
};

double length_mm(const Polyline& line);

/// Area within a closed chain of points, positive when it runs anticlockwise.
double signed_area(const std::vector<Vec2>& points);

/// Fewer points: none of those left out is farther than `tolerance_mm` from the chain (Douglas and Peucker
/// 1973). The first point stays, of an open chain the last as well.
Polyline simplified(const Polyline& line, double tolerance_mm);

/// A closed curve of lines and arcs of circles: exact offsets of polygons are of this kind.
struct ArcRing {
  struct Piece {
    Vec2 from;     ///< the piece ends where the next one begins
    Vec2 centre;   ///< of an arc
    int turn = 0;  ///< 0 line, +1 anticlockwise arc, -1 clockwise arc
  };
  std::vector<Piece> pieces;
};

double length_mm(const ArcRing& ring);

/// Exact up to rounding: polygon of the ends plus the circular segments.
double signed_area(const ArcRing& ring);

/// The same curve run the other way.
ArcRing reversed(const ArcRing& ring);

/// A level curve moved back by `by_mm` to its right, where the nearest places of the boundary lie: lines and
/// arcs move along their normals, corners become arcs. With `by_mm` below the level's distance that is the
/// level curve at the smaller distance with its convex corners rounded to the radius `by_mm`.
ArcRing moved_back(const ArcRing& level, double by_mm);

/// Points on the curve such that no chord is farther than `tolerance_mm` from its arc. Points that would
/// repeat the one before are left out.
Polyline flattened(const ArcRing& ring, double tolerance_mm);

}  // namespace afptraj
