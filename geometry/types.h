#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace afptraj {

/// A point or direction of space, mm where it is a length.
using Vec3 = Eigen::Vector3d;
/// Parameters (u, v) of a surface, or a direction in them.
using Uv = Eigen::Vector2d;

inline constexpr double pi = 3.14159265358979323846;

/// A closed interval of the real line; infinite ends are allowed.
struct Interval {
  double lo = 0;
  double hi = 0;
  double length() const { return hi - lo; }
  bool contains(double x) const { return x >= lo && x <= hi; }
};

/// A place on a skin or part: the index of the face (from 0) and its parameters.
struct SurfacePoint {
  int face = -1;
  Uv uv = Uv::Zero();
};

/// An orthonormal frame of space; left-handed ones occur in STEP files and are allowed.
struct Frame {
  Vec3 origin = Vec3::Zero();
  Vec3 x = Vec3::UnitX();
  Vec3 y = Vec3::UnitY();
  Vec3 z = Vec3::UnitZ();
};

}  // namespace afptraj
