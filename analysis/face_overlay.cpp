#include "analysis/face_overlay.h"

#include <algorithm>
#include <boost/polygon/polygon.hpp>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <set>

#include "analysis/chart_area.h"
#include "geometry/curvature.h"

namespace afptraj {
namespace {

namespace bp = boost::polygon;
using Point = bp::point_data<int>;
using Merge = bp::property_merge<int, int>;

constexpr int material = -1;  // the property of the face itself; bands have their numbers
constexpr double half_grid = 1 << 27;

/// (u, v) on the grid of integers.
class Grid {
 public:
  Grid(const Uv& lo, const Uv& hi)
      : middle_(0.5 * (lo + hi)), scale_((0.5 * (hi - lo)).cwiseMax(1e-300).cwiseInverse() * half_grid) {}
  Point to_grid(const Uv& uv) const {
    const Uv x = (uv - middle_).cwiseProduct(scale_);
    return {static_cast<int>(std::lround(x.x())), static_cast<int>(std::lround(x.y()))};
  }
  Uv to_uv(const Point& p) const { return middle_ + Uv(p.x(), p.y()).cwiseQuotient(scale_); }
  Uv unit() const { return scale_.cwiseInverse(); }

 private:
  Uv middle_, scale_;
};

struct CoverEdge {
  Point a, b;
  int property;
  std::pair<int, int> tow;  // course, tow
};

bool less(const Point& p, const Point& q) {
  return std::make_pair(p.x(), p.y()) < std::make_pair(q.x(), q.y());
}

/// The loops of a face as polygons: chords within `chord_mm` of the pcurves on the surface.
std::vector<std::vector<Uv>> flat_loops(const Skin& skin, int face, double chord_mm) {
  std::vector<std::vector<Uv>> out;
  const Surface& surface = skin.face(face).surface;
  for (const Loop& loop : skin.face(face).loops) {
    std::vector<Uv>& ring = out.emplace_back();
    for (const Coedge& coedge : loop.coedges) {
      std::vector<Uv> points;
      const auto refine = [&](auto& self, double t0, const Uv& p0, double t1, const Uv& p1,
                              int depth) -> void {
        const double t = 0.5 * (t0 + t1);
        const Uv p = coedge.pcurve.point(t);
        // Two more places, so that an inflection is no straight line.
        const Uv p_low = coedge.pcurve.point(0.5 * (t0 + t)), p_high = coedge.pcurve.point(0.5 * (t + t1));
        const SurfaceDerivatives d = surface.derivatives(p);
        const auto off = [&](const Uv& q) {
          const Vec3 chord = uv_to_tangent(d, p1 - p0), r = uv_to_tangent(d, q - p0);
          const double along =
              chord.squaredNorm() > 0 ? std::clamp(r.dot(chord) / chord.squaredNorm(), 0.0, 1.0) : 0;
          return (r - along * chord).norm();
        };
        if (depth < 14 && std::max({off(p), off(p_low), off(p_high)}) > chord_mm) {
          self(self, t0, p0, t, p, depth + 1);
          self(self, t, p, t1, p1, depth + 1);
        } else {
          points.push_back(p1);
        }
      };
      const std::vector<double> breaks = coedge.pcurve.breaks();
      points.push_back(coedge.pcurve.point(breaks.front()));
      for (std::size_t i = 0; i + 1 < breaks.size(); ++i)
        refine(refine, breaks[i], coedge.pcurve.point(breaks[i]), breaks[i + 1],
               coedge.pcurve.point(breaks[i + 1]), 0);
      if (coedge.reversed) std::reverse(points.begin(), points.end());
      ring.insert(ring.end(), points.begin(), points.end() - 1);
    }
  }
  return out;
}

/// The edges of a strip, anticlockwise in (u, v).
void add_edges(const TowStrip& strip, int property, const Grid& grid, std::vector<CoverEdge>& out) {
  std::vector<Uv> ring = strip.right;
  if (strip.end) ring.push_back(*strip.end);
  ring.insert(ring.end(), strip.left.rbegin(), strip.left.rend());
  if (strip.start) ring.push_back(*strip.start);
  if (strip.turned) std::reverse(ring.begin(), ring.end());
  const std::pair<int, int> tow(strip.course, strip.tow);
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Point a = grid.to_grid(ring[i]), b = grid.to_grid(ring[(i + 1) % ring.size()]);
    if (a != b) out.push_back({a, b, property, tow});
  }
}

/// Drops edges that a band runs through both ways: between tows that lie side by side.
void cancel(std::vector<CoverEdge>& edges) {
  const auto key = [](const CoverEdge& e) {
    const bool forward = less(e.a, e.b);
    const Point& lo = forward ? e.a : e.b;
    const Point& hi = forward ? e.b : e.a;
    return std::make_tuple(e.property, lo.x(), lo.y(), hi.x(), hi.y());
  };
  std::stable_sort(edges.begin(), edges.end(),
                   [&](const CoverEdge& a, const CoverEdge& b) { return key(a) < key(b); });
  std::vector<CoverEdge> out;
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i;
    int sum = 0;
    while (end < edges.size() && key(edges[end]) == key(edges[i]))
      sum += less(edges[end].a, edges[end].b) ? 1 : -1, ++end;
    for (std::size_t k = i; k < end && sum != 0; ++k)
      if ((less(edges[k].a, edges[k].b) ? 1 : -1) * sum > 0) {
        out.push_back(edges[k]);
        sum -= sum > 0 ? 1 : -1;
      }
    i = end;
  }
  edges = std::move(out);
}

/// Which tow edges, and the loops, pass a place.
class EdgeIndex {
 public:
  EdgeIndex(const Uv& lo, const Uv& hi) : lo_(lo), cell_((hi - lo) / across), cells_(across * across) {}

  void add(const Uv& a, const Uv& b, const std::pair<int, int>& tow) {
    each_cell(cells_, a.cwiseMin(b), a.cwiseMax(b), [&](auto& cell) { cell.push_back(edges_.size()); });
    edges_.push_back({a, b, tow});
  }
  /// Tows within `slack_mm` of a point; returns whether a loop is.
  bool near(const SurfaceDerivatives& d, const Uv& p, double slack_mm,
            std::set<std::pair<int, int>>& tows) const {
    bool loop = false;
    const Uv reach(slack_mm / std::max(d.Su.norm(), 1e-12), slack_mm / std::max(d.Sv.norm(), 1e-12));
    each_cell(cells_, p - reach, p + reach, [&](const auto& cell) {
      for (const std::size_t k : cell) {
        const Edge& e = edges_[k];
        const Vec3 chord = uv_to_tangent(d, e.b - e.a), r = uv_to_tangent(d, p - e.a);
        const double all = chord.squaredNorm(), x = all > 0 ? std::clamp(r.dot(chord) / all, 0.0, 1.0) : 0;
        if ((r - x * chord).norm() > slack_mm) continue;
        if (e.tow == loop_tow)
          loop = true;
        else
          tows.insert(e.tow);
      }
    });
    return loop;
  }
  static constexpr std::pair<int, int> loop_tow{0, 0};

 private:
  static constexpr int across = 64;
  struct Edge {
    Uv a, b;
    std::pair<int, int> tow;
  };
  template <class Cells, class F>
  void each_cell(Cells& cells, const Uv& lo, const Uv& hi, F&& f) const {
    const auto at = [&](const Uv& p, int k) {
      return static_cast<int>(std::clamp((p[k] - lo_[k]) / cell_[k], 0.0, across - 1.0));
    };
    for (int i = at(lo, 0); i <= at(hi, 0); ++i)
      for (int j = at(lo, 1); j <= at(hi, 1); ++j) f(cells[static_cast<std::size_t>(i * across + j)]);
  }

  Uv lo_, cell_;
  std::vector<std::vector<std::size_t>> cells_;
  std::vector<Edge> edges_;
};

using Cover = std::vector<std::size_t>;  // bands, one that lies over itself several times
using Sets = std::map<std::pair<bool, Cover>, bp::polygon_set_data<int>>;

/// Merges edges; `band_of` says whose a property is.
Sets merge_edges(const std::vector<CoverEdge>& edges, const std::vector<CoverEdge>& loops,
                 const std::vector<std::size_t>& band_of) {
  Merge merge;
  auto& vertices = merge.get_property_merge_data();
  for (const auto* list : {&loops, &edges})
    for (const CoverEdge& e : *list)
      Merge::create_vertex(vertices, e.a, e.b, bp::direction_1d(bp::COUNTERCLOCKWISE), false, e.property);
  std::map<std::set<int>, bp::polygon_set_data<int>> found;
  merge.merge(found);
  Sets out;
  for (const auto& [properties, set] : found) {
    std::pair<bool, Cover> key(properties.count(material) > 0, {});
    for (const int property : properties)
      if (property != material) key.second.push_back(band_of[static_cast<std::size_t>(property)]);
    std::sort(key.second.begin(), key.second.end());
    out[key].insert(set);
  }
  return out;
}

class Overlay {
 public:
  Overlay(const Skin& skin, int face, const std::vector<const TowStrip*>& strips, double chord_mm,
          double slack_mm)
      : skin_(skin),
        face_(face),
        strips_(strips),
        slack_mm_(slack_mm),
        rings_(flat_loops(skin, face, 0.2 * chord_mm)) {
    Uv lo = Uv::Constant(1e300), hi = Uv::Constant(-1e300);
    const auto widen = [&](const std::vector<Uv>& points) {
      for (const Uv& p : points) {
        lo = lo.cwiseMin(p);
        hi = hi.cwiseMax(p);
      }
    };
    for (const auto& ring : rings_) widen(ring);
    for (const TowStrip* strip : strips) {
      widen(strip->left);
      widen(strip->right);
      for (const auto& middle : {strip->start, strip->end})
        if (middle) widen({*middle});
    }
    grid_.emplace(lo, hi);
    area_.emplace(skin.face(face).surface, lo, hi);
    index_.emplace(lo, hi);
  }

  FaceOverlay run() {
    FaceOverlay out;
    std::vector<CoverEdge> loops;
    for (const auto& ring : rings_)
      for (std::size_t i = 0; i < ring.size(); ++i) {
        const Uv &p = ring[i], &q = ring[(i + 1) % ring.size()];
        const Point a = grid_->to_grid(p), b = grid_->to_grid(q);
        if (a == b) continue;
        loops.push_back({a, b, material, EdgeIndex::loop_tow});
        out.face_mm2 += area_->along(grid_->to_uv(a), grid_->to_uv(b));
        out.loops_mm += length(p, q);
        index_->add(p, q, EdgeIndex::loop_tow);
      }

    // Bands are numbered densely: bands_[property].
    std::map<std::size_t, int> property;
    for (const TowStrip* strip : strips_)
      if (property.emplace(strip->band, static_cast<int>(bands_.size())).second)
        bands_.push_back(strip->band);
    std::vector<CoverEdge> edges;
    for (const TowStrip* strip : strips_) {
      add_edges(*strip, property[strip->band], *grid_, edges);
      out.ends_mm2 += strip->ends_mm2;
    }
    cancel(edges);
    std::map<std::size_t, double> laid;  // by band
    for (const CoverEdge& e : edges) {
      const Uv a = grid_->to_uv(e.a), b = grid_->to_uv(e.b);
      laid[bands_[static_cast<std::size_t>(e.property)]] += area_->along(a, b);
      out.boundary_mm += length(a, b);
      index_->add(a, b, e.tow);
    }
    const double coarse = std::max(1e-2, 1e-5 * out.boundary_mm);
    measure(merge_edges(edges, loops, bands_), out);

    // A band that covers less than it lays lies over itself: its strips are told apart.
    std::map<std::size_t, double> covers = laid;
    for (const OverlayRegion& region : out.regions)
      for (const std::size_t band : region.bands) covers[band] -= region.area_mm2;
    std::vector<std::size_t> band_of = bands_;
    std::vector<CoverEdge> finer;
    for (const TowStrip* strip : strips_) {
      int number = property[strip->band];
      if (covers[strip->band] > coarse) {
        number = static_cast<int>(band_of.size());
        band_of.push_back(strip->band);
      }
      add_edges(*strip, number, *grid_, finer);
    }
    if (band_of.size() > bands_.size()) {
      cancel(finer);
      out.regions.clear();
      measure(merge_edges(finer, loops, band_of), out);
    }
    for (OverlayRegion& region : out.regions) look(region);
    for (const auto& [band, mm2] : laid) out.strips_mm2 += mm2;
    out.area_error_mm2 = area_->error_mm2();
    const SurfaceDerivatives d = skin_.derivatives({face_, grid_->to_uv({0, 0})});
    out.grid_mm = std::hypot(d.Su.norm() * grid_->unit().x(), d.Sv.norm() * grid_->unit().y());
    return out;
  }

 private:
  double length(const Uv& a, const Uv& b) const {
    return uv_to_tangent(skin_.derivatives({face_, 0.5 * (a + b)}), b - a).norm();
  }

  template <class Ring>
  double ring_area(const Ring& ring, std::vector<Uv>* outline) const {
    std::vector<Uv> points;
    for (const Point& p : ring) points.push_back(grid_->to_uv(p));
    if (points.size() > 1 && points.front() == points.back()) points.pop_back();
    double sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
      sum += area_->along(points[i], points[(i + 1) % points.size()]);
    if (outline) {
      if (sum < 0) std::reverse(points.begin(), points.end());
      *outline = std::move(points);
    }
    return std::abs(sum);
  }

  void measure(const Sets& sets, FaceOverlay& out) const {
    for (const auto& [key, set] : sets) {
      std::vector<bp::polygon_with_holes_data<int>> polygons;
      set.get(polygons);
      for (const auto& polygon : polygons) {
        OverlayRegion region;
        region.on_skin = key.first;
        region.bands = key.second;
        region.area_mm2 = ring_area(polygon, &region.outline);
        for (auto hole = polygon.begin_holes(); hole != polygon.end_holes(); ++hole)
          region.area_mm2 -= ring_area(*hole, nullptr);
        out.regions.push_back(std::move(region));
      }
    }
  }

  /// Shape and neighbours of a gap or overlap.
  void look(OverlayRegion& region) const {
    if (!region.on_skin || region.bands.size() == 1 || region.outline.size() < 3 || region.area_mm2 < 1e-6)
      return;
    region.shape = region_shape(skin_, face_, region.outline);
    if (region.shape.width_mm < 2 * slack_mm_) return;
    std::set<std::pair<int, int>> tows;
    for (std::size_t i = 0; i < region.outline.size(); ++i) {
      const Uv middle = 0.5 * (region.outline[i] + region.outline[(i + 1) % region.outline.size()]);
      if (index_->near(skin_.derivatives({face_, middle}), middle, slack_mm_, tows))
        region.at_boundary = true;
    }
    region.tows.assign(tows.begin(), tows.end());
    region.wide = true;
  }

  const Skin& skin_;
  int face_;
  const std::vector<const TowStrip*>& strips_;
  double slack_mm_;
  std::vector<std::vector<Uv>> rings_;
  std::vector<std::size_t> bands_;
  std::optional<Grid> grid_;
  std::optional<ChartArea> area_;
  std::optional<EdgeIndex> index_;
};

}  // namespace

FaceOverlay overlay(const Skin& skin, int face, const std::vector<const TowStrip*>& strips, double chord_mm,
                    double slack_mm) {
  return Overlay(skin, face, strips, chord_mm, slack_mm).run();
}

}  // namespace afptraj
