#pragma once

#include <vector>

#include "winding/meridian.h"

namespace afptraj {

/// Where the payout eye is, as the mandrel sees it.
struct EyePlace {
  double z_mm = 0, radius_mm = 0, azimuth_rad = 0;
};

/// A place where the thread first touches the mandrel.
struct ContactPoint {
  double t = 0;  ///< of the meridian
  double z_mm = 0, r_mm = 0, turn_rad = 0;
  double length_mm = 0;  ///< laid from the start
  double angle_rad = 0;  ///< of the thread, from the direction in which the meridian runs: 0 ... pi
  double at_eye = 0;     ///< the eye's place then: number of the piece of its way, and the share of it
};

/// What an eye lays that travels straight, by its three coordinates, from place to place, while the thread
/// stays where it touches. The thread is tangent to the mandrel at the contact P, so that the eye E is in the
/// tangent plane there, and what is laid next has the thread's direction:
///   (E - P) . n(P) = 0,   dP / ds = (E - P) / |E - P|.
/// For each P the first equation says where the eye is, the second is integrated by Runge-Kutta's method of
/// fourth order in steps of `step_mm`. A wrong start is forgotten: at a free length l it fades as exp(-s /
/// l).
///
/// Nothing here knows of winding angles or Clairaut: this is the inverse of PayoutEye (checked by
/// tests/thread_contact_test.cpp: it rebuilds paths within 0.01 mm). Ends where the last eye has been
/// reached. REQUIRES: eyes.size() > 1, the thread from `start` to the first eye is tangent there; a smooth
/// meridian.
std::vector<ContactPoint> follow_thread(const Meridian& meridian, double start_t, double start_turn_rad,
                                        const std::vector<EyePlace>& eyes, double step_mm);

}  // namespace afptraj
