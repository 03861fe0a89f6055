#include "winding/pass_maker.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "geometry/error.h"
#include "winding/frustum.h"
#include "winding/number_words.h"
#include "winding/quadrature.h"

namespace afptraj {
namespace {

constexpr double greatest_ratio = 4;  // beyond which no friction is looked for
constexpr int samples_per_span = 32;

// Where f, of different signs at a and b, is 0: Illinois' variant of regula falsi.
double zero(const std::function<double(double)>& f, double a, double fa, double b, double fb,
            double tolerance) {
  double at = b;
  for (int i = 0; i < 100 && std::abs(b - a) > tolerance && fb != 0; ++i) {
    at = fb == fa ? (a + b) / 2 : b - fb * (b - a) / (fb - fa);
    const double here = f(at);
    if ((here < 0) != (fb < 0)) {
      a = b, fa = fb;
    } else {
      fa /= 2;
    }
    if (std::abs(at - b) < tolerance) return at;
    b = at, fb = here;
  }
  return fb == 0 ? b : at;
}

// Places of a meridian from one on outwards, close enough to see its shape.
std::vector<double> places(const Meridian& meridian, double from, bool forward) {
  std::vector<double> breaks = meridian.breaks(), out{from};
  if (!forward) std::reverse(breaks.begin(), breaks.end());
  for (const double t : breaks) {
    if (forward ? t <= from : t >= from) continue;
    const double start = out.back();
    for (int k = 1; k <= samples_per_span; ++k) out.push_back(start + (t - start) * k / samples_per_span);
  }
  return out;
}

// Where the meridian has gone `way_mm` from a place on.
double place_beside(const Meridian& meridian, double from, double way_mm, bool forward) {
  const std::vector<double> stops = places(meridian, from, forward);
  double gone = 0;
  for (std::size_t i = 0; i + 1 < stops.size(); ++i) {
    const double a = stops[i], b = stops[i + 1];
    const double way = std::abs(gauss_legendre([&](double t) { return meridian.at(t).speed(); }, a, b));
    if (gone + way >= way_mm) return a + (b - a) * (way_mm - gone) / way;
    gone += way;
  }
  return stops.back();
}

std::string end_name(bool forward) { return forward ? "the last end" : "the first end"; }

}  // namespace

double SteeredPass::needed_friction() const { return std::max(std::abs(ratio_first), std::abs(ratio_last)); }

PassMaker::PassMaker(const Meridian& meridian, const SteeringRule& rule)
    : meridian_(meridian),
      rule_(rule),
      R_(meridian.at(meridian.widest()).r_mm),
      middle_t_(meridian.widest()) {
  first_ = side(false);
  last_ = side(true);
  middle_t_ = (first_.edge_t + last_.edge_t) / 2;
  for (Side* side : {&first_, &last_}) {
    if (side->opening_mm) {
      side->grid = std::make_shared<SteeringGrid>(meridian, side->edge_t, side->turn_t);
    } else if (rule_.friction > 0 && (side->turn_t - middle_t_) * (side->forward ? 1 : -1) > 0) {
      side->grid = std::make_shared<SteeringGrid>(meridian, side->turn_t, middle_t_);
    }
  }
}

PassMaker::Side PassMaker::side(bool forward) const {
  Side out;
  out.forward = forward;
  out.opening_mm = forward ? rule_.opening_last_mm : rule_.opening_first_mm;
  out.least_mm = R_;
  const std::vector<double> stops = places(meridian_, meridian_.widest(), forward);
  bool widest = true;
  out.edge_t = stops.front();
  for (const double t : stops) {
    const double r = meridian_.at(t).r_mm;
    if (out.least_mm >= rule_.tow_width_mm / 2) out.end_t = t;
    widest = widest && r >= R_ * (1 - 1e-6);
    if (widest) out.edge_t = t;
    out.least_mm = std::min(out.least_mm, r);
  }
  if (rule_.on_widest) {
    out.least_mm = R_;
    out.turn_t = place_beside(meridian_, out.edge_t, rule_.tow_width_mm / 2, !forward);
    return out;
  }
  if (!out.opening_mm) {
    out.turn_t = place_beside(meridian_, forward ? meridian_.last() : meridian_.first(),
                              rule_.tow_width_mm / 2, !forward);
    return out;
  }
  const double wanted = *out.opening_mm;
  if (wanted < rule_.tow_width_mm / 2) {
    throw Error(ErrorCode::no_path, "mandrel",
                "is to have an opening of radius " + significant_text(wanted, 6) + " mm towards " +
                    end_name(forward) + ", which is narrower than the tow; give at least " +
                    significant_text(rule_.tow_width_mm / 2, 6) + " mm");
  }
  for (std::size_t i = 1; i < stops.size(); ++i) {
    if (meridian_.at(stops[i]).r_mm > wanted || meridian_.at(stops[i - 1]).r_mm <= wanted) continue;
    double outside = stops[i - 1], inside = stops[i];
    for (int k = 0; k < 200 && outside != inside; ++k) {
      const double middle = outside + (inside - outside) / 2;
      if (middle == outside || middle == inside) break;
      (meridian_.at(middle).r_mm > wanted ? outside : inside) = middle;
    }
    out.turn_t = outside;
    return out;
  }
  throw Error(ErrorCode::no_path, "mandrel",
              "has no place of radius " + significant_text(wanted, 6) + " mm towards " + end_name(forward) +
                  " to turn at; give one from " + significant_text(out.least_mm, 6) + " to " +
                  significant_text(R_, 6) + " mm");
}

double PassMaker::least_angle_deg() const {
  const auto may_cross = [&](const Side& side) {
    return !side.opening_mm && side.least_mm < rule_.tow_width_mm / 2;
  };
  if (!may_cross(first_) && !may_cross(last_)) return 0;
  return degrees(std::asin(std::min(1.0, rule_.tow_width_mm / 2 / R_)));
}

bool PassMaker::is_geodesic(const Side& side, double clairaut_mm) const {
  return !side.opening_mm && side.least_mm <= clairaut_mm;
}

// Along the side's grid; the ratio is positive where r sin(alpha) grows outwards.
SteeredClairaut PassMaker::solution(const Side& side, double start_mm, double outward_ratio) const {
  return {*side.grid, start_mm, side.forward ? outward_ratio : -outward_ratio};
}

// The ratio with which the fibre turns at the side's opening.
std::optional<double> PassMaker::opening_ratio(const Side& side, double clairaut_mm) const {
  const double wanted = meridian_.at(side.turn_t).r_mm;
  const auto beyond = [&](double ratio) {
    return solution(side, clairaut_mm, ratio).at(side.turn_t).q_mm - wanted;
  };
  const double free = beyond(0);
  if (std::abs(free) < 1e-12 * R_) return 0;
  const double most = free < 0 ? greatest_ratio : -greatest_ratio, with_most = beyond(most);
  if ((with_most < 0) == (free < 0)) return std::nullopt;
  return zero(beyond, 0, free, most, with_most, 1e-14);
}

// The least ratio with which the fibre, steered from the middle on, turns before the side's end.
std::optional<double> PassMaker::lock_ratio(const Side& side, double clairaut_mm) const {
  if (!side.grid) return std::nullopt;
  const double turn_mm = meridian_.at(side.turn_t).r_mm;
  const auto above = [&](double ratio) {
    return solution(side, turn_mm, ratio).at(middle_t_).q_mm - clairaut_mm;
  };
  const double free = above(0), with_most = above(greatest_ratio);
  if ((with_most < 0) == (free < 0)) return std::nullopt;
  return zero(above, 0, free, greatest_ratio, with_most, 1e-14);
}

PassMaker::Steered PassMaker::steered(const Side& side, double clairaut_mm) const {
  constexpr double rounding = 1e-9;
  if (is_geodesic(side, clairaut_mm)) return {};
  if (side.opening_mm) {
    const auto ratio = opening_ratio(side, clairaut_mm);
    if (!ratio || std::abs(*ratio) > rule_.friction + rounding)
      return {{}, ratio.value_or(greatest_ratio), false};
    const auto path = std::make_shared<const SteeredClairaut>(solution(side, clairaut_mm, *ratio));
    return {Steering{side.edge_t, path, side.turn_t}, *ratio, true};
  }
  const double ratio = rule_.friction, turn_mm = meridian_.at(side.turn_t).r_mm;
  if (!(ratio > 0) || !side.grid || turn_mm <= clairaut_mm) return {{}, 0, false};
  const auto path = std::make_shared<const SteeredClairaut>(solution(side, turn_mm, ratio));
  const auto above = [&](double t) { return path->at(t).q_mm - clairaut_mm; };
  const double at_middle = above(middle_t_);
  if (at_middle >= 0) return {{}, lock_ratio(side, clairaut_mm).value_or(greatest_ratio), false};
  const double from = zero(above, side.turn_t, turn_mm - clairaut_mm, middle_t_, at_middle,
                           1e-14 * (meridian_.last() - meridian_.first()));
  return {Steering{from, path, side.turn_t}, ratio, true};
}

std::optional<SteeredPass> PassMaker::at(double angle_deg) const {
  const double K = R_ * std::sin(radians(angle_deg));
  if (!(K < R_)) return std::nullopt;
  const Steered first = steered(first_, K), last = steered(last_, K);
  if (!first.turns || !last.turns) return std::nullopt;
  SteeredPass out{FibrePass(meridian_, K, middle_t_, first.steering, last.steering), first.ratio, last.ratio};
  const double near = 1e-9 * (meridian_.last() - meridian_.first());
  for (const auto& [steering, end] :
       {std::pair{&first.steering, &out.pass.first()}, {&last.steering, &out.pass.last()}}) {
    if (!end->turns) return std::nullopt;
    if (*steering && std::abs(end->t - *(*steering)->turn_t) > near) return std::nullopt;
  }
  return out;
}

// The radius at which a fibre turns that is steered from the end of the widest stretch; of the mandrel's end
// where it does not turn.
double PassMaker::reached_mm(const Side& side, double clairaut_mm, double outward_ratio) const {
  const SteeringGrid grid(meridian_, side.edge_t, side.end_t);
  const auto path = std::make_shared<const SteeredClairaut>(grid, clairaut_mm,
                                                            side.forward ? outward_ratio : -outward_ratio);
  const std::optional<Steering> steering = Steering{side.edge_t, path};
  const FibrePass pass(meridian_, clairaut_mm, middle_t_, side.forward ? std::nullopt : steering,
                       side.forward ? steering : std::nullopt);
  return std::max((side.forward ? pass.last() : pass.first()).r_mm, rule_.tow_width_mm / 2);
}

std::string PassMaker::side_refusal(const Side& side, double angle_deg) const {
  const double K = R_ * std::sin(radians(angle_deg));
  const Steered found = steered(side, K);
  if (found.turns) return {};
  const std::string angle = significant_text(angle_deg, 6) + " deg";
  const std::string needed = std::abs(found.ratio) < greatest_ratio
                                 ? "a friction of " + significant_text(std::abs(found.ratio), 4)
                                 : "more friction than any";
  const auto degrees_up = [&](double sine) {
    return significant_text(std::ceil(degrees(std::asin(std::min(1.0, sine))) * 1e4) / 1e4, 6) + " deg";
  };
  if (side.opening_mm) {
    return "turning at a radius of " + significant_text(*side.opening_mm, 6) + " mm towards " +
           end_name(side.forward) + " needs " + needed + " at " + angle + ", " +
           significant_text(rule_.friction, 4) + " is allowed; radii from " +
           significant_text(reached_mm(side, K, -rule_.friction), 6) + " to " +
           significant_text(reached_mm(side, K, rule_.friction), 6) + " mm can be reached";
  }
  if (!(rule_.friction > 0) || !side.grid) {
    return "a geodesic at " + angle + " runs off " + end_name(side.forward) +
           "; give friction to turn it, or " +
           (side.least_mm < R_ ? "an angle of at least " + degrees_up(side.least_mm / R_)
                               : "a mandrel with domes");
  }
  const double least = solution(side, meridian_.at(side.turn_t).r_mm, rule_.friction).at(middle_t_).q_mm;
  return "turning before " + end_name(side.forward) + " needs " + needed + " at " + angle + ", " +
         significant_text(rule_.friction, 4) + " is allowed; give an angle of at least " +
         degrees_up(least / R_);
}

std::string PassMaker::refusal(double angle_deg) const {
  const std::string first = side_refusal(first_, angle_deg);
  return first.empty() ? side_refusal(last_, angle_deg) : first;
}

}  // namespace afptraj
