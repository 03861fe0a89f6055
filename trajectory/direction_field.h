#pragma once

#include <memory>
#include <vector>

#include "geometry/skin.h"
#include "trajectory/ply_orientation.h"

namespace afptraj {

/// A ply point with the normal of the skin where it is nearest.
struct OrientationPoint {
  Vec3 position = Vec3::Zero();
  Vec3 direction = Vec3::UnitX();  ///< unit
  Vec3 skin_normal = Vec3::Zero(); ///< zero: unknown, counts everywhere
};

/// What the field asks for at a point.
struct AskedDirection {
  Vec3 direction = Vec3::Zero();  ///< unit, in the tangent plane, in the sense of the walk
  double range_mm = 0;            ///< range that was used
  bool range_doubled = false;     ///< no point lay within the asked range
  double strength = 0;            ///< length of the average in the tangent plane: 1 where all ask for the same
  bool singular = false;          ///< the sum cancels (|V| < 1e-6), or points along the normal
};

/// The modified placement direction: the weighted average of the given directions.
///
///   V(P) = sum over R_k <= range of w_k V_k,   w_k = (1/R_k) / sum (1/R_i)
///
/// with R_k the distance of P_k from the normal line at P. Directions are axes: each is turned to the
/// sense of `walk` before adding. Points on an opposite wall (their skin normal faces away from n) do
/// not count. R_k = 0 gives V_k. With no point in range, the range doubles until one is.
class DirectionField {
 public:
  /// Throws std::invalid_argument unless range_mm > 0.
  DirectionField(std::vector<OrientationPoint> points, double range_mm);

  /// `normal`: unit normal of the skin at `p`; `walk`: the sense to keep.
  AskedDirection at(const Vec3& p, const Vec3& normal, const Vec3& walk) const;

  const std::vector<OrientationPoint>& points() const { return points_; }

 private:
  std::vector<OrientationPoint> points_;
  double range_mm_;
};

/// The field of a ply: looks up the skin's normal at each point. Throws Error(bad_input) naming line
/// and distance when a point lies farther than `limit_mm` from the skin; `file` names the source.
DirectionField make_direction_field(const Skin& skin, const PlyOrientation& ply, double range_mm, double limit_mm,
                                    const std::string& file);

}  // namespace afptraj
