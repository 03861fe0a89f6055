#include "winding/steered_clairaut.h"

#include <algorithm>
#include <cmath>

namespace afptraj {
namespace {

constexpr int steps_per_block = 3;
// Of a block's polynomial: values and slopes at 0, 1, 2, 3 steps.
constexpr std::array<double, 8> nodes{0, 0, 1, 1, 2, 2, 3, 3};

double chord(const MeridianPoint& a, const MeridianPoint& b) {
  return std::hypot(b.z_mm - a.z_mm, b.r_mm - a.r_mm);
}

SteeringGrid::Rate rate_at(const Meridian& meridian, double t) {
  const MeridianPoint at = meridian.at(t);
  const double speed = at.speed();
  const double bend = at.curvature() * speed;
  return {bend * at.r_mm, (at.dz / at.r_mm - bend) / at.r_mm};
}

// Divided differences over the nodes, the equal ones by slopes.
std::array<double, 8> newton(const std::array<double, 4>& values, const std::array<double, 4>& slopes) {
  std::array<double, 8> out{};
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = values[i / 2];
  for (std::size_t order = 1; order < out.size(); ++order) {
    for (std::size_t i = out.size() - 1; i >= order; --i) {
      const double gap = nodes[i] - nodes[i - order];
      out[i] = gap == 0 ? slopes[i / 2] : (out[i] - out[i - 1]) / gap;
    }
  }
  return out;
}

}  // namespace

SteeringGrid::SteeringGrid(const Meridian& meridian, double from_t, double to_t, int blocks)
    : forward_(to_t > from_t) {
  std::vector<double> stops{from_t};
  std::vector<double> breaks = meridian.breaks();
  if (!forward_) std::reverse(breaks.begin(), breaks.end());
  for (const double t : breaks) {
    if (forward_ ? t > from_t && t < to_t : t < from_t && t > to_t) stops.push_back(t);
  }
  stops.push_back(to_t);
  double total = 0;
  for (std::size_t i = 1; i < stops.size(); ++i)
    total += chord(meridian.at(stops[i - 1]), meridian.at(stops[i]));
  // Curvature may jump where polynomials meet: each step keeps to its own.
  const double beside = 1e-12 * (meridian.last() - meridian.first());
  for (std::size_t i = 1; i < stops.size(); ++i) {
    const double a = stops[i - 1], b = stops[i];
    const double share = chord(meridian.at(a), meridian.at(b)) / total;
    const int count = steps_per_block * std::max(1, static_cast<int>(std::ceil(blocks * share)));
    const double width = (b - a) / count, low = std::min(a, b) + beside, high = std::max(a, b) - beside;
    const auto rate = [&](double t) { return rate_at(meridian, std::max(low, std::min(t, high))); };
    for (int k = 0; k < count; ++k) {
      const double t = a + width * k, end = a + width * (k + 1);
      const Rate start = k == 0 ? rate(t) : steps_.back().end;
      steps_.push_back({t, width, start, rate(t + width / 2), rate(end), meridian.at(end).r_mm});
    }
  }
}

SteeredClairaut::SteeredClairaut(const SteeringGrid& grid, double clairaut_mm, double ratio)
    : forward_(grid.forward()), ratio_(ratio) {
  const auto slope = [&](const SteeringGrid::Rate& rate, double q) {
    return ratio * (rate.a + rate.b * q * q);
  };
  const std::vector<SteeringGrid::Step>& steps = grid.steps();
  double q = clairaut_mm;
  for (std::size_t i = 0; i < steps.size(); i += steps_per_block) {
    std::array<double, 4> values{q}, slopes{slope(steps[i].start, q) * steps[i].width};
    for (std::size_t k = 0; k < steps_per_block; ++k) {
      const SteeringGrid::Step& step = steps[i + k];
      const double h = step.width;
      const double k1 = slope(step.start, q);
      const double k2 = slope(step.middle, q + h / 2 * k1);
      const double k3 = slope(step.middle, q + h / 2 * k2);
      const double k4 = slope(step.end, q + h * k3);
      q += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
      values[k + 1] = q;
      slopes[k + 1] = h * slope(step.end, q);
    }
    blocks_.push_back({steps[i].t, steps[i].width, newton(values, slopes)});
    if (!(q < steps[i + 2].end_r_mm)) break;
  }
}

const SteeredClairaut::Block& SteeredClairaut::block_at(double t) const {
  const auto after =
      std::upper_bound(blocks_.begin() + 1, blocks_.end(), t,
                       [&](double at, const Block& block) { return forward_ ? at < block.t : at > block.t; });
  return *(after - 1);
}

SteeredClairaut::Value SteeredClairaut::at(double t) const {
  const Block& block = block_at(t);
  const double x = std::clamp((t - block.t) / block.width, 0.0, static_cast<double>(steps_per_block));
  double value = block.newton.back(), slope = 0;
  for (std::size_t i = nodes.size() - 1; i-- > 0;) {
    slope = slope * (x - nodes[i]) + value;
    value = value * (x - nodes[i]) + block.newton[i];
  }
  return {value, slope / block.width};
}

}  // namespace afptraj
