#pragma once

#include <vector>

#include "winding/meridian.h"

namespace afptraj {

/// The room that a mandrel takes up, and the surface on which a payout eye may travel about it: all places at
/// `clearance` from the convex hull of mandrel and end planes. The hull is convex, so that a ray from within
/// leaves the envelope once, and the place where it does depends on the ray without jumps.
///
/// The outline is a polygon on the meridian whose chords stay within `outline_sagitta_mm` of it.
class ClearanceEnvelope {
 public:
  /// REQUIRES: clearance_mm > 0.
  ClearanceEnvelope(const Meridian& meridian, double clearance_mm);

  double clearance_mm() const { return clearance_mm_; }
  double widest_mm() const { return widest_mm_; }

  /// From the hull to a place at z and at `radius` from the axis, and how it grows by both; 0 inside.
  struct Distance {
    double mm = 0, by_z = 0, by_radius = 0;
  };
  Distance distance(double z_mm, double radius_mm) const;

  /// How deep a place lies below the mandrel's own surface, along the radius; negative: above it, or beside.
  double depth_mm(double z_mm, double radius_mm) const;

 private:
  double clearance_mm_, widest_mm_;
  std::vector<MeridianRow> outline_;  // the meridian, z growing
  std::vector<MeridianRow> hull_;     // from the axis over the outside to the axis
};
inline constexpr double outline_sagitta_mm = 1e-3;

}  // namespace afptraj
