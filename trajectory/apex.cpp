#include "trajectory/apex.h"

#include <algorithm>
#include <cmath>

namespace afptraj {

std::optional<SteppedPoint> beside_pole(const Skin& skin, const Vec3& pole, const Vec3& toward,
                                        double distance_mm, const SteppedPoint& from) {
  const Vec3 p = pole + distance_mm * (toward - pole).normalized();
  const auto found = skin.closest_point().closest(p, 0.5 * distance_mm);
  if (!found || skin.normal(found->at).isZero()) return std::nullopt;
  const Vec3 step = found->point - from.position;
  const bool same_side = skin.normal(found->at).dot(from.normal_sign * skin.normal(from.at)) >= 0;
  return SteppedPoint{found->at, found->point, step.normalized(), same_side ? 1 : -1,
                      from.s_mm + step.norm()};
}

std::optional<std::vector<SteppedPoint>> arc_over_apex(const Skin& skin, const Pole& apex,
                                                       const SteppedPoint& from, const StepOptions& options) {
  const double reach = (from.position - apex.point).norm();
  const Vec3 back = (from.position - apex.point) / reach;
  const double around = back.cross(apex.axis).norm();  // radians of the sector by radians of azimuth
  if (around < 0.5) return std::nullopt;
  const double half_turn = std::max(0.5 * pi * (1 - around), 1e-6);
  const double radius = reach / std::tan(half_turn), centre = radius / std::cos(half_turn);
  // The skin bends across the arc with about the distance from the apex as its radius.
  const double step = std::min(options.step_mm, std::sqrt(8 * options.chord_error_mm * (centre - radius)));
  const int count = static_cast<int>(std::ceil(2 * radius * half_turn / std::max(step, 0.01 * reach)));
  std::vector<SteppedPoint> out;
  for (int i = 1; i <= count; ++i) {
    const double turned = half_turn * (2.0 * i / count - 1);  // from the middle of the arc
    const double x = centre - radius * std::cos(turned), y = radius * std::sin(turned);
    const double azimuth = pi / 2 + std::atan2(y, x) / around;
    const auto next = beside_pole(skin, apex.point, apex.point + Eigen::AngleAxisd(azimuth, apex.axis) * back,
                                  std::hypot(x, y), out.empty() ? from : out.back());
    if (!next) return std::nullopt;
    out.push_back(*next);
  }
  return out;
}

}  // namespace afptraj
