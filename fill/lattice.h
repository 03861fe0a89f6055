#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "fill/planar.h"

namespace afptraj {

/// A point of the integer lattice on which the diagrams are built. |x|, |y| <= 2^29, so that the orientation
/// of three points is exact in 64 bits.
struct LatticePoint {
  std::int32_t x = 0, y = 0;
  auto operator<=>(const LatticePoint&) const = default;
  Vec2 real() const { return {x, y}; }
};

/// A straight piece; of a boundary, with the material to its left.
struct LatticeSegment {
  LatticePoint a, b;
};

/// Between millimetres and the lattice. The unit is a power of two, so that coordinates that are multiples of
/// it (whole numbers, halves, quarters ...) are met exactly; others are moved by at most unit / sqrt(2).
class Lattice {
 public:
  /// Covers the box of `points`, enlarged by `margin_mm` on all sides.
  Lattice(const std::vector<Vec2>& points, double margin_mm);
  double unit_mm() const { return unit_; }
  LatticePoint snap(const Vec2& mm) const;
  Vec2 mm(const Vec2& lattice) const { return origin_ + unit_ * lattice; }
  /// The corners of the covered box, anticlockwise.
  std::vector<LatticePoint> frame() const;

 private:
  Vec2 origin_ = Vec2::Zero(), half_ = Vec2::Zero();
  double unit_ = 1;
};

/// Twice the area of the triangle, positive when it runs anticlockwise; exact.
std::int64_t orientation(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c);

/// Calls `visit(i, j)`, i < j, for all pairs of segments whose boxes meet; some pairs more than once. O(n +
/// pairs) for segments of about equal length.
void for_each_close_pair(const std::vector<LatticeSegment>& segments,
                         const std::function<void(std::size_t, std::size_t)>& visit);

/// How two segments meet.
enum class Meeting { none, touch, cross };
struct MeetingOf {
  Meeting kind = Meeting::none;
  bool split_first = false, split_second = false;
  LatticePoint at_first, at_second;  ///< where to split
};
/// An end of one within two units of the other is a touch: that much a snapped point may have moved.
MeetingOf meeting(const LatticeSegment& first, const LatticeSegment& second);

/// Splits segments where they meet, until they have at most ends in common; crossings move by at most one
/// unit. Segments of no length go. Throws Error(no_path) when that does not come to an end.
std::vector<LatticeSegment> split_at_meetings(std::vector<LatticeSegment> segments);

}  // namespace afptraj
