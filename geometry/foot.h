#pragma once

#include <array>
#include <optional>

#include "geometry/surface.h"

/// Feet of perpendiculars. Internal to this room; see closest_point.h.
namespace afptraj::foot {

/// The feet on an analytic surface in closed form, nearest first where they differ in kind. Angles
/// that a point on an axis leaves open are those of `seed`.
struct Feet {
  std::array<Uv, 4> uv;
  int count = 0;
};
Feet analytic_feet(const Surface& surface, const Vec3& p, const Uv& seed);

/// (u, v) turned by whole periods so that it lies as near to `to` as it can.
Uv unwrap(const Surface& surface, Uv uv, const Uv& to);

/// Where a Newton iteration may go: it gives up outside of [lo, hi], and takes no step longer than
/// `most`. The polynomial of `span` is used where it is given.
struct Limits {
  Uv lo, hi, most;
  const Span* span = nullptr;
};

struct Foot {
  Uv uv;
  Vec3 point;
  double distance = 0;
};

/// Newton-Raphson on f = |S - p|^2 / 2 with descent: where the Hessian is not positive definite the
/// step is that of Gauss-Newton, and steps that do not descend are halved.
std::optional<Foot> descend(const Surface& surface, const Vec3& p, const Uv& seed, const Limits& limits,
                            double tolerance_mm);

}  // namespace afptraj::foot
