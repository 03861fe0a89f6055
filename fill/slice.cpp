#include "fill/slice.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "fill/lattice.h"
#include "geometry/error.h"

namespace afptraj {
namespace {

constexpr double greatest_coordinate_mm = 1e6;

std::string place_text(const Vec2& p) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(9);
  text << "(" << p.x() << ", " << p.y() << ")";
  return text.str();
}

class Checker {
 public:
  Checker(const std::string& source, const InputRing& ring) : source_(source), ring_(ring) {}

  [[noreturn]] void bad(std::size_t point, const std::string& message) const {
    const bool known = point < ring_.lines.size();
    throw Error(ErrorCode::bad_input, known ? source_ + ":" + std::to_string(ring_.lines[point]) : source_,
                message);
  }

  // The ring's points without repetitions.
  InputRing sound() const {
    InputRing out{ring_.name, {}, {}};
    for (std::size_t i = 0; i < ring_.points.size(); ++i) {
      const Vec2& p = ring_.points[i];
      if (!p.allFinite()) bad(i, "a coordinate is not a finite number; give a finite one");
      if (p.cwiseAbs().maxCoeff() > greatest_coordinate_mm)
        bad(i, "a coordinate is beyond 1000000 mm; give the slice in millimetres near the origin");
      if (!out.points.empty() && p == out.points.back()) continue;
      out.points.push_back(p);
      if (i < ring_.lines.size()) out.lines.push_back(ring_.lines[i]);
    }
    while (out.points.size() > 1 && out.points.back() == out.points.front()) {
      out.points.pop_back();
      if (!out.lines.empty()) out.lines.pop_back();
    }
    if (out.points.size() < 3)
      bad(0, "ring '" + ring_.name + "' has fewer than three different points; give at least three");
    return out;
  }

 private:
  const std::string& source_;
  const InputRing& ring_;
};

struct Box {
  Vec2 lo, hi;
  explicit Box(const std::vector<Vec2>& points) : lo(points.front()), hi(lo) {
    for (const Vec2& p : points) lo = lo.cwiseMin(p), hi = hi.cwiseMax(p);
  }
  bool contains(const Vec2& p) const {
    return p.x() >= lo.x() && p.y() >= lo.y() && p.x() <= hi.x() && p.y() <= hi.y();
  }
};

bool within(const std::vector<Vec2>& ring, const Vec2& p) {
  bool in = false;
  for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
    const Vec2 &a = ring[j], &b = ring[i];
    if ((a.y() > p.y()) == (b.y() > p.y())) continue;
    if ((cross(b - a, p - a) > 0) == (b.y() > a.y())) in = !in;
  }
  return in;
}

double distance_to_ring(const std::vector<Vec2>& ring, const Vec2& p) {
  double best = HUGE_VAL;
  for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
    const Vec2 d = ring[i] - ring[j], v = p - ring[j];
    const double t = std::clamp(v.dot(d) / std::max(d.squaredNorm(), 1e-300), 0.0, 1.0);
    best = std::min(best, (v - t * d).norm());
  }
  return best;
}

// A point of `ring` that is not on `other`: its vertices and the middles of its edges are tried.
// Nothing when the two lie on each other.
const Vec2* off(const std::vector<Vec2>& ring, const std::vector<Vec2>& other, double tolerance, Vec2& keep) {
  for (std::size_t i = 0; i < ring.size(); ++i) {
    for (const double t : {0.0, 0.5}) {
      keep = (1 - t) * ring[i] + t * ring[(i + 1) % ring.size()];
      if (distance_to_ring(other, keep) > tolerance) return &keep;
    }
  }
  return nullptr;
}

// The ring that lies on another, -1 when there is none; else the slice is made.
int nest(const std::vector<std::vector<Vec2>>& rings, std::vector<SliceRing>& out) {
  std::vector<Box> boxes;
  double extent = 0;
  for (const auto& ring : rings) {
    boxes.emplace_back(ring);
    extent = std::max(extent, (boxes.back().hi - boxes.back().lo).maxCoeff());
  }
  for (std::size_t i = 0; i < rings.size(); ++i) {
    SliceRing ring{rings[i], 0};
    for (std::size_t j = 0; j < rings.size(); ++j) {
      const Vec2 middle = (boxes[i].lo + boxes[i].hi) / 2;
      if (i == j || !boxes[j].contains(middle)) continue;
      Vec2 probe;
      if (off(rings[i], rings[j], 1e-8 * extent, probe) == nullptr) {
        // Every vertex and middle of i is on j; j may still be the larger one, with more of its own.
        if (off(rings[j], rings[i], 1e-8 * extent, probe) == nullptr) return static_cast<int>(i);
        continue;
      }
      if (within(rings[j], probe)) ++ring.depth;
    }
    if ((signed_area(ring.points) > 0) != (ring.depth % 2 == 0))
      std::reverse(ring.points.begin(), ring.points.end());
    out.push_back(std::move(ring));
  }
  return -1;
}

void refuse_crossings(const std::string& source, const std::vector<InputRing>& rings) {
  std::vector<Vec2> all;
  for (const InputRing& ring : rings) all.insert(all.end(), ring.points.begin(), ring.points.end());
  const Lattice lattice(all, 0);
  std::vector<LatticeSegment> segments;
  std::vector<std::pair<std::size_t, std::size_t>> origin;
  for (std::size_t r = 0; r < rings.size(); ++r) {
    const auto& points = rings[r].points;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const LatticeSegment s{lattice.snap(points[i]), lattice.snap(points[(i + 1) % points.size()])};
      if (s.a == s.b) continue;
      segments.push_back(s);
      origin.emplace_back(r, i);
    }
  }
  std::pair<std::size_t, std::size_t> first{segments.size(), 0};
  for_each_close_pair(segments, [&](std::size_t i, std::size_t j) {
    if (std::pair(i, j) < first && meeting(segments[i], segments[j]).kind == Meeting::cross) first = {i, j};
  });
  if (first.first == segments.size()) return;
  const auto [r, i] = origin[first.first];
  const auto [q, j] = origin[first.second];
  const Vec2 at = lattice.mm(meeting(segments[first.first], segments[first.second]).at_first.real());
  const bool self = r == q;
  Checker(source, rings[r])
      .bad(i, "ring '" + rings[r].name + "' crosses " + (self ? "itself" : "ring '" + rings[q].name + "'") +
                  " at " + place_text(at) + ", between its point " + std::to_string(i) + " and point " +
                  std::to_string(j) + (self ? "" : " of the other") + "; make the rings simple");
}

}  // namespace

Slice::Slice(const std::string& source, const std::vector<InputRing>& rings) {
  if (rings.empty()) throw Error(ErrorCode::bad_input, source, "holds no ring; give at least one outline");
  std::vector<InputRing> sound;
  std::vector<std::vector<Vec2>> points;
  for (const InputRing& ring : rings) {
    sound.push_back(Checker(source, ring).sound());
    points.push_back(sound.back().points);
  }
  refuse_crossings(source, sound);
  for (const InputRing& ring : sound) {
    const Box box(ring.points);
    if (std::abs(signed_area(ring.points)) <= 1e-9 * (box.hi - box.lo).squaredNorm())
      Checker(source, ring)
          .bad(0, "ring '" + ring.name + "' encloses no area; give an outline with an inside");
  }
  const int twice = nest(points, rings_);
  if (twice >= 0) {
    const InputRing& ring = sound[static_cast<std::size_t>(twice)];
    Checker(source, ring).bad(0, "ring '" + ring.name + "' lies on another ring; give it once");
  }
}

Slice nested_slice(const std::vector<std::vector<Vec2>>& rings) {
  std::vector<SliceRing> out;
  nest(rings, out);
  return Slice(std::move(out));
}

double Slice::area_mm2() const {
  double sum = 0;
  for (const SliceRing& ring : rings_) sum += signed_area(ring.points);
  return sum;
}

std::vector<Vec2> points_of(const Slice& slice) {
  std::vector<Vec2> all;
  for (const SliceRing& ring : slice.rings()) all.insert(all.end(), ring.points.begin(), ring.points.end());
  return all;
}

bool contains(const Slice& slice, const Vec2& point) {
  bool in = false;
  for (const SliceRing& ring : slice.rings()) in = in != within(ring.points, point);
  return in;
}

}  // namespace afptraj
