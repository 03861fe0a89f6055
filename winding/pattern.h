#pragma once

#include <cstdint>
#include <vector>

#include "winding/wind_definition.h"

namespace afptraj {

/// a - b floor(a / b), exact as fmod is: in [0, b) for b > 0.
double modulo(double a, double b);

/// How often a helical layer goes there and back so that neighbouring tows touch where the mandrel is
/// thickest:
///   N = ceil(pi D cos(alpha) / w), in native mode rounded up to a multiple of the pattern number.
std::int64_t circuits(const WindMandrel& mandrel, const WindTow& tow, const HelicalLayer& layer,
                      WindMode mode);

/// How far 2 lock lies from a whole number of slots of 360/p, in degrees: 0 where circuits fall into
/// slots. In FiberPath mode the remainder is taken from below only, so that a lock just short of a
/// multiple counts as wrong.
double lock_remainder_deg(double lock_deg, std::int64_t pattern, WindMode mode);

/// Slots from one circuit of a pattern to the next, in 0 ... p - 1. The p circuits fall into p different
/// slots exactly where it has no common divisor with p.
std::int64_t slot_stride(double lock_deg, std::int64_t skip, std::int64_t pattern);

/// Whether circuits fall into slots, and into all of them.
bool lock_closes(double lock_deg, std::int64_t skip, std::int64_t pattern, WindMode mode);

/// Locks near `lock_deg` that close the pattern: native the three nearest, in ascending order; in FiberPath
/// mode the first three of the 33 candidates that it looks at. May be empty there.
std::vector<double> closing_locks(double lock_deg, std::int64_t skip, std::int64_t pattern, WindMode mode);

/// The share by which neighbouring tows of N circuits overlap: N w / (cos(alpha) pi D) - 1.
double overlap(const WindMandrel& mandrel, const WindTow& tow, double angle_deg, std::int64_t circuits);

/// Greatest distance of angles from the places 360 k / n after the first; a place taken twice counts as the
/// distance to the next. 0 for none.
double uneven_deg(std::vector<double> angles);

}  // namespace afptraj
