#include "winding/pattern.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "winding/frustum.h"

namespace afptraj {
namespace {

constexpr double slot_tolerance_deg = 1e-6;       // native: a lock typed with seven digits is meant exactly
constexpr double fiberpath_tolerance_deg = 5e-7;  // what six decimals round to zero

double slot_deg(std::int64_t pattern) { return 360.0 / static_cast<double>(pattern); }

bool falls_into_slots(double lock_deg, std::int64_t pattern, WindMode mode) {
  const double limit = mode == WindMode::native ? slot_tolerance_deg : fiberpath_tolerance_deg;
  return lock_remainder_deg(lock_deg, pattern, mode) <= limit;
}

}  // namespace

double modulo(double a, double b) {
  const double rest = std::fmod(a, b);
  if (rest == 0) return std::copysign(0.0, b);
  return (rest < 0) != (b < 0) ? rest + b : rest;
}

std::int64_t circuits(const WindMandrel& mandrel, const WindTow& tow, const HelicalLayer& layer,
                      WindMode mode) {
  const double circumference = std::numbers::pi * mandrel.diameter_mm;
  const double arc = tow.width_mm / std::cos(radians(layer.angle_deg));
  constexpr double countable = 9e15;
  const auto touching = static_cast<std::int64_t>(std::min(std::ceil(circumference / arc), countable));
  if (mode == WindMode::fiberpath) return touching;
  return (touching + layer.pattern - 1) / layer.pattern * layer.pattern;
}

double lock_remainder_deg(double lock_deg, std::int64_t pattern, WindMode mode) {
  const double slot = slot_deg(pattern);
  const double remainder = modulo(modulo(2 * lock_deg, 360), slot);
  return mode == WindMode::native ? std::min(remainder, slot - remainder) : remainder;
}

std::int64_t slot_stride(double lock_deg, std::int64_t skip, std::int64_t pattern) {
  const double p = static_cast<double>(pattern);
  const double advance = modulo(modulo(2 * lock_deg, 360) + static_cast<double>(skip) * 360 / p, 360);
  return static_cast<std::int64_t>(std::nearbyint(advance / slot_deg(pattern))) % pattern;
}

bool lock_closes(double lock_deg, std::int64_t skip, std::int64_t pattern, WindMode mode) {
  if (pattern == 1 && mode == WindMode::fiberpath) return true;
  return falls_into_slots(lock_deg, pattern, mode) &&
         std::gcd(slot_stride(lock_deg, skip, pattern), pattern) == 1;
}

std::vector<double> closing_locks(double lock_deg, std::int64_t skip, std::int64_t pattern, WindMode mode) {
  const double half = 180 / static_cast<double>(pattern);
  const double centre = std::nearbyint(lock_deg / half);
  // Strides repeat after p candidates; so many on each side hold the nearest.
  const std::int64_t reach = mode == WindMode::native ? 3 * pattern : 16;
  std::vector<double> found;
  for (std::int64_t k = -reach; k <= reach; ++k) {
    const double candidate = (centre + static_cast<double>(k)) * half;
    if (candidate > 0 && lock_closes(candidate, skip, pattern, mode)) found.push_back(candidate);
  }
  if (mode == WindMode::native) {
    std::stable_sort(found.begin(), found.end(),
                     [&](double a, double b) { return std::abs(a - lock_deg) < std::abs(b - lock_deg); });
  }
  if (found.size() > 3) found.resize(3);
  std::sort(found.begin(), found.end());
  return found;
}

double overlap(const WindMandrel& mandrel, const WindTow& tow, double angle_deg, std::int64_t circuits) {
  return static_cast<double>(circuits) * tow.width_mm /
             (std::cos(radians(angle_deg)) * std::numbers::pi * mandrel.diameter_mm) -
         1;
}

double uneven_deg(std::vector<double> angles) {
  if (angles.empty()) return 0;
  const double n = static_cast<double>(angles.size()), first = angles.front();
  for (double& angle : angles) {
    angle = modulo(angle - first, 360);
    if (360 - angle < 180 / n) angle -= 360;  // the first place, from below
  }
  std::sort(angles.begin(), angles.end());
  double worst = 0;
  for (std::size_t k = 0; k < angles.size(); ++k)
    worst = std::max(worst, std::abs(angles[k] - 360 * static_cast<double>(k) / n));
  return worst;
}

}  // namespace afptraj
