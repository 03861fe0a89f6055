#include "fill/distance_diagram.h"

#include <algorithm>
#include <boost/polygon/voronoi.hpp>
#include <cmath>
#include <map>

#include "geometry/error.h"

namespace afptraj {
namespace {

using boost::polygon::voronoi_builder;
using boost::polygon::voronoi_diagram;

// Keeps cells in the order of the input: undirected pieces that occur an even number of times vanish (the
// edge that two rings share is no boundary), of others one stays.
std::vector<LatticeSegment> without_doubles(const std::vector<LatticeSegment>& segments, bool parity) {
  std::map<std::pair<LatticePoint, LatticePoint>, int> count;
  const auto key = [](const LatticeSegment& s) { return std::minmax(s.a, s.b); };
  for (const LatticeSegment& s : segments) ++count[key(s)];
  std::vector<LatticeSegment> out;
  for (const LatticeSegment& s : segments) {
    int& times = count[key(s)];
    if (times > 0 && (!parity || times % 2 == 1)) out.push_back(s);
    times = 0;
  }
  return out;
}

double distance_to(const LatticeSegment& s, const Vec2& p) {
  const Vec2 a = s.a.real(), d = s.b.real() - a, v = p - a;
  const double squared = d.squaredNorm();
  return squared == 0 ? v.norm() : (v - d * std::clamp(v.dot(d) / squared, 0.0, 1.0)).norm();
}

// The line of a segment: distances from it are t, counted to the side of `toward`; s runs along it.
struct Line {
  Vec2 origin, along, normal;
  Line(const LatticeSegment& segment, const Vec2& toward) {
    origin = segment.a.real();
    along = (segment.b.real() - origin).normalized();
    normal = left_of(along);
    if (normal.dot(toward - origin) < 0) normal = -normal;
  }
};

}  // namespace

DistanceDiagram DistanceDiagram::of(const Slice& slice, double reach_mm) {
  const std::vector<Vec2> points = points_of(slice);
  // the frame is farther from the slice than any level that will be asked for is from both
  const Lattice lattice(points, 2.5 * reach_mm + 1);
  std::vector<LatticeSegment> segments;
  segments.reserve(points.size() + 4);
  for (const SliceRing& ring : slice.rings()) {
    for (std::size_t i = 0; i < ring.points.size(); ++i) {
      segments.push_back(
          {lattice.snap(ring.points[i]), lattice.snap(ring.points[(i + 1) % ring.points.size()])});
    }
  }
  segments = without_doubles(split_at_meetings(std::move(segments)), true);
  const std::size_t frame = segments.size();
  const auto corners = lattice.frame();
  for (std::size_t i = 0; i < 4; ++i) segments.push_back({corners[i], corners[(i + 1) % 4]});
  return DistanceDiagram(lattice, segments, frame, true);
}

DistanceDiagram DistanceDiagram::of(const std::vector<Polyline>& paths, double reach_mm) {
  std::vector<Vec2> points;
  for (const Polyline& path : paths) points.insert(points.end(), path.points.begin(), path.points.end());
  const Lattice lattice(points, 2.5 * reach_mm + 1);
  std::vector<LatticeSegment> segments;
  for (const Polyline& path : paths) {
    const std::size_t n = path.points.size();
    for (std::size_t i = 0; i + (path.closed ? 0 : 1) < n; ++i)
      segments.push_back({lattice.snap(path.points[i]), lattice.snap(path.points[(i + 1) % n])});
  }
  segments = without_doubles(split_at_meetings(std::move(segments)), false);
  const std::size_t frame = segments.size();
  const auto corners = lattice.frame();
  for (std::size_t i = 0; i < 4; ++i) segments.push_back({corners[i], corners[(i + 1) % 4]});
  return DistanceDiagram(lattice, segments, frame, false);
}

DistanceDiagram::DistanceDiagram(Lattice lattice, const std::vector<LatticeSegment>& segments,
                                 std::size_t frame, bool sided)
    : lattice_(lattice) {
  build(segments, frame);
  label(sided);
  rank_cells();
}

void DistanceDiagram::build(const std::vector<LatticeSegment>& segments, std::size_t frame) {
  voronoi_builder<std::int32_t> builder;
  for (const LatticeSegment& s : segments) builder.insert_segment(s.a.x, s.a.y, s.b.x, s.b.y);
  voronoi_diagram<double> diagram;
  builder.construct(&diagram);

  nodes_.reserve(diagram.num_vertices() * 5 / 4);
  cells_.reserve(diagram.num_cells());
  for (const auto& cell : diagram.cells()) {
    Cell own;
    const LatticeSegment& s = segments[cell.source_index()];
    own.is_point = cell.contains_point();
    own.segment = s;
    if (own.is_point) {
      const LatticePoint p =
          cell.source_category() == boost::polygon::SOURCE_CATEGORY_SEGMENT_START_POINT ? s.a : s.b;
      own.segment = {p, p};
    }
    own.frame = cell.source_index() >= frame;
    cells_.push_back(own);
  }
  const auto cell_of = [&](const voronoi_diagram<double>::edge_type* edge) {
    return static_cast<std::int32_t>(edge->cell() - diagram.cells().data());
  };
  for (const auto& vertex : diagram.vertices()) {
    Node node{{vertex.x(), vertex.y()}, 0};
    node.radius =
        distance_to(cells_[static_cast<std::size_t>(cell_of(vertex.incident_edge()))].segment, node.at);
    // Ends of pieces are vertices of the diagram: there the radius is 0 up to rounding.
    if (node.radius < 0.01) node.radius = 0;
    nodes_.push_back(node);
  }
  // Stretches of each edge, made when its first half is met: one, or two where the radius has its least in
  // between.
  std::vector<std::pair<std::int32_t, std::int32_t>> made(diagram.num_edges(), {-1, -1});
  const auto index_of = [&](const voronoi_diagram<double>::edge_type* edge) {
    return static_cast<std::size_t>(edge - diagram.edges().data());
  };
  const auto node_of = [&](const voronoi_diagram<double>::vertex_type* vertex) {
    return static_cast<std::int32_t>(vertex - diagram.vertices().data());
  };
  for (const auto& edge : diagram.edges()) {
    if (edge.twin() < &edge || edge.is_infinite()) continue;
    Stretch whole{{node_of(edge.vertex0()), node_of(edge.vertex1())},
                  {cell_of(&edge), cell_of(edge.twin())},
                  false,
                  edge.is_primary()};
    const Vec2 a = nodes_[static_cast<std::size_t>(whole.node[0])].at,
               b = nodes_[static_cast<std::size_t>(whole.node[1])].at;
    const Cell &one = cells_[static_cast<std::size_t>(whole.cell[0])],
               &two = cells_[static_cast<std::size_t>(whole.cell[1])];
    Vec2 least = a;  // where the radius of the whole curve is least
    double radius = 0;
    const LatticeSegment &s = one.segment, &t = two.segment;
    bool shared = false;
    for (const LatticePoint& p : {s.a, s.b}) {
      if (p == t.a || p == t.b) shared = true, least = p.real();
    }
    if (!shared) {
      if (one.is_point && two.is_point) {
        least = (s.a.real() + t.a.real()) / 2;
        radius = (s.a.real() - t.a.real()).norm() / 2;
      } else if (one.is_point != two.is_point) {
        const Vec2 focus = one.is_point ? s.a.real() : t.a.real();
        const Line line(one.is_point ? t : s, focus);
        radius = line.normal.dot(focus - line.origin) / 2;
        least = focus - radius * line.normal;
      }
    }
    const bool monotone = !shared && !one.is_point && !two.is_point;
    const double before = (a - least).dot(b - a), after = (b - least).dot(b - a);
    const std::size_t index = index_of(&edge), twin = index_of(edge.twin());
    if (!monotone && before < 0 && after > 0 && (a - least).norm() > 0.01 && (b - least).norm() > 0.01) {
      const auto middle = static_cast<std::int32_t>(nodes_.size());
      nodes_.push_back({least, radius});
      Stretch first = whole, second = whole;
      first.node[1] = second.node[0] = middle;
      made[index] = {static_cast<std::int32_t>(stretches_.size()),
                     static_cast<std::int32_t>(stretches_.size() + 1)};
      made[twin] = {made[index].second, made[index].first};
      stretches_.push_back(first);
      stretches_.push_back(second);
    } else {
      made[index].first = made[twin].first = static_cast<std::int32_t>(stretches_.size());
      stretches_.push_back(whole);
    }
  }
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    cells_[c].first = static_cast<std::int32_t>(uses_.size());
    const auto* begin = diagram.cells()[c].incident_edge();
    const auto* edge = begin;
    if (edge != nullptr) {
      do {
        const bool forward = edge < edge->twin();
        const auto [first, second] = made[index_of(edge)];
        if (first >= 0) uses_.push_back({first, forward});
        if (second >= 0) uses_.push_back({second, forward});
        edge = edge->next();
      } while (edge != begin);
    }
    cells_[c].count = static_cast<std::int32_t>(uses_.size()) - cells_[c].first;
  }
}

// Which part of the diagram lies inside: told by the sides of segments, then handed on along the diagram,
// which does not lead through the boundary but at radius 0.
void DistanceDiagram::label(bool sided) {
  if (!sided) return;
  std::vector<std::vector<std::int32_t>> neighbours(nodes_.size());
  for (const Stretch& s : stretches_) {
    neighbours[static_cast<std::size_t>(s.node[0])].push_back(s.node[1]);
    neighbours[static_cast<std::size_t>(s.node[1])].push_back(s.node[0]);
  }
  std::vector<std::int32_t> open;
  for (const Cell& cell : cells_) {
    if (cell.is_point || cell.frame) continue;
    const Vec2 a = cell.segment.a.real(), d = cell.segment.b.real() - a;
    for (std::int32_t k = cell.first; k < cell.first + cell.count; ++k) {
      for (const std::int32_t n :
           stretches_[static_cast<std::size_t>(uses_[static_cast<std::size_t>(k)].stretch)].node) {
        Node& node = nodes_[static_cast<std::size_t>(n)];
        if (node.labelled || node.radius == 0) continue;
        node.labelled = true;
        node.inside = cross(d, node.at - a) > 0;
        open.push_back(n);
      }
    }
  }
  while (!open.empty()) {
    const std::int32_t from = open.back();
    open.pop_back();
    for (const std::int32_t n : neighbours[static_cast<std::size_t>(from)]) {
      Node& node = nodes_[static_cast<std::size_t>(n)];
      if (node.labelled || node.radius == 0) continue;
      node.labelled = true;
      node.inside = nodes_[static_cast<std::size_t>(from)].inside;
      open.push_back(n);
    }
  }
  for (Stretch& s : stretches_)
    s.inside = nodes_[static_cast<std::size_t>(s.node[0])].inside ||
               nodes_[static_cast<std::size_t>(s.node[1])].inside;
}

void DistanceDiagram::rank_cells() {
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    Cell& cell = cells_[c];
    for (std::int32_t k = cell.first; k < cell.first + cell.count; ++k) {
      const Stretch& s = stretches_[static_cast<std::size_t>(uses_[static_cast<std::size_t>(k)].stretch)];
      for (const std::int32_t n : s.node)
        cell.greatest[s.inside] =
            std::max(cell.greatest[s.inside], nodes_[static_cast<std::size_t>(n)].radius);
    }
    if (cell.frame) continue;
    for (const bool side : {false, true}) {
      if (cell.greatest[side] > 0) by_radius_[side].push_back(static_cast<std::int32_t>(c));
    }
  }
  for (const bool side : {false, true}) {
    std::stable_sort(by_radius_[side].begin(), by_radius_[side].end(), [&](std::int32_t a, std::int32_t b) {
      return cells_[static_cast<std::size_t>(a)].greatest[side] >
             cells_[static_cast<std::size_t>(b)].greatest[side];
    });
  }
}

double DistanceDiagram::greatest_mm() const {
  if (by_radius_[1].empty()) return 0;
  return unit_mm() * cells_[static_cast<std::size_t>(by_radius_[1].front())].greatest[1];
}

// The point of the stretch at `radius` from both of its cells.
Vec2 DistanceDiagram::point_on(const Stretch& stretch, double radius) const {
  const Node *low = &nodes_[static_cast<std::size_t>(stretch.node[0])],
             *high = &nodes_[static_cast<std::size_t>(stretch.node[1])];
  if (low->radius > high->radius) std::swap(low, high);
  const Cell &one = cells_[static_cast<std::size_t>(stretch.cell[0])],
             &two = cells_[static_cast<std::size_t>(stretch.cell[1])];
  if (one.is_point && two.is_point) {
    const Vec2 p = one.segment.a.real(), q = two.segment.a.real(), middle = (p + q) / 2;
    Vec2 along = left_of(q - p).normalized();
    if (along.dot(high->at - middle) < 0) along = -along;
    return middle + along * std::sqrt(std::max(0.0, radius * radius - (q - p).squaredNorm() / 4));
  }
  if (one.is_point != two.is_point && stretch.primary) {
    const Vec2 focus = one.is_point ? one.segment.a.real() : two.segment.a.real();
    const Line line(one.is_point ? two.segment : one.segment, focus);
    const double t = line.normal.dot(focus - line.origin);
    if (t > 0) {
      double s = std::sqrt(std::max(0.0, t * (2 * radius - t)));
      if (line.along.dot(high->at - focus) < 0) s = -s;
      return focus + (radius - t) * line.normal + s * line.along;
    }
  }
  // On a straight bisector through radius 0, or of two lines, the radius is linear.
  const double span = high->radius - low->radius;
  const double share = span > 0 ? std::clamp((radius - low->radius) / span, 0.0, 1.0) : 0.0;
  return low->at + share * (high->at - low->at);
}

std::vector<ArcRing> DistanceDiagram::level(double distance_mm, double tolerance_mm) const {
  const bool inside = distance_mm > 0;
  const double radius = std::abs(distance_mm) / unit_mm();
  const double threshold = radius + tolerance_mm / unit_mm();
  // Within a cell the level runs from where the cell's boundary, walked anticlockwise, comes down through it
  // to where it went up: with the site on its right.
  struct Element {
    std::int32_t cell, start, end;  // stretches
    bool used;
  };
  std::vector<Element> elements;
  std::vector<std::int32_t> starting(stretches_.size(), -1);
  for (const std::int32_t c : by_radius_[inside]) {
    const Cell& cell = cells_[static_cast<std::size_t>(c)];
    if (cell.greatest[inside] < threshold) break;
    std::int32_t up = -1, pending = -1;
    for (std::int32_t k = cell.first; k < cell.first + cell.count; ++k) {
      const Use use = uses_[static_cast<std::size_t>(k)];
      const Stretch& s = stretches_[static_cast<std::size_t>(use.stretch)];
      if (s.inside != inside) continue;
      const bool before = nodes_[static_cast<std::size_t>(s.node[use.forward ? 0 : 1])].radius >= threshold,
                 after = nodes_[static_cast<std::size_t>(s.node[use.forward ? 1 : 0])].radius >= threshold;
      if (before == after) continue;
      if (after) {
        up = use.stretch;
      } else if (up < 0) {
        pending = use.stretch;  // its rise comes at the end of the loop
      } else {
        elements.push_back({c, use.stretch, up, false});
        up = -1;
      }
    }
    if (pending >= 0 && up >= 0) elements.push_back({c, pending, up, false});
  }
  std::sort(elements.begin(), elements.end(), [](const Element& a, const Element& b) {
    return std::pair(a.cell, a.start) < std::pair(b.cell, b.start);
  });
  for (std::size_t i = 0; i < elements.size(); ++i)
    starting[static_cast<std::size_t>(elements[i].start)] = static_cast<std::int32_t>(i);

  std::vector<ArcRing> rings;
  for (std::size_t first = 0; first < elements.size(); ++first) {
    ArcRing ring;
    std::int32_t at = static_cast<std::int32_t>(first);
    while (at >= 0 && !elements[static_cast<std::size_t>(at)].used) {
      Element& e = elements[static_cast<std::size_t>(at)];
      e.used = true;
      const Cell& cell = cells_[static_cast<std::size_t>(e.cell)];
      const Vec2 from = point_on(stretches_[static_cast<std::size_t>(e.start)], radius);
      ring.pieces.push_back({lattice_.mm(from), lattice_.mm(cell.segment.a.real()), cell.is_point ? -1 : 0});
      at = starting[static_cast<std::size_t>(e.end)];
    }
    if (ring.pieces.size() < 2) continue;
    rings.push_back(inside ? std::move(ring) : reversed(ring));
  }
  return rings;
}

DistanceDiagram::MedialAxis DistanceDiagram::medial_axis() const {
  MedialAxis axis;
  std::vector<std::int32_t> index(nodes_.size(), -1);
  const auto node_of = [&](std::int32_t n) {
    auto& at = index[static_cast<std::size_t>(n)];
    if (at < 0) {
      at = static_cast<std::int32_t>(axis.nodes.size());
      const Node& node = nodes_[static_cast<std::size_t>(n)];
      axis.nodes.push_back({lattice_.mm(node.at), node.radius * unit_mm()});
    }
    return static_cast<std::size_t>(at);
  };
  for (const Stretch& s : stretches_) {
    if (!s.inside || !s.primary) continue;
    AxisEdge edge{node_of(s.node[0]), node_of(s.node[1]), {}};
    const Cell &one = cells_[static_cast<std::size_t>(s.cell[0])],
               &two = cells_[static_cast<std::size_t>(s.cell[1])];
    if (one.is_point != two.is_point) {
      constexpr int parts = 4;
      const double r0 = nodes_[static_cast<std::size_t>(s.node[0])].radius,
                   r1 = nodes_[static_cast<std::size_t>(s.node[1])].radius;
      for (int k = 1; k < parts; ++k)
        edge.between.push_back(lattice_.mm(point_on(s, r0 + (r1 - r0) * k / parts)));
    }
    axis.edges.push_back(std::move(edge));
  }
  return axis;
}

}  // namespace afptraj
