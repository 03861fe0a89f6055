#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "geometry/part.h"
#include "geometry/trim_region.h"

namespace afptraj {

/// The nearest point found: place, distance, and whether it is a foot of a perpendicular inside
/// the face or lies on its boundary (a trim loop). A foot within 1e-10 mm of the boundary's distance
/// is preferred, so that a point over a seam or a smooth shared edge is not called one of the boundary.
struct ClosestPoint {
  SurfacePoint at;
  Vec3 point = Vec3::Zero();
  double distance_mm = std::numeric_limits<double>::infinity();
  bool on_boundary = false;
};

/// Newton-Raphson for the foot of the perpendicular from `p` near `seed`, on the untrimmed surface
/// (no loops). Nothing when it does not converge to a foot: |r.Su| <= tol |Su| and the same for v,
/// with r = S - p. Source: Piegl & Tiller, ch. 6.1.
std::optional<Uv> foot_point(const Surface& surface, const Vec3& p, const Uv& seed,
                             double tolerance_mm = 1e-11);

/// Finds closest points on a set of trimmed faces; an immutable value.
///
/// Law (C1), checked against brute force by tests/closest_point_test.cpp: no point of the faces is
/// nearer than the one returned, to 1e-9 mm; edges, corners and poles included.
///
/// A coarse index of bounding boxes over pieces of the faces (built once) gives candidates in
/// order of a lower bound; each is refined by Newton; the search ends when no box is nearer than
/// the best point.
class ClosestPointFinder {
 public:
  /// `faces` are indices into part.faces, all when empty; trim[i] belongs to part.faces[i]
  /// (only those of `faces` need to be set).
  ClosestPointFinder(std::shared_ptr<const Part> part, std::vector<int> faces,
                     std::vector<std::shared_ptr<const TrimRegion>> trim);

  /// Nothing only if no point lies within `limit_mm`. A face is passed over where its normal n
  /// (turned by the face's orientation) has n . facing < 0, when `facing` is given.
  std::optional<ClosestPoint> closest(const Vec3& p,
                                      double limit_mm = std::numeric_limits<double>::infinity(),
                                      const Vec3* facing = nullptr) const;

 private:
  struct Data;
  std::shared_ptr<const Data> data_;
};

}  // namespace afptraj
