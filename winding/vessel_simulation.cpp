#include "winding/vessel_simulation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "winding/clearance_envelope.h"
#include "winding/frustum.h"
#include "winding/meridian_band.h"
#include "winding/pattern.h"

namespace afptraj {
namespace {

// Where passes begin that leave the first end: the first point, and where the path turns from back to there.
std::vector<double> starts_deg(const std::vector<ContactPoint>& path) {
  std::vector<double> out;
  constexpr double square = std::numbers::pi / 2;
  constexpr double surely_back_rad = 0.01;  // where a fibre turns slowly its angle may waver
  bool back = false;
  if (path.front().angle_rad <= square + 1e-6) out.push_back(degrees(path.front().turn_rad));
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double a = path[i - 1].angle_rad - square, b = path[i].angle_rad - square;
    // what turns beside the beginning is the beginning, and beside the end no start any more
    const double margin = 2 * simulation_step_mm;
    back = back || a > surely_back_rad;
    if (!(back && a > 0 && b <= 0) || path[i].length_mm < margin ||
        path[i].length_mm > path.back().length_mm - margin)
      continue;
    const double share = a / (a - b);
    back = false;
    out.push_back(degrees(path[i - 1].turn_rad + share * (path[i].turn_rad - path[i - 1].turn_rad)));
  }
  return out;
}

// The stretches of a path that run there (`back` false) or back.
std::vector<std::vector<ContactPoint>> stretches(const std::vector<ContactPoint>& path, bool back) {
  std::vector<std::vector<ContactPoint>> out;
  bool running = false;
  for (const ContactPoint& point : path) {
    const bool wanted = (point.angle_rad > std::numbers::pi / 2) == back;
    if (wanted && !running) out.emplace_back();
    if (wanted) out.back().push_back(point);
    running = wanted;
  }
  return out;
}

int circles_for(const Meridian& meridian, const WindTow& tow) {
  return static_cast<int>(std::clamp(std::ceil(8 * meridian.length_mm() / tow.width_mm), 64.0, 8192.0));
}

void measure_eye(const Meridian& meridian, const EyeTravel& travel, LaidTravel& out) {
  const ClearanceEnvelope hull(meridian, 1);
  out.least_clearance_mm = out.least_free_mm = 1e300;
  for (const EyePlace& eye : travel.eyes)
    out.least_clearance_mm = std::min(out.least_clearance_mm, hull.distance(eye.z_mm, eye.radius_mm).mm);
  for (const ContactPoint& point : out.path) {
    const auto piece = std::min(static_cast<std::size_t>(point.at_eye), travel.eyes.size() - 2);
    const EyePlace &a = travel.eyes[piece], &b = travel.eyes[piece + 1];
    const double share = point.at_eye - static_cast<double>(piece);
    const double z = a.z_mm + share * (b.z_mm - a.z_mm),
                 radius = a.radius_mm + share * (b.radius_mm - a.radius_mm);
    const double azimuth = a.azimuth_rad + share * (b.azimuth_rad - a.azimuth_rad) - point.turn_rad;
    const double free =
        std::hypot(z - point.z_mm, radius * std::cos(azimuth) - point.r_mm, radius * std::sin(azimuth));
    out.least_free_mm = std::min(out.least_free_mm, free);
    out.most_free_mm = std::max(out.most_free_mm, free);
  }
}

}  // namespace

LaidTravel simulate_travel(const Meridian& meridian, const WindTow& tow, const EyeTravel& travel) {
  LaidTravel out;
  const double start = meridian.nearest(travel.start_z_mm, travel.start_r_mm);
  out.path = follow_thread(meridian, start, travel.start_turn_rad, travel.eyes, simulation_step_mm);
  if (out.path.empty()) return out;
  out.laid_mm = out.path.back().length_mm;
  const auto [first, last] =
      std::minmax_element(out.path.begin(), out.path.end(),
                          [](const ContactPoint& a, const ContactPoint& b) { return a.t < b.t; });
  out.least_r_first_mm = first->r_mm;
  out.least_r_last_mm = last->r_mm;
  MeridianBand band(meridian, tow.width_mm, first->t, last->t, circles_for(meridian, tow));
  band.lay(out.path);
  out.coverage = band.coverage();
  for (const bool back : {false, true}) {
    MeridianBand way(meridian, tow.width_mm, first->t, last->t, circles_for(meridian, tow));
    for (const auto& stretch : stretches(out.path, back)) way.lay(stretch);
    const BandCoverage here = way.coverage();
    if (!back || here.widest_gap_mm > out.one_way.widest_gap_mm) out.one_way = here;
  }
  std::vector<double> starts = starts_deg(out.path);
  out.starts = static_cast<std::int64_t>(starts.size());
  out.start_error_deg = uneven_deg(std::move(starts));
  measure_eye(meridian, travel, out);
  return out;
}

}  // namespace afptraj
