#include "winding/payout_eye.h"

#include <algorithm>
#include <cmath>

#include "geometry/error.h"
#include "winding/number_words.h"

namespace afptraj {
namespace {

// A place on the thread, at `way` from the mandrel: along the axis, from it, and round it from the contact.
struct ThreadPlace {
  double z_mm, radius_mm, azimuth_rad;
};

ThreadPlace on_thread(const FibreTangent& path, double way) {
  const double x = path.r_mm + way * path.radial, y = way * path.hoop;
  return {path.z_mm + way * path.axial, std::hypot(x, y), std::atan2(y, x)};
}

}  // namespace

FibreTangent fibre_tangent(const Meridian& meridian, double t, double turn_rad, double angle_rad) {
  const MeridianPoint at = meridian.at(t);
  const double along = std::cos(angle_rad) / at.speed();
  return {at.z_mm, at.r_mm, turn_rad, along * at.dr, std::sin(angle_rad), along * at.dz};
}

PayoutEye::PayoutEye(const Meridian& meridian, const EyeRoom& room)
    : envelope_(meridian, room.clearance_mm), fixed_mm_(room.fixed_mm) {
  const double least = envelope_.widest_mm() + room.clearance_mm;
  if (fixed_mm_ && *fixed_mm_ < least) {
    throw Error(ErrorCode::no_path, "machine",
                "its eye stands " + significant_text(*fixed_mm_, 6) +
                    " mm from the axis, which is nearer to the mandrel than the clearance; " +
                    significant_text(least, 6) + " mm are needed");
  }
  const double length = meridian.at(meridian.last()).z_mm - meridian.at(meridian.first()).z_mm;
  farthest_mm_ = 2 * (length + 2 * least);
}

double PayoutEye::free_length(const FibreTangent& path) const {
  if (fixed_mm_) {
    // |r + l T| = c across the axis: the positive root, without cancellation.
    const double square = path.radial * path.radial + path.hoop * path.hoop;
    const double half = path.r_mm * path.radial, rest = *fixed_mm_ * *fixed_mm_ - path.r_mm * path.r_mm;
    const double root = std::sqrt(half * half + square * rest);
    return half > 0 ? rest / (half + root) : (root - half) / square;
  }
  // The distance from a convex body is convex along the ray, so that Newton's method comes down from outside.
  double way = farthest_mm_;
  for (int i = 0; i < 60; ++i) {
    const ThreadPlace at = on_thread(path, way);
    const ClearanceEnvelope::Distance far = envelope_.distance(at.z_mm, at.radius_mm);
    const double outward = path.radial * std::cos(at.azimuth_rad) + path.hoop * std::sin(at.azimuth_rad);
    const double slope = far.by_z * path.axial + far.by_radius * outward;
    const double step = (far.mm - envelope_.clearance_mm()) / slope;
    if (!(std::abs(step) < farthest_mm_)) break;
    way -= step;
    if (std::abs(step) < 1e-11 * farthest_mm_) break;
  }
  return way;
}

EyePosition PayoutEye::at(const FibreTangent& path) const {
  const double way = free_length(path);
  const ThreadPlace eye = on_thread(path, way);
  const double hoop = path.hoop * std::cos(eye.azimuth_rad) - path.radial * std::sin(eye.azimuth_rad);
  return {eye.z_mm, path.turn_rad + eye.azimuth_rad, eye.radius_mm, -std::atan2(path.axial, hoop), way};
}

double PayoutEye::deepest_mm(const FibreTangent& path, double free_length_mm) const {
  constexpr int samples = 48;
  double deepest = -1e300;
  for (int k = 1; k <= samples; ++k) {
    const double share = static_cast<double>(k) / samples;
    const ThreadPlace at = on_thread(path, free_length_mm * share * share);  // closer near the mandrel
    deepest = std::max(deepest, envelope_.depth_mm(at.z_mm, at.radius_mm));
  }
  return deepest;
}

}  // namespace afptraj
