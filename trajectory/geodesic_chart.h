#pragma once

#include <memory>
#include <optional>

#include "geometry/geodesic.h"

namespace afptraj {

class GeodesicPath;

/// Coordinates about a geodesic of the skin (Fermi's): (s, w) is reached by walking s mm along it, then
/// w mm to its left along the geodesic that leaves it at a right angle.
///
/// The metric is y^2 ds^2 + dw^2 with the Jacobi field y of the geodesics across, so the chart is regular
/// wherever y > 0 - over a pole, an edge, a seam or a crease too, where (u, v) is not.
/// Source: Gray, Tubes, ch. 2 (Fermi coordinates).
class GeodesicChart {
 public:
  /// About the geodesic through `at` along `direction`, from `back_mm` before it to `ahead_mm` after it, less
  /// where it leaves the skin sooner.
  GeodesicChart(const Skin& skin, const SurfacePoint& at, const Vec3& direction, int normal_sign,
                double back_mm, double ahead_mm, const GeodesicOptions& options);

  double length_mm() const;
  /// The coordinates of the point it was made about.
  Uv origin() const { return {origin_mm_, 0}; }

  /// A point of the chart, with the normal that the geodesics carry. Of the second derivatives by s and w
  /// only the parts in the tangent plane are given.
  struct Place {
    SurfacePoint at;
    int normal_sign = 1;
    Vec3 normal = Vec3::Zero();
    SurfaceDerivatives d;
  };
  /// Where the geodesic across leaves the skin, as far as it leads.
  Place place(const Uv& sw) const;

  /// The coordinates of a point of the skin, by Newton-Raphson from `seed`; nothing when they are not found
  /// to 1e-7 mm (a geodesic over a pole is off by up to that), or where the chart is stretched or pressed to
  /// less than half.
  std::optional<Uv> coordinates(const Vec3& p, const Uv& seed) const;

 private:
  GeodesicState walk(const Uv& sw) const;

  std::shared_ptr<const GeodesicTracer> tracer_;
  std::shared_ptr<const GeodesicPath> base_;
  double origin_mm_ = 0;
};

}  // namespace afptraj
