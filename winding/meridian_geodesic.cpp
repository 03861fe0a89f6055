#include "winding/meridian_geodesic.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "winding/quadrature.h"

namespace afptraj {
namespace {

constexpr int samples_per_span = 32;  // where a turn is looked for

// The place between `outside` (r > K) and `inside` (r <= K) where r = K: bisection down to neighbouring
// doubles, and the outer of them.
double root(const Meridian& meridian, double K, double outside, double inside) {
  for (;;) {
    const double middle = outside + (inside - outside) / 2;
    if (middle == outside || middle == inside) return outside;
    (meridian.at(middle).r_mm > K ? outside : inside) = middle;
  }
}

}  // namespace

MeridianGeodesic::MeridianGeodesic(const Meridian& meridian, double clairaut_mm, double through)
    : meridian_(meridian), K_(clairaut_mm) {
  first_ = end_of(through, false);
  last_ = end_of(through, true);
  turn_rad_ = over(Quantity::turn, 0, std::numbers::pi);
  length_mm_ = over(Quantity::length, 0, std::numbers::pi);
}

PassEnd MeridianGeodesic::end_of(double from, bool forward) const {
  std::vector<double> stops{from};
  std::vector<double> breaks = meridian_.breaks();
  if (!forward) std::reverse(breaks.begin(), breaks.end());
  for (const double t : breaks) {
    if (forward ? t <= from : t >= from) continue;
    const double start = stops.back();
    for (int k = 1; k <= samples_per_span; ++k) stops.push_back(start + (t - start) * k / samples_per_span);
  }
  for (std::size_t i = 1; i < stops.size(); ++i) {
    if (meridian_.at(stops[i]).r_mm > K_) continue;
    const double t = root(meridian_, K_, stops[i - 1], stops[i]);
    const MeridianPoint at = meridian_.at(t);
    return {t, at.z_mm, at.r_mm, true};
  }
  const double end = stops.back();
  const MeridianPoint at = meridian_.at(end);
  return {end, at.z_mm, at.r_mm, false};
}

double MeridianGeodesic::parameter(double phi) const {
  const double span = last_.t - first_.t;
  // from the nearer end, so that its distance keeps its digits
  if (phi < std::numbers::pi / 2) return first_.t + span * std::pow(std::sin(phi / 2), 2);
  return last_.t - span * std::pow(std::cos(phi / 2), 2);
}

double MeridianGeodesic::phase(double t) const {
  return 2 * std::asin(std::sqrt(std::clamp((t - first_.t) / (last_.t - first_.t), 0.0, 1.0)));
}

// r - K at a phase, with its leading digits right however near a turn: there it is the integral of r' from
// the turn, where the plain difference would be all rounding.
double MeridianGeodesic::above_clairaut(double phi, const MeridianPoint& at) const {
  const bool near_first = phi < std::numbers::pi / 2;
  const PassEnd& end = near_first ? first_ : last_;
  if (!end.turns) return at.r_mm - K_;
  const double share = near_first ? std::pow(std::sin(phi / 2), 2) : std::pow(std::cos(phi / 2), 2);
  const double way = (near_first ? 1 : -1) * (last_.t - first_.t) * share;
  if (std::abs(way) > smooth_way(near_first)) return at.r_mm - end.r_mm;
  return gauss_legendre([&](double part) { return meridian_.at(end.t + part * way).dr; }, 0, 1) * way;
}

// How far from an end the meridian is one polynomial, and a rule of eight points exact to rounding on it.
double MeridianGeodesic::smooth_way(bool near_first) const {
  const auto& breaks = meridian_.breaks();
  const auto after = std::upper_bound(breaks.begin(), breaks.end(), near_first ? first_.t : last_.t);
  if (near_first) return after == breaks.end() ? 0 : (*after - first_.t) / 8;
  const auto before = std::lower_bound(breaks.begin(), breaks.end(), last_.t);
  return before == breaks.begin() ? 0 : (last_.t - *(before - 1)) / 8;
}

double MeridianGeodesic::rate(Quantity quantity, double phi) const {
  const MeridianPoint at = meridian_.at(parameter(phi));
  const double way = at.speed() * (last_.t - first_.t) / 2 * std::sin(phi);
  const double axial = std::sqrt(std::max(above_clairaut(phi, at) * (at.r_mm + K_), 1e-300));  // r cos(alpha)
  return quantity == Quantity::turn ? way * K_ / (at.r_mm * axial) : way * at.r_mm / axial;
}

double MeridianGeodesic::over(Quantity quantity, double phi0, double phi1) const {
  std::vector<double> stops{phi0};
  for (const double t : meridian_.breaks()) {
    if (t <= first_.t || t >= last_.t) continue;
    const double phi = phase(t);
    if (phi > phi0 && phi < phi1) stops.push_back(phi);
  }
  stops.push_back(phi1);
  const double tolerance = quantity == Quantity::turn ? 1e-12 : 1e-12 * meridian_.length_mm();
  double sum = 0;
  for (std::size_t i = 0; i + 1 < stops.size(); ++i)
    sum += integral([&](double phi) { return rate(quantity, phi); }, stops[i], stops[i + 1], tolerance);
  return sum;
}

std::vector<FibrePoint> MeridianGeodesic::points(int count) const {
  std::vector<Phase> phases;
  for (int k = 0; k <= count; ++k) {
    const double phi = std::numbers::pi * k / count;
    phases.push_back({phi, parameter(phi)});
  }
  return points_at(phases);
}

MeridianGeodesic::Phase MeridianGeodesic::between(const Phase& a, const Phase& b) const {
  const double phi = (a.phi + b.phi) / 2;
  return {phi, parameter(phi)};
}

std::vector<MeridianGeodesic::Phase> MeridianGeodesic::phases_and_breaks(int count) const {
  const double step = std::numbers::pi / count, beside = 0.01 * step;
  std::vector<Phase> phases;
  for (const double t : meridian_.breaks()) {
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
FibrePoint MeridianGeodesic::place(const Phase& phase) const {
  const MeridianPoint at = meridian_.at(phase.t);
  FibrePoint point;
  point.t = phase.t;
  point.z_mm = at.z_mm;
  point.r_mm = at.r_mm;
  point.angle_rad = std::asin(std::min(1.0, K_ / at.r_mm));
  return point;
}

FibrePoint MeridianGeodesic::next_point(const FibrePoint& before, const Phase& from, const Phase& to) const {
  FibrePoint point = place(to);
  point.turn_rad = before.turn_rad + over(Quantity::turn, from.phi, to.phi);
  point.length_mm = before.length_mm + over(Quantity::length, from.phi, to.phi);
  return point;
}

std::vector<FibrePoint> MeridianGeodesic::points_at(const std::vector<Phase>& phases) const {
  if (phases.empty()) return {};
  std::vector<FibrePoint> out{place(phases.front())};
  for (std::size_t k = 1; k < phases.size(); ++k)
    out.push_back(next_point(out.back(), phases[k - 1], phases[k]));
  return out;
}

}  // namespace afptraj
