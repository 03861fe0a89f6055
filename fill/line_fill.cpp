#include "fill/line_fill.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "fill/contour_parallel.h"
#include "fill/voids.h"

namespace afptraj {
namespace {

constexpr std::size_t none = static_cast<std::size_t>(-1);

// Where a ring crosses a line of the pattern.
struct Crossing {
  std::size_t ring = 0, edge = 0;  // from point `edge` of the ring to the next one
  double share = 0;                // of that edge
  int line = 0;
  double along = 0;  // on the line
  Vec2 at;
  std::size_t segment = none;
  std::size_t forward = none;  // the next crossing on the ring
  std::size_t up = none;       // the end of a segment on line + 1 to which a link leads
};

// A stretch of a line, between two crossings.
struct Segment {
  std::size_t end[2];
  bool laid = false;
};

class Lines {
 public:
  Lines(std::vector<Polyline> rings, const LineOptions& options, double inset, double spare)
      : rings_(std::move(rings)),
        options_(options),
        along_(Eigen::Rotation2Dd(options.angle_rad) * Vec2(1, 0)) {
    place(inset, spare);
    cut();
    pair();
    order_rings();
  }

  Fill raster() const {
    Fill fill;
    for (const Segment& s : segments_)
      fill.paths.push_back({{{crossings_[s.end[0]].at, crossings_[s.end[1]].at}, false}, PathKind::line, 0});
    return fill;
  }

  Fill zigzag() {
    find_links();
    Fill fill;
    for (std::size_t s = 0; s < segments_.size(); ++s) {
      if (segments_[s].laid) continue;
      // the sense in which more lines follow; the way that is not taken is no longer than the one that is
      const std::size_t forth = steps(s, 0), back = steps(s, 1);
      lay(s, back > forth ? 1 : 0, fill);
    }
    return fill;
  }

 private:
  double height(const Vec2& p) const { return cross(along_, p); }

  // Evenly spaced lines, `inset` within the rings' extent; `spare` is how much too large the rings are.
  void place(double inset, double spare) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const Polyline& ring : rings_) {
      for (const Vec2& p : ring.points) low = std::min(low, height(p)), high = std::max(high, height(p));
    }
    if (rings_.empty()) return;
    low += inset + spare, high -= inset + spare;
    if (high <= low) {
      lowest_ = (low + high) / 2, step_ = options_.spacing_mm, count_ = 1;
      return;
    }
    // what rounding adds to a whole number of spacings is no reason for one more line
    const double whole = (high - low) / options_.spacing_mm;
    const int pieces = std::max(1, static_cast<int>(std::ceil(whole - 1e-6)));
    lowest_ = low, step_ = (high - low) / pieces, count_ = pieces + 1;
  }

  // The first line at or above the height.
  int line_above(double h) const {
    return static_cast<int>(std::clamp(std::ceil((h - lowest_) / step_), 0.0, static_cast<double>(count_)));
  }
  double height_of(int line) const { return lowest_ + line * step_; }

  // All crossings; a point on a line counts as above it.
  void cut() {
    for (std::size_t r = 0; r < rings_.size(); ++r) {
      const auto& points = rings_[r].points;
      const std::size_t n = points.size();
      std::vector<int> above(n);
      for (std::size_t i = 0; i < n; ++i) {
        int& line = above[i];
        line = line_above(height(points[i]));
        // line: the number of lines strictly below the point, whatever rounding did
        while (line > 0 && height_of(line - 1) >= height(points[i])) --line;
        while (line < count_ && height_of(line) < height(points[i])) ++line;
      }
      for (std::size_t i = 0; i < n; ++i) {
        const std::size_t j = i + 1 == n ? 0 : i + 1;
        const Vec2 &a = points[i], &b = points[j];
        const double ha = height(a), hb = height(b);
        const auto add = [&](int line) {
          const double share = std::clamp((height_of(line) - ha) / (hb - ha), 0.0, 1.0);
          const Vec2 at = a + share * (b - a);
          crossings_.push_back({r, i, share, line, along_.dot(at), at});
        };
        for (int line = above[i]; line < above[j]; ++line) add(line);
        for (int line = above[i]; line > above[j]; --line) add(line - 1);
      }
    }
  }

  // Crossings of a line two by two, in the order along it: the stretches within.
  void pair() {
    std::vector<std::size_t> order(crossings_.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return std::tuple(crossings_[a].line, crossings_[a].along, a) <
             std::tuple(crossings_[b].line, crossings_[b].along, b);
    });
    for (std::size_t i = 0; i + 1 < order.size(); i += 2) {
      Crossing &from = crossings_[order[i]], &to = crossings_[order[i + 1]];
      if (to.along - from.along < options_.spacing_mm / 20) continue;
      from.segment = to.segment = segments_.size();
      segments_.push_back({{order[i], order[i + 1]}});
    }
  }

  // The next crossing on each ring that ends a segment. Crossings were made in the order of the rings.
  void order_rings() {
    for (std::size_t begin = 0; begin < crossings_.size();) {
      std::size_t end = begin;
      std::vector<std::size_t> ends;
      for (; end < crossings_.size() && crossings_[end].ring == crossings_[begin].ring; ++end) {
        if (crossings_[end].segment != none) ends.push_back(end);
      }
      for (std::size_t i = 0; i < ends.size(); ++i)
        crossings_[ends[i]].forward = ends[i + 1 == ends.size() ? 0 : i + 1];
      begin = end;
    }
  }

  // The ring from one crossing on to the next one, as points.
  std::vector<Vec2> way(const Crossing& from, const Crossing& to) const {
    const auto& points = rings_[from.ring].points;
    const std::size_t n = points.size();
    std::vector<Vec2> out{from.at};
    std::size_t count = (to.edge + n - from.edge) % n;
    if (count == 0 && to.share <= from.share) count = n;
    for (std::size_t k = 1; k <= count; ++k) out.push_back(points[(from.edge + k) % n]);
    out.push_back(to.at);
    return out;
  }

  void find_links() {
    for (std::size_t c = 0; c < crossings_.size(); ++c) {
      const std::size_t next = crossings_[c].forward;
      if (next == none || next == c) continue;
      const int rise = crossings_[next].line - crossings_[c].line;
      if (std::abs(rise) != 1) continue;
      if (length_mm(Polyline{way(crossings_[c], crossings_[next]), false}) > options_.most_link_mm) continue;
      (rise > 0 ? crossings_[c].up : crossings_[next].up) = rise > 0 ? next : c;
    }
  }

  // Leads from the end at which segment `s` is left to the end at which the next one is entered.
  std::size_t link(std::size_t left_at) const {
    const std::size_t to = crossings_[left_at].up;
    return to == none || segments_[crossings_[to].segment].laid ? none : to;
  }
  // The end of the same segment across from `end`.
  std::size_t across(std::size_t end) const {
    const Segment& s = segments_[crossings_[end].segment];
    return s.end[0] == end ? s.end[1] : s.end[0];
  }

  std::size_t steps(std::size_t segment, int from) const {
    std::size_t count = 0;
    for (std::size_t end = segments_[segment].end[1 - from]; (end = link(end)) != none; end = across(end))
      ++count;
    return count;
  }

  void lay(std::size_t segment, int from, Fill& fill) {
    Polyline line;
    const auto add = [&](const Vec2& p) {
      if (line.points.empty() || (p - line.points.back()).norm() > 1e-9) line.points.push_back(p);
    };
    std::size_t enter = segments_[segment].end[from];
    for (;;) {
      segments_[crossings_[enter].segment].laid = true;
      add(crossings_[enter].at);
      const std::size_t leave = across(enter);
      add(crossings_[leave].at);
      const std::size_t next = link(leave);
      if (next == none) break;
      std::vector<Vec2> points;
      if (crossings_[leave].forward == next) {
        points = way(crossings_[leave], crossings_[next]);
      } else {
        points = way(crossings_[next], crossings_[leave]);
        std::reverse(points.begin(), points.end());
      }
      fill.links.add(length_mm(Polyline{points, false}));
      for (const Vec2& p : points) add(p);
      enter = next;
    }
    fill.paths.push_back({std::move(line), PathKind::line, 0});
  }

  std::vector<Polyline> rings_;
  const LineOptions& options_;
  Vec2 along_;
  double lowest_ = 0, step_ = 1;
  int count_ = 0;
  std::vector<Crossing> crossings_;
  std::vector<Segment> segments_;
};

}  // namespace

Fill line_fill(const Slice& slice, const LineOptions& options) {
  const double half = options.spacing_mm / 2, end = options.first_mm + (options.outline ? half : 0);
  const DistanceDiagram diagram = DistanceDiagram::of(slice, std::max(0.0, -options.first_mm) + half);
  Fill fill;
  if (options.outline) fill.paths = outermost_paths(slice, diagram, options.first_mm, options.tolerance_mm);
  // Lines may lie on straight stretches of the level curve: it is taken this much too far out, far above
  // rounding and far below what matters, so that they are inside.
  const double spare = 16 * diagram.unit_mm() + 1e-6 * options.spacing_mm;
  std::vector<Polyline> rings;
  if (end - spare == 0) {
    for (const SliceRing& ring : slice.rings()) rings.push_back({ring.points, true});
  } else {
    for (const ArcRing& ring : diagram.level(end - spare, 4 * diagram.unit_mm())) {
      Polyline line = flattened(ring, options.tolerance_mm);
      if (line.points.size() >= 3) rings.push_back(std::move(line));
    }
  }
  Lines lines(std::move(rings), options, options.outline ? half : 0, spare);
  Fill laid = options.zigzag ? lines.zigzag() : lines.raster();
  fill.links = laid.links;
  for (FillPath& path : laid.paths) fill.paths.push_back(std::move(path));
  if (options.outline) {
    fill_voids(fill, slice, options.spacing_mm, 3 * options.tolerance_mm,
               options.least_void_share * options.spacing_mm * options.spacing_mm);
  }
  return fill;
}

}  // namespace afptraj
