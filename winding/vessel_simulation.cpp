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

// Where the passes of a path begin and end round the mandrel.
struct Ends {
  double from_rad = 0, to_rad = 0;
};

Ends ends_of(const std::vector<ContactPoint>& path, std::size_t first, std::size_t last) {
  // between a pass's last point and the next one's first the fibre turns, where its angle is square
  const auto turned = [&](std::size_t i) {
    const double square = std::numbers::pi / 2;
    const double a = path[i].angle_rad - square, b = path[i + 1].angle_rad - square;
    return path[i].turn_rad + a / (a - b) * (path[i + 1].turn_rad - path[i].turn_rad);
  };
  return {first == 0 ? path.front().turn_rad : turned(first - 1),
          last + 1 == path.size() ? path.back().turn_rad : turned(last)};
}

// A pass there and a pass back go round the mandrel the same way while one goes along it and the other
// against: along the axis the difference of their turns only grows, and they cross wherever it passes a whole
// turn.
std::int64_t crossings_of(const std::vector<ContactPoint>& path) {
  std::vector<Ends> there, back;
  const auto runs_back = [&](std::size_t i) { return path[i].angle_rad > std::numbers::pi / 2; };
  const double shortest_mm = 2 * simulation_step_mm;  // what is less wavers about its turn
  std::size_t first = 0;
  for (std::size_t i = 1; i <= path.size(); ++i) {
    if (i < path.size() && runs_back(i) == runs_back(first)) continue;
    if (path[i - 1].length_mm - path[first].length_mm > shortest_mm)
      (runs_back(first) ? back : there).push_back(ends_of(path, first, i - 1));
    first = i;
  }
  constexpr double whole = 2 * std::numbers::pi, beside = 1e-4;  // of a turn: what meets where both turn
  double sum = 0;
  for (const Ends& a : there) {
    for (const Ends& b : back) {
      const double low = (a.from_rad - b.to_rad) / whole, high = (a.to_rad - b.from_rad) / whole;
      sum += std::max(0.0, std::floor(high - beside) - std::ceil(low + beside) + 1);
    }
  }
  return static_cast<std::int64_t>(sum);
}

// With alpha counted from the meridian's direction
//   kappa_g = d alpha / d s + r' sin(alpha) / r,  kappa_n = kappa_m cos^2(alpha) + (z' / r) sin^2(alpha).
void measure_slip(const Meridian& meridian, LaidTravel& out) {
  const std::vector<ContactPoint>& path = out.path;
  const auto window = static_cast<std::size_t>(slip_window_mm / simulation_step_mm);
  if (path.size() <= window) return;
  // sums up to each point, by the trapezoidal rule
  std::vector<double> across{0}, pressing{0};
  double across_before = 0, pressing_before = 0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const MeridianPoint at = meridian.at(path[i].t);
    const double sine = std::sin(path[i].angle_rad), cosine = std::cos(path[i].angle_rad);
    const double a = at.dr / at.speed() * sine / at.r_mm;
    const double n = at.curvature() * cosine * cosine + at.dz / at.speed() * sine * sine / at.r_mm;
    if (i > 0) {
      const double step = path[i].length_mm - path[i - 1].length_mm;
      across.push_back(across.back() + step * (a + across_before) / 2);
      pressing.push_back(pressing.back() + step * (n + pressing_before) / 2);
    }
    across_before = a;
    pressing_before = n;
  }
  for (std::size_t i = 0; i + window < path.size(); ++i) {
    const std::size_t j = i + window;
    const double geodesic = path[j].angle_rad - path[i].angle_rad + across[j] - across[i];
    const double normal = pressing[j] - pressing[i];
    const double ratio = normal > 0 ? std::abs(geodesic) / normal : 1e300;
    if (ratio <= out.slip_ratio) continue;
    out.slip_ratio = ratio;
    out.slip_z_mm = path[i + window / 2].z_mm;
  }
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
  out.crossings = crossings_of(out.path);
  measure_slip(meridian, out);
  measure_eye(meridian, travel, out);
  return out;
}

}  // namespace afptraj
