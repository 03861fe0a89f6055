#pragma once

#include <cstdint>
#include <vector>

#include "fill/lattice.h"
#include "fill/slice.h"

namespace afptraj {

/// The distance from straight pieces in the plane, as the Voronoi diagram of the pieces and their ends: built
/// once, every level curve is read from it, with no error that adds up from level to level.
///
/// Of a slice the pieces are its boundary, and the distance is positive inside, negative outside. Of paths
/// the distance is negative everywhere: a level -w/2 bounds what beads of width w along the paths cover.
///
/// Error: ends of pieces are moved to a lattice by at most unit_mm() / sqrt(2) (its unit is below 4e-9 of the
/// box); level curves are lines and arcs exact for the moved pieces up to rounding, which is below a unit.
/// Topology does not depend on rounding: each stretch of the diagram is crossed by a level or not, once for
/// both of its sides, so that level curves are always closed.
///
/// Cost: O(n log n) to build; a level costs what the cells it passes hold.
/// Source: M. Held, On the Computational Geometry of Pocket Machining, LNCS 500, ch. 4 and 6; Boost.Polygon.
class DistanceDiagram {
 public:
  /// `reach_mm`: levels down to -reach_mm will be asked for.
  static DistanceDiagram of(const Slice& slice, double reach_mm);
  static DistanceDiagram of(const std::vector<Polyline>& paths, double reach_mm);

  double unit_mm() const { return lattice_.unit_mm(); }
  /// The greatest distance inside: the radius of the greatest inscribed circle.
  double greatest_mm() const;

  /// The curves at distance `distance_mm`, not 0: of a slice the boundary of what is nearer than that outside
  /// or farther inside, with it on the left; of paths the boundary of what the beads cover, covered area on
  /// the left. Places where the distance exceeds |distance_mm| by less than `tolerance_mm` only count as
  /// below it: rings thinner than that are left out. The order is that of the input, always the same.
  std::vector<ArcRing> level(double distance_mm, double tolerance_mm) const;

  /// The medial axis inside: where the distance is reached at two places or more.
  struct AxisNode {
    Vec2 point;
    double radius_mm = 0;
  };
  struct AxisEdge {
    std::size_t from = 0, to = 0;  ///< nodes
    std::vector<Vec2> between;     ///< points of a parabola between them
  };
  struct MedialAxis {
    std::vector<AxisNode> nodes;
    std::vector<AxisEdge> edges;
  };
  MedialAxis medial_axis() const;

 private:
  // A point of the diagram, in lattice units.
  struct Node {
    Vec2 at;
    double radius = 0;
    bool inside = false, labelled = false;
  };
  // A stretch of an edge of the diagram along which the radius only grows or only falls.
  struct Stretch {
    std::int32_t node[2];
    std::int32_t cell[2];  // to the left of node 0 -> node 1, and to the right
    bool inside = false, primary = false;
  };
  // A piece (segment) or an end of pieces.
  struct Cell {
    bool is_point = false;
    LatticeSegment segment;  // a == b for a point
    bool frame = false;
    std::int32_t first = 0, count = 0;  // in uses_: its stretches, anticlockwise
    double greatest[2] = {0, 0};        // radius outside and inside
  };
  struct Use {
    std::int32_t stretch;
    bool forward;
  };

  DistanceDiagram(Lattice lattice, const std::vector<LatticeSegment>& segments, std::size_t frame,
                  bool sided);
  void build(const std::vector<LatticeSegment>& segments, std::size_t frame);
  void label(bool sided);
  void rank_cells();
  Vec2 point_on(const Stretch& stretch, double radius) const;

  Lattice lattice_;
  std::vector<Node> nodes_;
  std::vector<Stretch> stretches_;
  std::vector<Cell> cells_;
  std::vector<Use> uses_;
  std::vector<std::int32_t> by_radius_[2];  // cells, outside and inside, greatest radius first
};

}  // namespace afptraj
