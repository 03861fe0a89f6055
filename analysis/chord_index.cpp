#include "analysis/chord_index.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace afptraj {
namespace {

constexpr std::size_t run_length = 6;  // chords

}  // namespace

ChordIndex::ChordIndex(const std::vector<CourseLine>& lines) : lines_(lines) {
  for (std::size_t l = 0; l < lines.size(); ++l) {
    const CourseLine& line = lines[l];
    for (std::size_t begin = 0; begin < line.chord_count(); begin += run_length) {
      Run run{{}, static_cast<int>(l), begin, std::min(begin + run_length, line.chord_count())};
      for (std::size_t i = run.begin; i <= run.end; ++i) {
        run.box.lo = run.box.lo.cwiseMin(line.points[i]);
        run.box.hi = run.box.hi.cwiseMax(line.points[i]);
      }
      runs_.push_back(run);
    }
  }
  std::vector<int> order(runs_.size());
  std::iota(order.begin(), order.end(), 0);
  nodes_.reserve(2 * runs_.size());
  if (!order.empty()) build(order, 0, order.size());
}

void ChordIndex::build(std::vector<int>& runs, std::size_t begin, std::size_t end) {
  const std::size_t at = nodes_.size();
  nodes_.emplace_back();
  Box box;
  for (std::size_t i = begin; i < end; ++i) {
    const Box& b = runs_[static_cast<std::size_t>(runs[i])].box;
    box.lo = box.lo.cwiseMin(b.lo);
    box.hi = box.hi.cwiseMax(b.hi);
  }
  nodes_[at].box = box;
  if (end - begin == 1) {
    nodes_[at].run = runs[begin];
    return;
  }
  int axis = 0;
  (box.hi - box.lo).maxCoeff(&axis);
  const std::size_t middle = (begin + end) / 2;
  const auto place = [&](int r) {
    const Box& b = runs_[static_cast<std::size_t>(r)].box;
    return b.lo[axis] + b.hi[axis];
  };
  std::nth_element(runs.begin() + static_cast<std::ptrdiff_t>(begin), runs.begin() + static_cast<std::ptrdiff_t>(middle),
                   runs.begin() + static_cast<std::ptrdiff_t>(end),
                   [&](int a, int b) { return std::make_pair(place(a), a) < std::make_pair(place(b), b); });
  build(runs, begin, middle);
  nodes_[at].right = static_cast<int>(nodes_.size());
  build(runs, middle, end);
}

ChordIndex::Hit ChordIndex::nearest_on(int line, std::size_t chord, const Vec3& p) const {
  const auto& points = lines_[static_cast<std::size_t>(line)].points;
  const Vec3& a = points[chord];
  const Vec3 ab = points[chord + 1] - a;
  const double length2 = ab.squaredNorm();
  const double x = length2 > 0 ? std::clamp((p - a).dot(ab) / length2, 0.0, 1.0) : 0.0;
  return {line, chord, x, (a + x * ab - p).norm()};
}

bool ChordIndex::is_minimum(const Hit& hit, const Vec3& p) const {
  // Within a chord it is one. Of two chords that share the nearest vertex the first has it.
  const CourseLine& line = lines_[static_cast<std::size_t>(hit.line)];
  if (hit.x <= 0) return hit.chord == 0 && !line.closed();
  if (hit.x < 1) return true;
  const bool last = hit.chord + 1 == line.chord_count();
  if (last && !line.closed()) return true;
  return nearest_on(hit.line, last ? 0 : hit.chord + 1, p).x <= 0;
}

void ChordIndex::sort_by_distance(std::vector<Hit>& hits) {
  std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) {
    return std::tie(a.distance_mm, a.line, a.chord) < std::tie(b.distance_mm, b.line, b.chord);
  });
}

}  // namespace afptraj
