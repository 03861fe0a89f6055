#include "winding/fibre_pass.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "winding/quadrature.h"

namespace afptraj {
namespace {

// Where a turn is looked for: so many places on a meridian, some on each of its polynomials at least.
constexpr std::size_t samples = 512, fewest_by_span = 4, most_by_span = 32;

}  // namespace

FibrePass::FibrePass(const Meridian& meridian, double clairaut_mm, double through,
                     std::optional<Steering> steering_first, std::optional<Steering> steering_last)
    : meridian_(meridian),
      K_(clairaut_mm),
      steering_first_(std::move(steering_first)),
      steering_last_(std::move(steering_last)),
      breaks_(meridian.breaks()) {
  for (const auto* steering : {&steering_first_, &steering_last_}) {
    if (!*steering) continue;
    const double from = (*steering)->from_t;
    breaks_.insert(std::lower_bound(breaks_.begin(), breaks_.end(), from), from);
  }
  breaks_.erase(std::unique(breaks_.begin(), breaks_.end()), breaks_.end());
  first_ = end_of(through, false);
  last_ = end_of(through, true);
  turn_rad_ = over(Quantity::turn, 0, std::numbers::pi);
  length_mm_ = over(Quantity::length, 0, std::numbers::pi);
}

SteeredClairaut::Value FibrePass::clairaut(double t) const {
  if (steering_first_ && t < steering_first_->from_t) return steering_first_->clairaut->at(t);
  if (steering_last_ && t > steering_last_->from_t) return steering_last_->clairaut->at(t);
  return {K_, 0};
}

double FibrePass::clairaut_at(double t) const { return clairaut(t).q_mm; }

// r - q
double FibrePass::height(double t) const { return meridian_.at(t).r_mm - clairaut_at(t); }

// The place between `outside` (r > q) and `inside` (r <= q) where r = q: bisection down to neighbouring
// doubles, and the outer of them.
double FibrePass::root(double outside, double inside) const {
  for (;;) {
    const double middle = outside + (inside - outside) / 2;
    if (middle == outside || middle == inside) return outside;
    (height(middle) > 0 ? outside : inside) = middle;
  }
}

PassEnd FibrePass::end_of(double from, bool forward) const {
  const std::optional<Steering>& steering = forward ? steering_last_ : steering_first_;
  const double nowhere = forward ? 1e300 : -1e300;
  const double known = steering ? steering->turn_t.value_or(nowhere) : nowhere;
  const auto end_at = [&](double t, bool turns) {
    const MeridianPoint at = meridian_.at(t);
    return PassEnd{t, at.z_mm, at.r_mm, turns};
  };
  const std::size_t by_span = std::clamp(samples / breaks_.size(), fewest_by_span, most_by_span);
  std::vector<double> stops{from};
  std::vector<double> breaks = breaks_;
  if (!forward) std::reverse(breaks.begin(), breaks.end());
  for (const double t : breaks) {
    if (forward ? t <= from : t >= from) continue;
    const double start = stops.back();
    for (std::size_t k = 1; k <= by_span; ++k)
      stops.push_back(start + (t - start) * static_cast<double>(k) / static_cast<double>(by_span));
  }
  for (std::size_t i = 1; i < stops.size(); ++i) {
    if (forward ? stops[i] >= known : stops[i] <= known) return end_at(known, true);
    if (height(stops[i]) <= 0) return end_at(root(stops[i - 1], stops[i]), true);
  }
  return end_at(stops.back(), false);
}

double FibrePass::parameter(double phi) const {
  const double span = last_.t - first_.t;
  // from the nearer end, so that its distance keeps its digits
  if (phi < std::numbers::pi / 2) return first_.t + span * std::pow(std::sin(phi / 2), 2);
  return last_.t - span * std::pow(std::cos(phi / 2), 2);
}

double FibrePass::phase(double t) const {
  return 2 * std::asin(std::sqrt(std::clamp((t - first_.t) / (last_.t - first_.t), 0.0, 1.0)));
}

// r - q at a phase, with its leading digits right however near a turn: there it is the integral of r' - q'
// from the turn, where the plain difference would be all rounding.
double FibrePass::above_clairaut(double phi, double t, const MeridianPoint& at) const {
  const bool near_first = phi < std::numbers::pi / 2;
  const PassEnd& end = near_first ? first_ : last_;
  if (!end.turns) return at.r_mm - clairaut_at(t);
  const double share = near_first ? std::pow(std::sin(phi / 2), 2) : std::pow(std::cos(phi / 2), 2);
  const double way = (near_first ? 1 : -1) * (last_.t - first_.t) * share;
  if (std::abs(way) > smooth_way(near_first))
    return at.r_mm - (end.r_mm + (clairaut_at(t) - clairaut_at(end.t)));
  const auto slope = [&](double part) {
    const double there = end.t + part * way;
    return meridian_.at(there).dr - clairaut(there).slope;
  };
  return gauss_legendre(slope, 0, 1) * way;
}

// How far from an end the meridian is one polynomial, and a rule of eight points exact to rounding on it.
double FibrePass::smooth_way(bool near_first) const {
  const auto& breaks = breaks_;
  const auto after = std::upper_bound(breaks.begin(), breaks.end(), near_first ? first_.t : last_.t);
  if (near_first) return after == breaks.end() ? 0 : (*after - first_.t) / 8;
  const auto before = std::lower_bound(breaks.begin(), breaks.end(), last_.t);
  return before == breaks.begin() ? 0 : (last_.t - *(before - 1)) / 8;
}

double FibrePass::rate(Quantity quantity, double phi) const {
  const double t = parameter(phi);
  const MeridianPoint at = meridian_.at(t);
  const double way = at.speed() * (last_.t - first_.t) / 2 * std::sin(phi);
  const double q = clairaut_at(t);
  const double axial =
      std::sqrt(std::max(above_clairaut(phi, t, at) * (at.r_mm + q), 1e-300));  // r cos(alpha)
  return quantity == Quantity::turn ? way * q / (at.r_mm * axial) : way * at.r_mm / axial;
}

double FibrePass::over(Quantity quantity, double phi0, double phi1) const {
  std::vector<double> stops{phi0};
  const double from = std::max(parameter(phi0), first_.t), to = std::min(parameter(phi1), last_.t);
  for (auto t = std::upper_bound(breaks_.begin(), breaks_.end(), from); t != breaks_.end() && *t < to; ++t) {
    const double phi = phase(*t);
    if (phi > phi0 && phi < phi1) stops.push_back(phi);
  }
  stops.push_back(phi1);
  const double tolerance = quantity == Quantity::turn ? 1e-12 : 1e-12 * meridian_.length_mm();
  double sum = 0;
  for (std::size_t i = 0; i + 1 < stops.size(); ++i)
    sum += integral([&](double phi) { return rate(quantity, phi); }, stops[i], stops[i + 1], tolerance);
  return sum;
}

std::vector<FibrePoint> FibrePass::points(int count) const {
  std::vector<Phase> phases;
  for (int k = 0; k <= count; ++k) {
    const double phi = std::numbers::pi * k / count;
    phases.push_back({phi, parameter(phi)});
  }
  return points_at(phases);
}

FibrePass::Phase FibrePass::between(const Phase& a, const Phase& b) const {
  const double phi = (a.phi + b.phi) / 2;
  return {phi, parameter(phi)};
}

std::vector<FibrePass::Phase> FibrePass::phases_and_breaks(int count) const {
  const double step = std::numbers::pi / count, beside = 0.01 * step;
  std::vector<Phase> phases;
  for (const double t : breaks_) {
    if (t <= first_.t || t >= last_.t) continue;
    const double phi = phase(t);
    if (phi > beside && phi < std::numbers::pi - beside) phases.push_back({phi, t});
  }
  const std::vector<Phase> breaks = phases;
  for (int k = 0; k <= count; ++k) {
    const double phi = step * k;
    const auto after = std::lower_bound(breaks.begin(), breaks.end(), phi - beside,
                                        [](const Phase& at, double wanted) { return at.phi < wanted; });
    if (after == breaks.end() || after->phi > phi + beside) phases.push_back({phi, parameter(phi)});
  }
  std::sort(phases.begin(), phases.end(), [](const Phase& a, const Phase& b) { return a.phi < b.phi; });
  return phases;
}

// Without turn and length.
FibrePoint FibrePass::place(const Phase& phase) const {
  const MeridianPoint at = meridian_.at(phase.t);
  FibrePoint point;
  point.t = phase.t;
  point.z_mm = at.z_mm;
  point.r_mm = at.r_mm;
  point.angle_rad = std::asin(std::min(1.0, clairaut_at(phase.t) / at.r_mm));
  return point;
}

FibrePoint FibrePass::next_point(const FibrePoint& before, const Phase& from, const Phase& to) const {
  FibrePoint point = place(to);
  point.turn_rad = before.turn_rad + over(Quantity::turn, from.phi, to.phi);
  point.length_mm = before.length_mm + over(Quantity::length, from.phi, to.phi);
  return point;
}

std::vector<FibrePoint> FibrePass::points_at(const std::vector<Phase>& phases) const {
  if (phases.empty()) return {};
  std::vector<FibrePoint> out{place(phases.front())};
  for (std::size_t k = 1; k < phases.size(); ++k)
    out.push_back(next_point(out.back(), phases[k - 1], phases[k]));
  return out;
}

}  // namespace afptraj
