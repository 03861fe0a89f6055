#pragma once

#include <string>
#include <vector>

#include "fill/planar.h"

namespace afptraj {

/// A ring as it was given: any sense, the first point not repeated at its end.
struct InputRing {
  std::string name;  ///< for messages
  std::vector<Vec2> points;
  std::vector<int> lines;  ///< where each point stands in the file; may be empty
};

/// A ring of a slice: the material lies to its left, outlines run anticlockwise and holes clockwise.
struct SliceRing {
  std::vector<Vec2> points;
  int depth = 0;  ///< 0 outline, 1 hole, 2 island in a hole ...
};

/// The plane area that is filled: all points that lie within an odd number of rings. A value.
class Slice {
 public:
  /// Works out sense and nesting. Rings may touch, each other and themselves; edges that two rings share
  /// vanish. Points that repeat the one before are dropped. Throws Error(bad_input, `source` or
  /// `source`:line) for no ring, fewer than three points, coordinates that are no finite numbers or beyond
  /// 1e6 mm, a ring of no area, edges that cross (with the place), a ring given twice.
  Slice(const std::string& source, const std::vector<InputRing>& rings);
  /// Of rings that are known to be sound, such as offsets.
  explicit Slice(std::vector<SliceRing> rings) : rings_(std::move(rings)) {}

  const std::vector<SliceRing>& rings() const { return rings_; }
  double area_mm2() const;

 private:
  std::vector<SliceRing> rings_;
};

/// Rings of any sense that neither cross nor coincide, sorted into a slice: sense and depth by nesting.
Slice nested_slice(const std::vector<std::vector<Vec2>>& rings);

/// All points of a slice.
std::vector<Vec2> points_of(const Slice& slice);

/// Whether `point` lies within the slice (on its edge: either answer).
bool contains(const Slice& slice, const Vec2& point);

}  // namespace afptraj
