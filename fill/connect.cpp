#include "fill/connect.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>
#include <tuple>
#include <unordered_map>

namespace afptraj {
namespace {

constexpr std::size_t none = static_cast<std::size_t>(-1);
constexpr double advance = 2;  // of a spiral's link along the rings, in distances between them

// A closed ring by its length.
struct Ring {
  std::vector<Vec2> points;
  std::vector<double> s;  // at each point
  double length = 0;
  std::size_t source = 0;  // in the fill
  int level = 0;

  explicit Ring(const std::vector<Vec2>& line) : points(line) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      s.push_back(length);
      length += (points[(i + 1) % points.size()] - points[i]).norm();
    }
  }
  double wrapped(double at) const {
    at = std::fmod(at, length);
    return at < 0 ? at + length : at;
  }
  std::size_t piece(double at) const {
    return static_cast<std::size_t>(std::upper_bound(s.begin(), s.end(), at) - s.begin()) - 1;
  }
  Vec2 at(double where) const {
    where = wrapped(where);
    const std::size_t i = piece(where), j = i + 1 == points.size() ? 0 : i + 1;
    const double end = j == 0 ? length : s[j];
    return end > s[i] ? Vec2(points[i] + (points[j] - points[i]) * ((where - s[i]) / (end - s[i])))
                      : points[i];
  }
  // Appends the way forward from `from` to `to` >= from, both ends with it.
  void walk(double from, double to, std::vector<Vec2>& out) const {
    out.push_back(at(from));
    const double start = wrapped(from), shift = from - start;
    for (std::size_t i = piece(start) + 1;; ++i) {
      const double there = s[i % s.size()] + length * static_cast<double>(i / s.size()) + shift;
      if (there >= to) break;
      if (there > from) out.push_back(points[i % s.size()]);
    }
    out.push_back(at(to));
  }
};

// All pieces of the rings by the square cells that they pass.
class Grid {
 public:
  Grid(const std::vector<Ring>& rings, double width) : rings_(rings) {
    Vec2 lo = Vec2::Constant(HUGE_VAL), hi = -lo;
    std::size_t count = 0;
    double total = 0;
    for (const Ring& ring : rings) {
      for (const Vec2& p : ring.points) lo = lo.cwiseMin(p), hi = hi.cwiseMax(p);
      count += ring.points.size();
      total += ring.length;
    }
    if (count == 0) return;
    const double n = static_cast<double>(count);
    const Vec2 size = hi - lo;
    cell_ = std::max({width, total / n, std::sqrt(size.x() * size.y() / n), size.maxCoeff() / n});
    lo_ = lo;
    columns_ = static_cast<std::int64_t>(size.x() / cell_) + 1;
    rows_ = static_cast<std::int64_t>(size.y() / cell_) + 1;
    std::vector<std::pair<std::int64_t, Entry>> all;
    all.reserve(2 * count);
    for (std::size_t r = 0; r < rings.size(); ++r) {
      const auto& points = rings[r].points;
      for (std::size_t i = 0; i < points.size(); ++i) {
        for_cells(points[i], points[(i + 1) % points.size()], [&](std::int64_t c) {
          all.emplace_back(c, Entry{static_cast<std::uint32_t>(r), static_cast<std::uint32_t>(i)});
        });
      }
    }
    first_.assign(static_cast<std::size_t>(columns_ * rows_) + 1, 0);
    for (const auto& [c, entry] : all) ++first_[static_cast<std::size_t>(c) + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    entries_.resize(all.size());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (const auto& [c, entry] : all) entries_[next[static_cast<std::size_t>(c)]++] = entry;
  }

  struct Near {
    std::size_t ring;
    double s, distance;
  };
  // The nearest place of each ring within `reach`, of only one ring if it is given.
  std::vector<Near> near(const Vec2& p, double reach, std::size_t only = none) const {
    std::vector<Near> found;
    for_box(p - Vec2::Constant(reach), p + Vec2::Constant(reach), [&](const Entry& entry) {
      if (only != none && entry.ring != only) return;
      const Ring& ring = rings_[entry.ring];
      const Vec2& a = ring.points[entry.point];
      const Vec2 d = ring.points[(entry.point + 1) % ring.points.size()] - a, v = p - a;
      const double squared = d.squaredNorm(),
                   t = squared > 0 ? std::clamp(v.dot(d) / squared, 0.0, 1.0) : 0.0;
      const double distance = (v - t * d).norm();
      if (distance > reach) return;
      const Near place{entry.ring, ring.s[entry.point] + t * std::sqrt(squared), distance};
      for (Near& other : found) {
        if (other.ring != entry.ring) continue;
        if (std::pair(distance, place.s) < std::pair(other.distance, other.s)) other = place;
        return;
      }
      found.push_back(place);
    });
    return found;
  }

  // Whether a piece of a ring crosses the straight way from a to b, whose ends may lie on rings. What
  // `ignored(ring, s)` names does not count.
  template <class Ignored>
  bool blocked(const Vec2& a, const Vec2& b, const Ignored& ignored) const {
    const Vec2 d = b - a;
    const double length = d.norm();
    bool hit = false;
    for_box(a.cwiseMin(b), a.cwiseMax(b), [&](const Entry& entry) {
      if (hit) return;
      const Ring& ring = rings_[entry.ring];
      const Vec2& p = ring.points[entry.point];
      const Vec2 e = ring.points[(entry.point + 1) % ring.points.size()] - p;
      const double det = cross(d, e);
      if (std::abs(det) < 1e-12 * length * e.norm()) return;
      const double t = cross(p - a, e) / det, u = cross(p - a, d) / det;
      if (t * length < 1e-6 * cell_ || (1 - t) * length < 1e-6 * cell_ || u < 0 || u > 1) return;
      if (!ignored(entry.ring, ring.s[entry.point] + u * e.norm())) hit = true;
    });
    return hit;
  }

 private:
  struct Entry {
    std::uint32_t ring, point;
  };
  std::int64_t column(double x) const {
    return std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor((x - lo_.x()) / cell_)), 0,
                                    columns_ - 1);
  }
  std::int64_t row(double y) const {
    return std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor((y - lo_.y()) / cell_)), 0,
                                    rows_ - 1);
  }
  template <class Visit>
  void for_cells(Vec2 a, Vec2 b, const Visit& visit) const {
    if (a.x() > b.x()) std::swap(a, b);
    const std::int64_t from = column(a.x()), to = column(b.x());
    for (std::int64_t c = from; c <= to; ++c) {
      const auto y_at = [&](double x) {
        x = std::clamp(x, a.x(), b.x());
        return b.x() > a.x() ? a.y() + (b.y() - a.y()) * (x - a.x()) / (b.x() - a.x()) : a.y();
      };
      double y0 = c == from ? a.y() : y_at(lo_.x() + static_cast<double>(c) * cell_),
             y1 = c == to ? b.y() : y_at(lo_.x() + static_cast<double>(c + 1) * cell_);
      if (y0 > y1) std::swap(y0, y1);
      for (std::int64_t r = row(y0 - 1e-9 * cell_); r <= row(y1 + 1e-9 * cell_); ++r) visit(r * columns_ + c);
    }
  }
  template <class Visit>
  void for_box(const Vec2& lo, const Vec2& hi, const Visit& visit) const {
    if (first_.empty()) return;
    for (std::int64_t r = row(lo.y()); r <= row(hi.y()); ++r) {
      for (std::int64_t c = column(lo.x()); c <= column(hi.x()); ++c) {
        const auto k = static_cast<std::size_t>(r * columns_ + c);
        for (std::uint32_t i = first_[k]; i < first_[k + 1]; ++i) visit(entries_[i]);
      }
    }
  }

  const std::vector<Ring>& rings_;
  Vec2 lo_ = Vec2::Zero();
  double cell_ = 1;
  std::int64_t columns_ = 0, rows_ = 0;
  std::vector<std::uint32_t> first_;
  std::vector<Entry> entries_;
};

struct Forest {
  std::vector<std::size_t> up;
  explicit Forest(std::size_t n) : up(n) { std::iota(up.begin(), up.end(), std::size_t{0}); }
  std::size_t root(std::size_t i) {
    while (up[i] != i) i = up[i] = up[up[i]];
    return i;
  }
  bool unite(std::size_t i, std::size_t j) {
    i = root(i), j = root(j);
    if (i == j) return false;
    up[std::max(i, j)] = std::min(i, j);
    return true;
  }
};

// Where a ring is left or entered: the ring is run forward from it, or backward.
struct End {
  std::size_t ring = none;
  double s = 0;
  bool forward = true;    // the ring goes on forward from here; else backward
  std::size_t to = none;  // the end at the other side of the link; none: the path ends
  std::vector<Vec2> via;  // of a link that is not straight
};

// What is taken out of a ring: a gap, or (from == to) a place at which a spur leaves and comes back.
struct Gap {
  double from = 0, to = 0;            // from in [0, length), to >= from
  std::size_t end[2] = {none, none};  // at `from` (run backward from there) and at `to` (forward)
  std::vector<Vec2> spur;
};

class Connector {
 public:
  Connector(const Fill& fill, const Slice& slice, double width, Connection connection)
      : fill_(fill),
        width_(width),
        connection_(connection),
        rings_(rings_of(fill, width)),
        grid_(rings_, width),
        boundary_(rings_of(slice)),
        boundary_grid_(boundary_, width),
        gaps_(rings_.size()) {}

  Fill run() {
    find_candidates();
    Forest forest(rings_.size());
    nest(forest);
    if (connection_ == Connection::spiral) {
      const auto parents = tree();
      gaps_.assign(rings_.size(), {});
      ends_.clear();
      tree_.clear();
      links_.clear();
      forest = Forest(rings_.size());
      spirals(parents, forest);
      nest(forest);
    }
    Fill out;
    out.leftovers = fill_.leftovers;
    std::vector<const FillPath*> alone = spurs();
    trace(out);
    for (const FillPath* path : alone) out.paths.push_back(*path);
    return out;
  }

 private:
  // An open path that comes back to its start is run once round rather than there and back.
  static bool is_ring(const Polyline& line, double width) {
    if (line.points.size() < 3) return false;
    return line.closed ||
           ((line.points.front() - line.points.back()).norm() < width / 2 && length_mm(line) > 4 * width);
  }

  static std::vector<Ring> rings_of(const Fill& fill, double width) {
    std::vector<Ring> rings;
    for (std::size_t i = 0; i < fill.paths.size(); ++i) {
      const FillPath& path = fill.paths[i];
      if (!is_ring(path.line, width)) continue;
      rings.emplace_back(path.line.points);
      rings.back().source = i;
      rings.back().level = path.kind == PathKind::centre ? -2 : path.level;  // spirals go from level to level
    }
    return rings;
  }

  static std::vector<Ring> rings_of(const Slice& slice) {
    std::vector<Ring> rings;
    for (const SliceRing& ring : slice.rings()) rings.emplace_back(ring.points);
    return rings;
  }

  // A place where a link between two rings may be.
  struct Candidate {
    double distance;
    std::size_t a, b;
    double sa, sb;
  };

  void find_candidates() {
    for (std::size_t a = 0; a < rings_.size(); ++a) {
      const Ring& ring = rings_[a];
      const int count = static_cast<int>(std::clamp(ring.length / (width_ / 2), 8.0, 24.0));
      for (int k = 0; k < count; ++k) {
        const double s = ring.length * (k + 0.5) / count;
        for (const auto& near : grid_.near(ring.at(s), 2.2 * width_)) {
          if (near.ring != a) candidates_.push_back({near.distance, a, near.ring, s, near.s});
        }
      }
    }
    // shortest first; what differs by rounding only in the order of the rings
    const auto key = [&](const Candidate& c) {
      return std::tuple(std::round(c.distance / width_ * 1e3), c.a, c.sa, c.b);
    };
    std::sort(candidates_.begin(), candidates_.end(),
              [&](const Candidate& p, const Candidate& q) { return key(p) < key(q); });
  }

  // Whether [from, to] of the ring is farther than `margin` from all gaps.
  bool free(std::size_t ring, double from, double to, double margin) const {
    const double length = rings_[ring].length;
    for (const Gap& gap : gaps_[ring]) {
      // the gap's start, seen forward from `from`, and the other way round
      const double ahead = rings_[ring].wrapped(gap.from - from),
                   behind = rings_[ring].wrapped(from - gap.from);
      if (ahead < to - from + margin || behind < gap.to - gap.from + margin) return false;
      if (length - (gap.to - gap.from) - (to - from) < 2 * margin) return false;
    }
    return to - from < length;
  }
  bool in_gap(std::size_t ring, double s) const {
    for (const Gap& gap : gaps_[ring]) {
      const double beyond = rings_[ring].wrapped(s - gap.from);
      if (beyond > 0 && beyond < gap.to - gap.from) return true;
    }
    return false;
  }
  // Whether a way from a to b would cross the boundary, a ring, but for its gaps, or a link.
  bool blocked(const Vec2& a, const Vec2& b) const {
    bool hit = grid_.blocked(a, b, [&](std::size_t ring, double s) { return in_gap(ring, s); }) ||
               boundary_grid_.blocked(a, b, [](std::size_t, double) { return false; });
    for_cells(a, b, [&](std::int64_t cell) {
      const auto found = links_.find(cell);
      if (found == links_.end()) return;
      for (const auto& [p, q] : found->second) {
        const double near = cross(b - a, p - a), far = cross(b - a, q - a), left = cross(q - p, a - p),
                     right = cross(q - p, b - p);
        if (near * far <= 0 && left * right <= 0) hit = true;
      }
    });
    return hit;
  }
  // Cells of a width of the box of a way, by a number of their own.
  template <class Visit>
  void for_cells(const Vec2& a, const Vec2& b, const Visit& visit) const {
    const Vec2 lo = a.cwiseMin(b) / width_, hi = a.cwiseMax(b) / width_;
    for (auto x = static_cast<std::int64_t>(std::floor(lo.x())); static_cast<double>(x) <= hi.x(); ++x) {
      for (auto y = static_cast<std::int64_t>(std::floor(lo.y())); static_cast<double>(y) <= hi.y(); ++y)
        visit(x * (std::int64_t{1} << 32) + y);
    }
  }
  void remember(const Vec2& a, const Vec2& b) {
    for_cells(a, b, [&](std::int64_t cell) { links_[cell].emplace_back(a, b); });
  }

  // The place of `ring` nearest to p, near s.
  std::optional<Grid::Near> beside(std::size_t ring, const Vec2& p, double s, double reach) const {
    const auto near = grid_.near(p, reach, ring);
    if (near.empty()) return std::nullopt;
    const Ring& other = rings_[ring];
    const double off = other.wrapped(near[0].s - s + other.length / 2) - other.length / 2;
    if (std::abs(off) > 3 * width_) return std::nullopt;
    return Grid::Near{ring, s + off, near[0].distance};
  }

  std::size_t add_end(std::size_t ring, double s, bool forward) {
    ends_.push_back({ring, s, forward, none, {}});
    return ends_.size() - 1;
  }
  Vec2 place(std::size_t end) const { return rings_[ends_[end].ring].at(ends_[end].s); }
  void tie(std::size_t i, std::size_t j, std::vector<Vec2> via = {}) {
    Vec2 last = place(i);
    for (const Vec2& p : via) remember(last, p), last = p;
    remember(last, place(j));
    ends_[i].to = j, ends_[j].to = i;
    ends_[i].via = via;
    std::reverse(via.begin(), via.end());
    ends_[j].via = std::move(via);
  }
  void open(std::size_t ring, double from, double to) {
    const double start = rings_[ring].wrapped(from);
    Gap gap{start, to + start - from, {add_end(ring, from, false), add_end(ring, to, true)}, {}};
    gaps_[ring].push_back(std::move(gap));
  }

  // Two links beside each other from a gap of ring a to one of ring b.
  bool bridge(const Candidate& c, double margin) {
    const Ring &a = rings_[c.a], &b = rings_[c.b];
    const double gap = std::min({width_, a.length / 4, b.length / 4});
    const double a0 = c.sa - gap / 2, a1 = c.sa + gap / 2;
    if (!free(c.a, a0, a1, margin)) return false;
    const double reach = std::max(1.3 * c.distance, c.distance + width_ / 4);
    const auto at0 = beside(c.b, a.at(a0), c.sb, reach), at1 = beside(c.b, a.at(a1), c.sb, reach);
    if (!at0 || !at1) return false;
    const double b0 = std::min(at0->s, at1->s), b1 = std::max(at0->s, at1->s);
    if (b1 - b0 < gap / 10 || b1 - b0 > 2.5 * gap || !free(c.b, b0, b1, margin)) return false;
    if (blocked(a.at(a0), b.at(at0->s)) || blocked(a.at(a1), b.at(at1->s))) return false;
    open(c.a, a0, a1);
    open(c.b, b0, b1);
    const Gap &one = gaps_[c.a].back(), &two = gaps_[c.b].back();
    const bool same = at0->s < at1->s;
    tie(one.end[0], two.end[same ? 0 : 1]);
    tie(one.end[1], two.end[same ? 1 : 0]);
    tree_.emplace_back(c.a, c.b);
    return true;
  }

  void nest(Forest& forest) {
    // links a width apart where there is room, nearer where there is not
    for (const double margin : {1.0, 0.1}) {
      for (const Candidate& c : candidates_) {
        if (forest.root(c.a) != forest.root(c.b) && bridge(c, margin * width_)) forest.unite(c.a, c.b);
      }
    }
  }

  // Of each ring the one that it hangs on, in the trees that the links make; roots hang on none.
  std::vector<std::size_t> tree() const {
    std::vector<std::vector<std::size_t>> beside(rings_.size());
    for (const auto& [a, b] : tree_) beside[a].push_back(b), beside[b].push_back(a);
    std::vector<std::size_t> parent(rings_.size(), none), order;
    std::vector<char> seen(rings_.size(), 0);
    for (std::size_t root = 0; root < rings_.size(); ++root) {
      if (seen[root]) continue;
      seen[root] = 1;
      order.assign(1, root);
      for (std::size_t k = 0; k < order.size(); ++k) {
        for (const std::size_t next : beside[order[k]]) {
          if (seen[next]) continue;
          seen[next] = 1;
          parent[next] = order[k];
          order.push_back(next);
        }
      }
    }
    return parent;
  }

  // The stretch of a ring that a spiral's links pass.
  struct Pass {
    std::size_t ring;
    double from, to;
    double at(double share) const { return from + share * (to - from); }
  };
  // The stretches of a chain's rings beside each other, beginning at s of its first: as far as they lie so.
  std::vector<Pass> aligned(const std::vector<std::size_t>& chain, double s) const {
    const double usual = 2 * advance * width_;
    std::vector<Pass> passes;
    double e = s + usual;
    for (std::size_t k = 0; k < chain.size(); ++k) {
      const Ring& ring = rings_[chain[k]];
      if (ring.length < 2 * usual || !free(chain[k], s, e, width_)) break;
      passes.push_back({chain[k], s, e});
      if (k + 1 == chain.size()) break;
      const auto from = grid_.near(ring.at(s), 1.1 * width_, chain[k + 1]),
                 to = grid_.near(ring.at(e), 1.1 * width_, chain[k + 1]),
                 middle = grid_.near(ring.at((s + e) / 2), 1.1 * width_, chain[k + 1]);
      if (from.empty() || to.empty() || middle.empty()) break;
      const double next = rings_[chain[k + 1]].wrapped(to[0].s - from[0].s);
      if (next < 0.6 * usual || next > 1.5 * usual) break;
      s = from[0].s + (next - usual) / 2, e = s + usual;
    }
    return passes;
  }

  void spirals(const std::vector<std::size_t>& parents, Forest& forest) {
    std::vector<int> children(rings_.size(), 0);
    std::vector<std::size_t> child(rings_.size(), none);
    for (std::size_t r = 0; r < rings_.size(); ++r) {
      if (parents[r] != none) ++children[parents[r]], child[parents[r]] = r;
    }
    std::vector<char> used(rings_.size(), 0);
    for (std::size_t r = 0; r < rings_.size(); ++r) {
      // a chain begins at a root, below a branch, or where an earlier spiral had to end
      if (used[r] || (parents[r] != none && children[parents[r]] == 1 && !used[parents[r]])) continue;
      std::vector<std::size_t> chain{r};
      // level by level, all inwards or all outwards
      while (children[chain.back()] == 1) {
        const std::size_t next = child[chain.back()];
        const int step = rings_[next].level - rings_[chain.back()].level;
        if (std::abs(step) != 1 || (chain.size() > 1 && step != rings_[chain[1]].level - rings_[r].level))
          break;
        chain.push_back(next);
      }
      used[r] = 1;
      std::vector<Pass> best;
      const int tries = static_cast<int>(std::clamp(rings_[r].length / width_, 4.0, 48.0));
      for (int k = 0; k < tries && best.size() < chain.size(); ++k) {
        std::vector<Pass> passes = aligned(chain, rings_[r].length * k / tries);
        if (passes.size() > best.size()) best = std::move(passes);
      }
      if (best.size() < 2) continue;
      lay_spiral(best, parents[r] == none);
      for (const Pass& pass : best) used[pass.ring] = 1, forest.unite(best[0].ring, pass.ring);
      if (children[best.back().ring] == 1) --r;  // the rest of the chain is one of its own
    }
  }

  // The way from ring `k` of a spiral at the share `f` of its stretch to the ring `rings` farther in, half a
  // stretch on from ring to ring.
  std::vector<Vec2> slanting(const std::vector<Pass>& passes, std::size_t k, std::size_t rings,
                             double f) const {
    constexpr int parts = 6;
    std::vector<Vec2> way;
    for (int i = 1; i < parts * static_cast<int>(rings); ++i) {
      const double deep = static_cast<double>(i) / parts, share = f + deep / 2;
      const std::size_t upper = k + static_cast<std::size_t>(deep);
      const double part = deep - std::floor(deep);
      const auto on = [&](std::size_t which) {
        return rings_[passes[which].ring].at(passes[which].at(share));
      };
      way.push_back(part == 0 ? on(upper) : Vec2((1 - part) * on(upper) + part * on(upper + 1)));
    }
    return way;
  }

  // In along the rings 0, 2, 4 ..., out along the others; the two innermost are joined. A spiral that hangs
  // on nothing is open: its ends are the starts of rings 0 and 1. Else these are joined.
  void lay_spiral(const std::vector<Pass>& passes, bool is_root) {
    const std::size_t n = passes.size();
    for (std::size_t k = 0; k < n; ++k) {
      const Pass& pass = passes[k];
      // where no link comes from farther out, rings begin as near to the first link as a width allows
      double end = 1;
      if (k == 0) end = is_root ? 0.25 : 0.5;
      if (k == 1 && is_root) end = 0.8;
      open(pass.ring, k + 1 == n ? pass.at(0.5) : pass.from, pass.at(k + 1 == n ? std::max(end, 0.75) : end));
    }
    const auto end = [&](std::size_t k, int side) { return gaps_[passes[k].ring].back().end[side]; };
    for (std::size_t k = 0; k + 2 < n; ++k) tie(end(k, 0), end(k + 2, 1), slanting(passes, k, 2, 0));
    tie(end(n - 2, 0), end(n - 1, 0), slanting(passes, n - 2, 1, 0));
    if (!is_root) tie(end(0, 1), end(1, 1), slanting(passes, 0, 1, 0.5));
  }

  // Open paths as spurs of the ring nearest to one of their ends. Those too far from all are returned.
  std::vector<const FillPath*> spurs() {
    std::vector<const FillPath*> alone;
    for (const FillPath& path : fill_.paths) {
      if (is_ring(path.line, width_)) continue;
      std::vector<Vec2> points = path.line.points;
      bool done = false;
      for (int side = 0; side < 2 && !done; ++side) {
        auto near = grid_.near(points.front(), 2 * width_);
        std::sort(near.begin(), near.end(), [](const auto& p, const auto& q) {
          return std::tuple(p.distance, p.ring) < std::tuple(q.distance, q.ring);
        });
        for (const auto& place : near) {
          const Vec2 from = rings_[place.ring].at(place.s);
          if (!free(place.ring, place.s, place.s, 0.05 * width_) || blocked(from, points.front())) continue;
          Gap gap{
              rings_[place.ring].wrapped(place.s), rings_[place.ring].wrapped(place.s), {none, none}, {from}};
          gap.spur.insert(gap.spur.end(), points.begin(), points.end());
          gap.spur.insert(gap.spur.end(), points.rbegin() + 1, points.rend());
          gap.spur.push_back(from);
          gaps_[place.ring].push_back(std::move(gap));
          for (std::size_t i = 0; i + 1 < points.size(); ++i) remember(points[i], points[i + 1]);
          remember(from, points.front());
          spur_links_.push_back(place.distance);
          done = true;
          break;
        }
        std::reverse(points.begin(), points.end());
      }
      if (!done) alone.push_back(&path);
    }
    return alone;
  }

  // From `end` on, along its ring, to the next gap: where that is left; appends the way.
  std::size_t along(std::size_t end, std::vector<Vec2>& out) const {
    const End& from = ends_[end];
    const Ring& ring = rings_[from.ring];
    const auto& gaps = gaps_[from.ring];
    // gaps in the order in which they are met
    double at = ring.wrapped(from.s);
    std::vector<std::pair<double, const Gap*>> order;
    for (const Gap& gap : gaps) {
      const double start = from.forward ? gap.from : ring.wrapped(gap.to);
      const double ahead = from.forward ? ring.wrapped(start - at) : ring.wrapped(at - start);
      order.emplace_back(gap.spur.empty() && ahead < 1e-9 ? ring.length : ahead, &gap);
    }
    std::sort(order.begin(), order.end());
    double done = 0;
    std::vector<Vec2> way;
    for (const auto& [ahead, gap] : order) {
      way.clear();
      if (from.forward) {
        ring.walk(at + done, at + ahead, way);
      } else {
        ring.walk(at - ahead, at - done, way);
        std::reverse(way.begin(), way.end());
      }
      out.insert(out.end(), way.begin(), way.end());
      done = ahead;
      if (gap->spur.empty()) return gap->end[from.forward ? 0 : 1];
      out.insert(out.end(), gap->spur.begin(), gap->spur.end());
    }
    return none;
  }

  // From the end on to where the path ends or comes back; whether it came back.
  bool follow(std::size_t at, std::vector<char>& seen, std::vector<Vec2>& points, Links& links) const {
    while (at != none && !seen[at]) {
      seen[at] = 1;
      const std::size_t leave = along(at, points);
      seen[leave] = 1;
      at = ends_[leave].to;
      if (at == none) break;
      const std::size_t start = points.size();
      points.insert(points.end(), ends_[leave].via.begin(), ends_[leave].via.end());
      Polyline link{{place(leave)}, false};
      link.points.insert(link.points.end(), points.begin() + static_cast<std::ptrdiff_t>(start),
                         points.end());
      link.points.push_back(place(at));
      links.add(length_mm(link));
    }
    return at != none;
  }

  void trace(Fill& out) {
    std::vector<char> seen(ends_.size(), 0);
    for (std::size_t e = 0; e < ends_.size(); ++e) {
      if (ends_[e].to != none || seen[e]) continue;
      std::vector<Vec2> points;
      follow(e, seen, points, out.links);
      finish(points, false, out);
    }
    for (std::size_t r = 0; r < rings_.size(); ++r) {
      const auto gap =
          std::find_if(gaps_[r].begin(), gaps_[r].end(), [](const Gap& g) { return g.spur.empty(); });
      std::vector<Vec2> points;
      if (gaps_[r].empty()) {
        out.paths.push_back(fill_.paths[rings_[r].source]);
      } else if (gap == gaps_[r].end()) {
        finish(with_spurs(r), true, out);
      } else if (!seen[gap->end[1]]) {
        follow(gap->end[1], seen, points, out.links);
        finish(points, true, out);
      }
    }
    for (const double mm : spur_links_) out.links.add(mm);
  }

  std::vector<Vec2> with_spurs(std::size_t r) const {
    std::vector<const Gap*> order;
    for (const Gap& gap : gaps_[r]) order.push_back(&gap);
    std::sort(order.begin(), order.end(), [](const Gap* a, const Gap* b) { return a->from < b->from; });
    std::vector<Vec2> points;
    double done = 0;
    for (const Gap* gap : order) {
      rings_[r].walk(done, gap->from, points);
      points.insert(points.end(), gap->spur.begin(), gap->spur.end());
      done = gap->from;
    }
    rings_[r].walk(done, rings_[r].length, points);
    return points;
  }

  static void finish(const std::vector<Vec2>& points, bool closed, Fill& out) {
    Polyline line{{}, closed};
    for (const Vec2& p : points) {
      if (line.points.empty() || (p - line.points.back()).norm() > 1e-9) line.points.push_back(p);
    }
    while (closed && line.points.size() > 1 && (line.points.back() - line.points.front()).norm() <= 1e-9)
      line.points.pop_back();
    out.paths.push_back({std::move(line), PathKind::joined, 0});
  }

  const Fill& fill_;
  double width_;
  Connection connection_;
  std::vector<Ring> rings_;
  Grid grid_;
  std::vector<Ring> boundary_;
  Grid boundary_grid_;
  std::vector<std::vector<Gap>> gaps_;
  std::vector<End> ends_;
  std::vector<Candidate> candidates_;
  std::vector<std::pair<std::size_t, std::size_t>> tree_;
  std::vector<double> spur_links_;
  std::unordered_map<std::int64_t, std::vector<std::pair<Vec2, Vec2>>> links_;
};

}  // namespace

Fill connected(const Fill& fill, const Slice& slice, double width_mm, Connection connection) {
  return Connector(fill, slice, width_mm, connection).run();
}

}  // namespace afptraj
