#include "winding/meridian_band.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "winding/frustum.h"
#include "winding/quadrature.h"

namespace afptraj {
namespace {

constexpr int table_steps = 64;  // by polynomial of the meridian

// y at x between the rows of a growing table.
double interpolated(const std::vector<double>& xs, const std::vector<double>& ys, double x) {
  const auto after = std::upper_bound(xs.begin() + 1, xs.end() - 1, x);
  const auto i = static_cast<std::size_t>(after - xs.begin());
  const double width = xs[i] - xs[i - 1];
  return ys[i - 1] + (width > 0 ? (x - xs[i - 1]) / width : 0) * (ys[i] - ys[i - 1]);
}

}  // namespace

MeridianBand::MeridianBand(const Meridian& meridian, double tow_width_mm, double first_t, double last_t,
                           int circles)
    : meridian_(meridian), half_width_mm_(tow_width_mm / 2), arcs_(static_cast<std::size_t>(circles)) {
  const std::vector<double>& breaks = meridian.breaks();
  table_t_.push_back(breaks.front());
  table_sigma_.push_back(0);
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
    for (int k = 1; k <= table_steps; ++k) {
      const double t = breaks[i] + (breaks[i + 1] - breaks[i]) * k / table_steps, before = table_t_.back();
      table_sigma_.push_back(table_sigma_.back() +
                             gauss_legendre([&](double at) { return meridian.at(at).speed(); }, before, t));
      table_t_.push_back(t);
    }
  }
  first_sigma_mm_ = sigma(first_t);
  step_mm_ = (sigma(last_t) - first_sigma_mm_) / circles;
  for (int i = 0; i < circles; ++i)
    circle_t_.push_back(interpolated(table_sigma_, table_t_, first_sigma_mm_ + (i + 0.5) * step_mm_));
}

double MeridianBand::sigma(double t) const { return interpolated(table_t_, table_sigma_, t); }

// The place at `beside_mm` to the left of a path, in its tangent plane, and from there the nearest on the
// surface.
MeridianBand::Corner MeridianBand::corner(const ContactPoint& point, double beside_mm) const {
  const MeridianPoint at = meridian_.at(point.t);
  const double along = -std::sin(point.angle_rad) * beside_mm / at.speed();
  const double x = at.r_mm + along * at.dr, y = std::cos(point.angle_rad) * beside_mm;
  const double z = at.z_mm + along * at.dz, radius = std::hypot(x, y);
  double t = point.t + along;
  for (int i = 0; i < 4; ++i) {
    const MeridianPoint near = meridian_.at(t);
    const double speed = near.speed();
    t += ((z - near.z_mm) * near.dz + (radius - near.r_mm) * near.dr) / (speed * speed);
    t = std::clamp(t, meridian_.first(), meridian_.last());
  }
  return {t, sigma(t), degrees(point.turn_rad + std::atan2(y, x))};
}

MeridianBand::Edge MeridianBand::edge_at(const ContactPoint& point) const {
  return {corner(point, half_width_mm_), corner(point, -half_width_mm_)};
}

void MeridianBand::lay(const std::vector<ContactPoint>& path) {
  piece_ += 2;  // no part of what was laid before
  if (path.empty()) return;
  Edge before = edge_at(path.front());
  for (std::size_t i = 1; i < path.size(); ++i) {
    const Edge here = edge_at(path[i]);
    lay_step(before, here);
    before = here;
  }
}

void MeridianBand::lay_step(const Edge& a, const Edge& b) {
  ++piece_;
  const std::array<Corner, 4> corners{a.left, b.left, b.right, a.right};
  const auto [low, high] =
      std::minmax_element(corners.begin(), corners.end(),
                          [](const Corner& p, const Corner& q) { return p.sigma_mm < q.sigma_mm; });
  const auto last = static_cast<double>(arcs_.size()) - 1;
  const double first_circle = std::max(0.0, std::ceil((low->sigma_mm - first_sigma_mm_) / step_mm_ - 0.5));
  const double last_circle = std::min(last, std::floor((high->sigma_mm - first_sigma_mm_) / step_mm_ - 0.5));
  for (double i = first_circle; i <= last_circle; ++i) {
    const double line = first_sigma_mm_ + (i + 0.5) * step_mm_;
    double from = 1e300, to = -1e300;
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const Corner &p = corners[k], &q = corners[(k + 1) % corners.size()];
      if ((p.sigma_mm - line) * (q.sigma_mm - line) > 0 || p.sigma_mm == q.sigma_mm) continue;
      const double share = (line - p.sigma_mm) / (q.sigma_mm - p.sigma_mm);
      const double turn = p.turn_deg + share * (q.turn_deg - p.turn_deg);
      from = std::min(from, turn);
      to = std::max(to, turn);
    }
    if (from <= to) cover(arcs_[static_cast<std::size_t>(i)], {from, to, piece_});
  }
}

BandCoverage MeridianBand::coverage() const {
  CoverageSum sum;
  for (std::size_t i = 0; i < arcs_.size(); ++i) {
    const MeridianPoint at = meridian_.at(circle_t_[i]);
    sum.add(at.z_mm, at.r_mm, step_mm_, arcs_[i]);
  }
  return sum.coverage();
}

}  // namespace afptraj
