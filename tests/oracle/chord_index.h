#pragma once

#include <functional>
#include <unordered_map>
#include <vector>

#include "courses.h"

namespace oracle {

/// A chord between two samples of a segment, and the point of it nearest to what was asked.
struct ChordHit {
  int segment = -1;   ///< index in PlyPaths::segments
  std::size_t i = 0;  ///< chord from sample i to i + 1
  double x = 0;       ///< along the chord, in [0, 1]
  double distance = 1e300;
  Vec point{0, 0, 0};
};

/// All chords of the given segments (indices), in a hash of cubic cells.
class ChordIndex {
 public:
  ChordIndex(const PlyPaths& ply, double cell_mm, const std::vector<int>& segments);

  /// The nearest chord of each stretch that comes within `reach` of p: hits of one segment are merged
  /// unless they lie more than `apart_mm` of arc from each other. Sorted by distance.
  std::vector<ChordHit> near(const Vec& p, double reach, double apart_mm) const;

  /// The nearest chord within `reach` whose first sample `take(sample)` accepts; segment -1 when there is
  /// none.
  ChordHit nearest(const Vec& p, double reach, const std::function<bool(const Sample&)>& take) const;

  /// Chords with a cell in common with the box of a and b, each once.
  std::vector<ChordHit> beside(const Vec& a, const Vec& b) const;

 private:
  using Key = long long;
  Key key(long long x, long long y, long long z) const {
    return (x * 73856093LL) ^ (y * 19349663LL) ^ (z * 83492791LL);
  }
  const PlyPaths& ply_;
  double cell_;
  std::unordered_map<Key, std::vector<std::pair<int, std::size_t>>> cells_;
};

}  // namespace oracle
