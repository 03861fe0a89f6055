#pragma once

#include <cstdint>
#include <vector>

#include "geometry/error.h"
#include "winding/machine_profile.h"
#include "winding/program_writer.h"

namespace afptraj {

/// A straight move of all axes at once.
struct MachineMove {
  AxisValues to{};
  MovePurpose purpose = MovePurpose::lay;
  double way_mm = 0;     ///< of fibre that is laid by it
  double angle_rad = 0;  ///< winding angle where it is laid: 0 axial, pi / 2 hoop
  double time_s = 0;     ///< asked for: a controller may need longer where it has to brake
};

/// What to do where an axis would be faster than it can.
enum class OverSpeed {
  clamp,   ///< the move takes as long as the axis needs
  refuse,  ///< FeedRateExceeded
};

/// An axis of a layer that is asked for more than it can. `what()` names all and what to do.
struct FeedRateExceeded : Error {
  FeedRateExceeded(WinderAxis axis, std::size_t layer, double value, double limit, double bearable_feed);
  WinderAxis axis;
  std::size_t layer;    ///< from 1
  double value, limit;  ///< mm/s or deg/s
};

/// An axis of a layer that was held at its limit.
struct ClampedAxis {
  WinderAxis axis{};
  std::int64_t moves = 0;
  double wanted_per_s = 0, limit_per_s = 0;  ///< at the move that wanted most
  double angle_rad = 0;                      ///< winding angle there
  /// The angle that results there if the axis alone gives in and the mandrel keeps its speed; equal to the
  /// other but for a carriage. Programs slow the mandrel with it and keep the angle.
  double loose_angle_rad = 0;
};

/// The angle from the axis that a carriage held at `carriage_limit` lays while the mandrel's surface keeps
/// its speed:
///   tan alpha' = feed sin alpha / limit,   alpha' = alpha where feed cos alpha <= limit.
double clamped_angle_rad(double angle_rad, double feed_mm_per_s, double carriage_limit_mm_per_s);

/// Gives each move its time: what is laid at the feed, all else as fast as the axes can. `from`: where the
/// axes stand before. Throws FeedRateExceeded with OverSpeed::refuse, for the move that asks for most.
std::vector<ClampedAxis> set_times(std::vector<MachineMove>& moves, const AxisValues& from,
                                   const MachineProfile& profile, double feed_mm_per_s, OverSpeed over_speed,
                                   std::size_t layer);

/// How long a machine takes that starts and ends at rest and looks ahead over all moves: speed along the
/// moves grows and falls with what every axis bears (trapezoids), and between two moves is such that the
/// change of each axis' speed, spread over half of both, keeps to its acceleration. Law: a single axis over a
/// way d at v and a, cut into any number of moves, takes d / v + v / a  (d >= v^2 / a). REQUIRES: times are
/// set.
double trapezoidal_time_s(const std::vector<MachineMove>& moves, const AxisValues& from,
                          const MachineProfile& profile);

}  // namespace afptraj
