#pragma once

#include <optional>
#include <vector>

#include "geometry/part.h"
#include "geometry/trim_region.h"

namespace afptraj {

/// A face as a surface of revolution.
struct Revolution {
  Vec3 point = Vec3::Zero();       ///< of the axis, nearest to the middle of the face
  Vec3 direction = Vec3::UnitZ();  ///< of the axis, unit; its greatest component is positive
  double deviation_mm = 0;         ///< greatest distance found between the face and its turned copies
  double radius_min_mm = 0, radius_max_mm = 0;
  /// (place along the axis from `point`, radius) over the face, sorted by the first: at most
  /// `profile_points`.
  std::vector<Eigen::Vector2d> profile;
  static constexpr std::size_t profile_points = 9;
};

/// Whether a face is a surface of revolution to `tolerance_mm`; planes are not counted. Cylinders,
/// cones, spheres and tori are known in closed form. On a B-spline the axis is the line that all
/// normals meet: the null vector (a, m) of  a.(p x n) + m.n  over samples (p, n), with a.m = 0; it is
/// then judged by turning samples about it and measuring their distance to the surface.
/// Source: Pottmann & Randrup, "Rotational and helical surface approximation for reverse
/// engineering", Computing 60 (1998).
std::optional<Revolution> find_revolution(const Part& part, int face, const TrimRegion& trim,
                                          double tolerance_mm);

}  // namespace afptraj
