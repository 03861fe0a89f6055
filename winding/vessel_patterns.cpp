#include "winding/vessel_patterns.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>

#include "winding/frustum.h"
#include "winding/number_words.h"
#include "winding/pattern.h"

namespace afptraj {
namespace {

constexpr int table_steps = 32;  // of the angle's tolerance, between which the turn is taken for monotonic

SteeringRule rule_of(const VesselQuery& query) {
  SteeringRule rule = query.steering;
  rule.tow_width_mm = query.tow_width_mm;
  return rule;
}

class Search {
 public:
  Search(const Meridian& meridian, const VesselQuery& query)
      : query_(query), passes_(meridian, rule_of(query)), R_(meridian.at(meridian.widest()).r_mm) {}

  std::vector<VesselPattern> found() {
    const double lowest =
        std::max({query_.angle_deg - query_.tolerance_deg, passes_.least_angle_deg(), 0.01});
    const double highest = std::min(query_.angle_deg + query_.tolerance_deg, 89.99);
    std::optional<double> before;
    double at = lowest;
    for (int i = 0; i <= table_steps && highest > lowest; ++i) {
      const double angle = lowest + (highest - lowest) * i / table_steps;
      const std::optional<double> turns = circuit_turns(angle);
      if (before && turns) search_between(at, *before, angle, *turns);
      before = turns;
      at = angle;
    }
    std::stable_sort(out_.begin(), out_.end(), [&](const VesselPattern& a, const VesselPattern& b) {
      return std::abs(a.angle_deg - query_.angle_deg) < std::abs(b.angle_deg - query_.angle_deg);
    });
    return std::move(out_);
  }

 private:
  // Turns of the mandrel by circuit; none where no pass turns at both ends.
  std::optional<double> circuit_turns(double angle_deg) const {
    const std::optional<SteeredPass> found = passes_.at(angle_deg);
    if (!found) return std::nullopt;
    return found->pass.turn_rad() / std::numbers::pi;
  }

  // Of N circuits at the widest place; negative where they leave gaps.
  double overlap(std::int64_t N, double angle_deg) const {
    return static_cast<double>(N) / tows_around(angle_deg) - 1;
  }
  double tows_around(double angle_deg) const {
    return 2 * std::numbers::pi * R_ * std::cos(radians(angle_deg)) / query_.tow_width_mm;
  }

  // All N and strides that the turn passes between two angles.
  void search_between(double a, double turns_a, double b, double turns_b) {
    const double low = std::min(turns_a, turns_b), high = std::max(turns_a, turns_b);
    const auto fewest = static_cast<std::int64_t>(std::ceil(std::max(tows_around(b), 2.0)));
    const auto most = static_cast<std::int64_t>(std::floor(tows_around(a) * (1 + query_.most_overlap)));
    for (std::int64_t N = fewest; N <= most; ++N) {
      const double slots = static_cast<double>(N);
      for (double k = std::ceil(low * slots); k <= high * slots; ++k) {
        const auto stride = static_cast<std::int64_t>(modulo(k, slots));
        if (std::gcd(stride, N) == 1) solve(a, turns_a, b, turns_b, N, stride, k / slots);
      }
    }
  }

  void solve(double a, double turns_a, double b, double turns_b, std::int64_t N, std::int64_t stride,
             double wanted) {
    const auto [starts, leading] = starts_of(stride, N);
    if (starts > query_.most_starts) return;
    double angle = a, turns = turns_a;
    // Illinois' variant of regula falsi: keeps the bracket and converges faster than linearly.
    double fa = turns_a - wanted, fb = turns_b - wanted;
    for (int i = 0; i < 60 && std::abs(turns - wanted) > 1e-10; ++i) {
      angle = fb == fa ? (a + b) / 2 : b - fb * (b - a) / (fb - fa);
      const auto here = circuit_turns(angle);
      if (!here) return;
      turns = *here;
      const double f = turns - wanted;
      if ((f < 0) != (fb < 0)) {
        a = b, fa = fb;
      } else {
        fa /= 2;
      }
      b = angle, fb = f;
    }
    if (std::abs(turns - wanted) > 1e-10 || overlap(N, angle) < 0 || overlap(N, angle) > query_.most_overlap)
      return;
    add(angle, N, stride, starts, leading);
  }

  static std::pair<std::int64_t, bool> starts_of(std::int64_t stride, std::int64_t N) {
    std::int64_t at = 0;
    for (std::int64_t p = 1; p <= N; ++p) {
      at = (at + stride) % N;
      if (at == 1) return {p, true};
      if (at == N - 1) return {p, false};
    }
    return {N, true};
  }

  void add(double angle, std::int64_t N, std::int64_t stride, std::int64_t starts, bool leading) {
    const std::optional<SteeredPass> found = passes_.at(angle);
    if (!found) return;
    const FibrePass& pass = found->pass;
    VesselPattern pattern;
    pattern.angle_deg = angle;
    pattern.circuits = N;
    pattern.stride = stride;
    pattern.starts = starts;
    pattern.leading = leading;
    pattern.turn_deg = 2 * degrees(pass.turn_rad());
    pattern.length_mm = 2 * pass.length_mm();
    pattern.opening_first_mm = pass.first().r_mm;
    pattern.opening_last_mm = pass.last().r_mm;
    pattern.ratio_first = found->ratio_first;
    pattern.ratio_last = found->ratio_last;
    pattern.overlap = overlap(N, angle);
    out_.push_back(pattern);
  }

  const VesselQuery& query_;
  PassMaker passes_;
  double R_;
  std::vector<VesselPattern> out_;
};

}  // namespace

std::vector<VesselPattern> find_vessel_patterns(const Meridian& meridian, const VesselQuery& query) {
  return Search(meridian, query).found();
}

std::string patterns_refusal(const Meridian& meridian, const VesselQuery& query) {
  const PassMaker passes(meridian, rule_of(query));
  const double least = passes.least_angle_deg();
  if (query.angle_deg + query.tolerance_deg < least) {
    return "the polar opening at this angle is smaller than the tow; the least possible angle is " +
           significant_text(std::ceil(least * 1e4) / 1e4, 6) + " deg";
  }
  const std::string refusal = passes.refusal(query.angle_deg);
  return refusal.empty() ? "no pattern closes near this angle; give a larger tolerance or overlap" : refusal;
}

}  // namespace afptraj
