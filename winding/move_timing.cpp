#include "winding/move_timing.h"

#include <algorithm>
#include <cmath>

#include "winding/number_words.h"

namespace afptraj {
namespace {

const char* unit_of(WinderAxis axis) {
  return axis == WinderAxis::carriage || axis == WinderAxis::cross_feed ? "mm/s" : "deg/s";
}

// Calls each(index, axis) for the axes that the machine has.
template <typename Each>
void for_each_axis(const MachineProfile& profile, const Each& each) {
  for (std::size_t i = 0; i < winder_axes; ++i) {
    if (profile.axes[i]) each(i, *profile.axes[i]);
  }
}

AxisValues difference(const AxisValues& to, const AxisValues& from) {
  AxisValues out{};
  for (std::size_t i = 0; i < winder_axes; ++i) out[i] = to[i] - from[i];
  return out;
}

// The least time in which the axes can make a move.
double least_time(const AxisValues& delta, const MachineProfile& profile) {
  double time = 0;
  for_each_axis(profile, [&](std::size_t i, const MachineAxis& axis) {
    time = std::max(time, std::abs(delta[i]) / axis.speed_per_s);
  });
  return time;
}

// What axes asked for beyond their limits.
class Excess {
 public:
  void add(std::size_t i, double speed, double limit, double angle, double loose_angle) {
    if (speed <= limit * (1 + 1e-9)) return;
    ClampedAxis& clamped = axes_[i];
    ++clamped.moves;
    if (speed / limit <= worst_[i]) return;
    worst_[i] = speed / limit;
    clamped = {static_cast<WinderAxis>(i), clamped.moves, speed, limit, angle, loose_angle};
  }
  std::vector<ClampedAxis> found() const {
    std::vector<ClampedAxis> out;
    for (const ClampedAxis& axis : axes_) {
      if (axis.moves > 0) out.push_back(axis);
    }
    return out;
  }

 private:
  std::array<ClampedAxis, winder_axes> axes_{};
  std::array<double, winder_axes> worst_{};
};

}  // namespace

FeedRateExceeded::FeedRateExceeded(WinderAxis which, std::size_t in_layer, double speed, double most,
                                   double bearable_feed)
    : Error(ErrorCode::no_path, "FeedRateExceeded",
            "layer " + std::to_string(in_layer) + ": " + axis_names[static_cast<std::size_t>(which)] +
                " would run at " + significant_text(speed, 5) + " " + unit_of(which) + ", its limit is " +
                significant_text(most, 5) + "; lower the feed to " + significant_text(bearable_feed, 4) +
                " mm/min, or use --over-speed clamp"),
      axis(which),
      layer(in_layer),
      value(speed),
      limit(most) {}

double clamped_angle_rad(double angle_rad, double feed_mm_per_s, double carriage_limit_mm_per_s) {
  const double carriage = std::min(feed_mm_per_s * std::cos(angle_rad), carriage_limit_mm_per_s);
  return std::atan2(feed_mm_per_s * std::sin(angle_rad), carriage);
}

std::vector<ClampedAxis> set_times(std::vector<MachineMove>& moves, const AxisValues& from,
                                   const MachineProfile& profile, double feed_mm_per_s, OverSpeed over_speed,
                                   std::size_t layer) {
  Excess excess;
  AxisValues at = from;
  for (MachineMove& move : moves) {
    const AxisValues delta = difference(move.to, at);
    at = move.to;
    const double least = least_time(delta, profile);
    move.time_s = least;
    if (move.purpose == MovePurpose::reposition) continue;
    const double wanted = move.way_mm / feed_mm_per_s;
    move.time_s = std::max(least, wanted);
    if (!(wanted > 0)) continue;
    for_each_axis(profile, [&](std::size_t i, const MachineAxis& axis) {
      const double speed = std::abs(delta[i]) / wanted;
      double loose = move.angle_rad;
      if (static_cast<WinderAxis>(i) == WinderAxis::carriage && speed > axis.speed_per_s)
        loose = std::atan2(std::sin(move.angle_rad), std::cos(move.angle_rad) * axis.speed_per_s / speed);
      excess.add(i, speed, axis.speed_per_s, move.angle_rad, loose);
    });
  }
  const std::vector<ClampedAxis> found = excess.found();
  if (over_speed == OverSpeed::clamp || found.empty()) return found;
  const auto ratio = [](const ClampedAxis& axis) { return axis.wanted_per_s / axis.limit_per_s; };
  const ClampedAxis& worst =
      *std::max_element(found.begin(), found.end(),
                        [&](const ClampedAxis& a, const ClampedAxis& b) { return ratio(a) < ratio(b); });
  throw FeedRateExceeded(worst.axis, layer, worst.wanted_per_s, worst.limit_per_s,
                         feed_mm_per_s * 60 / ratio(worst));
}

double trapezoidal_time_s(const std::vector<MachineMove>& moves, const AxisValues& from,
                          const MachineProfile& profile) {
  // Along each move the asked time tau runs at the rate f = d tau / dt, at most 1; `speeds`: d axis / d tau.
  std::vector<AxisValues> speeds;
  std::vector<double> taus, gains;  // gains: greatest df / dt
  AxisValues at = from;
  for (const MachineMove& move : moves) {
    AxisValues speed = difference(move.to, at);
    at = move.to;
    if (!(move.time_s > 0)) continue;
    double gain = 1e300;
    for (double& axis : speed) axis /= move.time_s;
    for_each_axis(profile, [&](std::size_t i, const MachineAxis& axis) {
      if (speed[i] != 0) gain = std::min(gain, axis.acceleration_per_s2 / std::abs(speed[i]));
    });
    speeds.push_back(speed);
    taus.push_back(move.time_s);
    gains.push_back(gain);
  }
  const std::size_t n = taus.size();
  if (n == 0) return 0;
  // squares of f between moves
  std::vector<double> squares(n + 1, 0);
  for (std::size_t k = 1; k < n; ++k) {
    squares[k] = 1;
    for_each_axis(profile, [&](std::size_t i, const MachineAxis& axis) {
      const double change = std::abs(speeds[k][i] - speeds[k - 1][i]);
      if (change > 0)
        squares[k] = std::min(squares[k], axis.acceleration_per_s2 * (taus[k] + taus[k - 1]) / 2 / change);
    });
  }
  for (std::size_t k = 0; k < n; ++k)
    squares[k + 1] = std::min(squares[k + 1], squares[k] + 2 * gains[k] * taus[k]);
  for (std::size_t k = n; k-- > 0;)
    squares[k] = std::min(squares[k], squares[k + 1] + 2 * gains[k] * taus[k]);
  double time = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const double a = squares[k], b = squares[k + 1];
    const double peak = std::min(1.0, (a + b) / 2 + gains[k] * taus[k]);  // square of f at the plateau
    const double f = std::sqrt(peak), ramps = (2 * peak - a - b) / (2 * gains[k]);
    time += (2 * f - std::sqrt(a) - std::sqrt(b)) / gains[k] + (taus[k] - ramps) / f;
  }
  return time;
}

}  // namespace afptraj
