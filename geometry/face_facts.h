#pragma once

#include <memory>
#include <vector>

#include "geometry/part.h"
#include "geometry/trim_region.h"

namespace afptraj {

/// What can be said of a face at a glance; lengths in mm, to about three digits.
struct FaceFacts {
  double area_mm2 = 0;
  Vec3 box_min = Vec3::Zero(), box_max = Vec3::Zero();
  /// 1 / greatest principal curvature found; infinite for a plane.
  double smallest_radius_mm = 0;
  int holes = 0;                ///< loops that run clockwise in (u, v)
  std::vector<int> neighbours;  ///< faces over shared edges, sorted, without itself
};
FaceFacts face_facts(const Part& part, int face, const TrimRegion& trim);

/// The group of tangent-connected faces (see grow_tangent) that most of `points` are nearest to.
/// Between groups with as many points the one with the lowest face wins. `trim` holds a region for
/// every face of the part. Sorted; empty only for a part without faces or no points.
std::vector<int> nearest_tangent_group(const std::shared_ptr<const Part>& part,
                                       const std::vector<std::shared_ptr<const TrimRegion>>& trim,
                                       const std::vector<Vec3>& points, double angle_rad);

}  // namespace afptraj
