#pragma once

#include <optional>

#include "winding/clearance_envelope.h"
#include "winding/meridian.h"

namespace afptraj {

/// A place on a fibre path with the path's unit tangent, in the cylindrical frame of the place: along the
/// radius, round the axis, along the axis.
struct FibreTangent {
  double z_mm = 0, r_mm = 0, turn_rad = 0;
  double radial = 0, hoop = 0, axial = 0;
};

/// At parameter t of a meridian, running at `angle_rad` from the direction in which the meridian runs:
/// below pi / 2 there, above it back.
FibreTangent fibre_tangent(const Meridian& meridian, double t, double turn_rad, double angle_rad);

/// Where the axes of a winder stand.
struct EyePosition {
  double carriage_mm = 0;     ///< z of the eye
  double mandrel_rad = 0;     ///< turn of the mandrel: the eye's azimuth as the mandrel sees it
  double cross_feed_mm = 0;   ///< distance of the eye from the mandrel's axis
  double rotation_rad = 0;    ///< of the eye about the cross-feed: 0 where the thread runs square to the axis
  double free_length_mm = 0;  ///< of the thread between mandrel and eye
};

/// What a winder's payout eye may do.
struct EyeRoom {
  double clearance_mm = 20;             ///< from the hull of the mandrel
  std::optional<double> fixed_mm = {};  ///< distance from the axis on a machine without cross-feed
};

/// The payout eye of a winder: it stands on the tangent of the fibre path,
///   E = P + l T,  l > 0,
/// where that leaves the clearance envelope or, without cross-feed, the cylinder of radius `fixed`. The eye
/// turns by
///   B = -atan2(T_axial, T_hoop),  T taken in the frame at E,
/// negative while the carriage travels to larger z, as FiberPath's head does.
///
/// Laws, checked by tests/payout_eye_test.cpp:
///   (E1) On a cylinder of radius R and a fixed eye at c, for a path at angle a: l = sqrt(c^2 - R^2) / sin a,
///        carriage z + sqrt(c^2 - R^2) / tan a, mandrel turn + acos(R / c), tan B = -c / (R tan a).
///   (E2) On a sphere of radius R: l = sqrt((R + clearance)^2 - R^2), wherever and at whatever angle.
///   (E3) The eye is nowhere nearer to the mandrel than the clearance, nor to the axis than r sin a.
/// Source: Koussios, Filament Winding: a Unified Approach (2004), ch. 11.
class PayoutEye {
 public:
  /// Throws Error(no_path, "machine", ...) where a fixed eye is nearer to the mandrel than the clearance.
  PayoutEye(const Meridian& meridian, const EyeRoom& room);

  /// REQUIRES: path.hoop > 0.
  EyePosition at(const FibreTangent& path) const;
  /// How deep the free thread lies below the mandrel's surface where it does most; not above 0 (but for the
  /// outline's error) where it is free, above where the mandrel is hollow and the thread would bridge.
  double deepest_mm(const FibreTangent& path, double free_length_mm) const;
  const ClearanceEnvelope& envelope() const { return envelope_; }

 private:
  double free_length(const FibreTangent& path) const;

  ClearanceEnvelope envelope_;
  std::optional<double> fixed_mm_;
  double farthest_mm_;  // along any tangent the envelope is left before
};

}  // namespace afptraj
