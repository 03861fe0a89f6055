#pragma once

#include <optional>

#include "geometry/section.h"

/// Marching along plane ∩ surface. Internal to this room; see section.h.
namespace afptraj::sections {

/// A point of the section on one face, with the frame of the march there.
struct MarchPoint {
  int face = -1;
  Uv uv = Uv::Zero();
  SurfaceDerivatives d;
  Vec3 tangent = Vec3::Zero();   ///< unit, in the sense of the march
  Uv velocity = Uv::Zero();      ///< d(uv)/ds
  Uv acceleration = Uv::Zero();  ///< d2(uv)/ds2
  Vec3 bend = Vec3::Zero();      ///< curvature vector
  double kappa = 0;              ///< its length
};

/// March over the faces of a skin; `sense` tells, face by face, the section's tangent
/// n_surface x n_plane from its opposite.
class March {
 public:
  March(const Skin& skin, const Plane& plane);

  double height(const Vec3& p) const { return plane_.normal.dot(p - plane_.origin); }
  double height_rate(const Vec3& direction) const { return plane_.normal.dot(direction); }

  /// Nothing where surface and plane touch (or at a pole): the section has no direction there.
  std::optional<MarchPoint> at(int face, const Uv& uv, double sense) const;
  std::optional<MarchPoint> at(int face, const Uv& uv, const SurfaceDerivatives& d, double sense) const;
  /// The nearby point of face ∩ plane: a Newton iteration across the section.
  std::optional<Uv> onto_plane(int face, Uv uv) const;
  /// The sense in which the march at (face, uv) goes toward `heading`.
  double sense_toward(int face, const Uv& uv, const Vec3& heading) const;

  /// The point of the section at distance `h` from `from` along from.tangent.
  std::optional<MarchPoint> advance(const MarchPoint& from, double h, double sense, const Uv& guess) const;

  /// A step with its arc length, by two fourth-order rules whose combination is of sixth order.
  struct Step {
    MarchPoint to;
    double length = 0;
    double error = 0;
    UvCubic path;
  };
  /// Nothing when the march fails over so long a step.
  std::optional<Step> step(const MarchPoint& from, double h, double sense) const;
  /// The step to a known point of the section on the same face.
  std::optional<Step> step_to(const MarchPoint& from, const MarchPoint& to, double sense) const;

  const Skin& skin() const { return skin_; }
  double rounding() const { return rounding_; }

 private:
  /// Newton for the (u, v) of `advance`, and the derivatives there.
  bool solve(const MarchPoint& from, double h, Uv& uv, SurfaceDerivatives& d) const;
  /// Unit tangent of the section; zero where surface and plane touch.
  Vec3 tangent(const SurfaceDerivatives& d, double sense) const;

  const Skin& skin_;
  Plane plane_;
  double rounding_;  ///< of a height above the plane, mm
};

}  // namespace afptraj::sections
