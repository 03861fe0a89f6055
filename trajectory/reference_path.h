#pragma once

#include <optional>
#include <string>
#include <vector>

#include "geometry/skin.h"
#include "trajectory/direction_field.h"

namespace afptraj {

struct StepOptions {
  double step_mm = 2;           ///< lambda: greatest step
  double chord_error_mm = 0.01; ///< greatest distance of a step's chord from its arc
  double band_width_mm = 50.8;  ///< W: the path ends where it comes alongside itself within W
  /// A path that comes back to its start in the same sense is closed into a ring if that turns it by no more
  /// than this: hoops from scattered ply points miss their start by a little. 0.5 degrees.
  double closing_rad = 0.00873;
  double max_length_mm = 1e7;
  /// Below this strength the field asks for nothing: the directions cancel, or stand on the skin (within
  /// 15 degrees of its normal), as at the nose of a body laid along its axis. The path ends there.
  double least_strength = 0.26;
};

/// A point of the stepped path with the walk's direction and the carried normal's sign.
struct SteppedPoint {
  SurfacePoint at;
  Vec3 position = Vec3::Zero();
  Vec3 direction = Vec3::Zero();
  int normal_sign = 1;
  double s_mm = 0;
};

/// Why a walk ended.
enum class WalkEnd { boundary, pole, closed, alongside, singular_field, length, stuck };
const char* to_string(WalkEnd end);

struct SteppedPath {
  std::vector<SteppedPoint> points;  ///< from the backward end to the forward end
  WalkEnd end[2] = {WalkEnd::stuck, WalkEnd::stuck};  ///< backward, forward
  bool closed = false;               ///< the ends meet: the last point is the first again
  double closed_over_mm = 0;         ///< how far aside of its start the path came back before it was closed
  std::size_t steps = 0, doubled = 0;///< steps walked; steps with no ply point in range
};

/// The initial reference path: from `start` both ways along the field.
///
/// At P_i with direction V: r = 1/kappa_n(V); walk the arc of that circle in the normal plane by
/// lambda, project to the skin. kappa_n -> 0 is a straight step. Error O(lambda^2) against the
/// field line for the midpoint rule used here (the direction is taken half a step ahead).
/// A path that comes back alongside its start within `closing_rad` is closed: the distance w is taken up evenly,
/// point by point, by lateral moves w s / length.
/// Ends before leaving the skin at an outer boundary; walks on over holes and smooth poles. At an apex, a
/// pole without a tangent plane, the asked directions part to all sides: a walk that would pass one within
/// its step goes on over it (trajectory/apex.h), or ends on it.
SteppedPath step_reference_path(const Skin& skin, const DirectionField& field, const SurfacePoint& start,
                                const StepOptions& options);

/// One step by itself: the point reached from `at` by the osculating arc in `direction` over
/// `length`, projected to the skin. Nothing when it leaves the skin or finds no foot.
struct ArcStep {
  SurfacePoint at;
  int normal_sign = 1;
  bool outside = false;  ///< within a hole
};
std::optional<ArcStep> arc_step(const Skin& skin, const ArcStep& from, const Vec3& direction, double length);

}  // namespace afptraj
