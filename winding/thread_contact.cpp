#include "winding/thread_contact.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace afptraj {
namespace {

struct State {
  double t, turn_rad;
};

struct Rate {
  double t, turn_rad;  // by length
  double angle_rad;
};

// A place on the eye's way, which piece of it, and the share of that.
struct Stop {
  EyePlace eye;
  double at;
};

EyePlace between(const EyePlace& a, const EyePlace& b, double share) {
  return {a.z_mm + share * (b.z_mm - a.z_mm), a.radius_mm + share * (b.radius_mm - a.radius_mm),
          a.azimuth_rad + share * (b.azimuth_rad - a.azimuth_rad)};
}

// Pieces cut so that the eye passes a tangent plane once on each.
std::vector<Stop> cut(const std::vector<EyePlace>& eyes) {
  constexpr double greatest_turn_rad = 0.25;
  std::vector<Stop> out{{eyes.front(), 0}};
  for (std::size_t i = 1; i < eyes.size(); ++i) {
    const EyePlace &a = eyes[i - 1], &b = eyes[i];
    const double parts =
        std::max(1.0, std::ceil(std::abs(b.azimuth_rad - a.azimuth_rad) / greatest_turn_rad));
    for (double k = 1; k <= parts; ++k)
      out.push_back({between(a, b, k / parts), static_cast<double>(i - 1) + k / parts});
  }
  return out;
}

class Follower {
 public:
  Follower(const Meridian& meridian, const std::vector<EyePlace>& eyes)
      : meridian_(meridian), stops_(cut(eyes)) {}

  std::vector<ContactPoint> from(State state, double step) {
    std::vector<ContactPoint> out;
    double length = 0;
    enter(state.t);
    const double longest = thread_mm(state) + step;
    while (const std::optional<Rate> here = length < longest ? rate(state) : std::nullopt) {
      const MeridianPoint at = meridian_.at(state.t);
      out.push_back({state.t, at.z_mm, at.r_mm, state.turn_rad, length, here->angle_rad, at_eye()});
      std::optional<State> next = stepped(state, step);
      if (!next) return out;
      double way = step;
      if (next->t < low_ || next->t > high_) {
        next = stepped_to(next->t < low_ ? low_ : high_, state, *next, way);
        if (!next) return out;
        enter(next->t);
      }
      state = *next;
      length += way;
    }
    return out;
  }

 private:
  // What can be laid at most: the first free length, and the eye's way. It ends what goes round and round
  // where the eye enters the mandrel.
  double thread_mm(const State& start) const {
    const Offset to = offset(stops_.front().eye, meridian_.at(start.t), start.turn_rad);
    double sum = std::hypot(to.radial, to.hoop, to.axial);
    for (std::size_t i = 1; i < stops_.size(); ++i) {
      const EyePlace &a = stops_[i - 1].eye, &b = stops_[i].eye;
      sum += std::hypot(b.z_mm - a.z_mm, b.radius_mm - a.radius_mm,
                        (a.radius_mm + b.radius_mm) / 2 * (b.azimuth_rad - a.azimuth_rad));
    }
    return sum;
  }

  static State ahead(const State& state, const Rate& rate, double way) {
    return {state.t + way * rate.t, state.turn_rad + way * rate.turn_rad};
  }

  // One step of Runge-Kutta's method; none where the eye's way ends before.
  std::optional<State> stepped(const State& state, double way) {
    const auto a = rate(state);
    const auto b = a ? rate(ahead(state, *a, way / 2)) : a;
    const auto c = b ? rate(ahead(state, *b, way / 2)) : b;
    const auto d = c ? rate(ahead(state, *c, way)) : c;
    if (!d) return std::nullopt;
    return State{state.t + way * (a->t + 2 * b->t + 2 * c->t + d->t) / 6,
                 state.turn_rad + way * (a->turn_rad + 2 * b->turn_rad + 2 * c->turn_rad + d->turn_rad) / 6};
  }

  // Where the meridian changes from one polynomial to another, its speed and curvature may jump: a step is
  // taken on the polynomial on which it begins, and ends where that does.
  void enter(double t) {
    const std::vector<double>& breaks = meridian_.breaks();
    const auto after = std::upper_bound(breaks.begin() + 1, breaks.end() - 1, t);
    low_ = after - 1 == breaks.begin() ? -1e300 : *(after - 1);
    high_ = after + 1 == breaks.end() ? 1e300 : *after;
  }
  double beyond_break() const { return 1e-12 * (meridian_.last() - meridian_.first()); }
  MeridianPoint meridian_at(double t) const {
    return meridian_.at(std::clamp(t, low_ + beyond_break(), high_ - beyond_break()));
  }

  // The step that ends at `stop`, shorter than `way`, which is set to it; `over` is where the whole one ends.
  // Put just beyond, where the next polynomial holds.
  std::optional<State> stepped_to(double stop, const State& state, State over, double& way) {
    double low = 0, high = way, low_t = state.t, high_t = over.t;
    const double direction = over.t > state.t ? 1 : -1;
    for (int i = 0; i < 60 && std::abs(over.t - stop) > beyond_break(); ++i) {
      // Secants, kept within the bracket by bisection every third time.
      way = i % 3 == 2 ? (low + high) / 2 : low + (high - low) * (stop - low_t) / (high_t - low_t);
      const auto at = stepped(state, way);
      if (!at) return at;
      over = *at;
      const bool before = direction * (over.t - stop) < 0;
      (before ? low : high) = way;
      (before ? low_t : high_t) = over.t;
    }
    return State{stop + direction * beyond_break(), over.turn_rad};
  }

  // The eye against a contact: along its radius, round, along the axis.
  struct Offset {
    double radial, hoop, axial;
  };
  static Offset offset(const EyePlace& eye, const MeridianPoint& at, double turn_rad) {
    const double azimuth = eye.azimuth_rad - turn_rad;
    return {eye.radius_mm * std::cos(azimuth) - at.r_mm, eye.radius_mm * std::sin(azimuth),
            eye.z_mm - at.z_mm};
  }
  // Height of the eye over the tangent plane, times the meridian's speed.
  static double height(const EyePlace& eye, const MeridianPoint& at, double turn_rad) {
    const Offset to = offset(eye, at, turn_rad);
    return to.radial * at.dz - to.axial * at.dr;
  }

  EyePlace eye(double share) const { return between(stops_[piece_].eye, stops_[piece_ + 1].eye, share); }
  double at_eye() const { return stops_[piece_].at + share_ * (stops_[piece_ + 1].at - stops_[piece_].at); }

  // The eye comes down through the tangent plane of the contact; none where it has not yet when it ends.
  std::optional<Rate> rate(const State& state) {
    const MeridianPoint at = meridian_at(state.t);
    const auto height_at = [&](std::size_t i) { return height(stops_[i].eye, at, state.turn_rad); };
    while (piece_ > 0 && height_at(piece_) < 0) --piece_;
    while (height_at(piece_ + 1) > 0) {
      if (piece_ + 2 == stops_.size()) return std::nullopt;
      ++piece_;
    }
    share_ = crossing(at, state.turn_rad);
    const Offset to = offset(eye(share_), at, state.turn_rad);
    const double speed = at.speed();
    const double along = (to.radial * at.dr + to.axial * at.dz) / speed;
    const double angle = std::atan2(to.hoop, along);
    return Rate{std::cos(angle) / speed, std::sin(angle) / at.r_mm, angle};
  }

  // Illinois' variant of regula falsi on the piece; an eye that is already below at the start counts as
  // there.
  double crossing(const MeridianPoint& at, double turn_rad) const {
    double a = 0, b = 1;
    double fa = height(eye(0), at, turn_rad), fb = height(eye(1), at, turn_rad);
    if (fa <= 0) return 0;
    double share = 1;
    for (int i = 0; i < 100; ++i) {
      const double next = fa == fb ? (a + b) / 2 : b - fb * (b - a) / (fb - fa);
      if (std::abs(next - share) < 1e-14) return next;
      share = next;
      const double f = height(eye(share), at, turn_rad);
      if (f == 0) return share;
      if ((f < 0) != (fb < 0)) {
        a = b, fa = fb;
      } else {
        fa /= 2;
      }
      b = share, fb = f;
    }
    return share;
  }

  const Meridian& meridian_;
  const std::vector<Stop> stops_;
  std::size_t piece_ = 0;
  double share_ = 0;
  double low_ = 0, high_ = 0;  // ends of the polynomial that the thread is on
};

}  // namespace

std::vector<ContactPoint> follow_thread(const Meridian& meridian, double start_t, double start_turn_rad,
                                        const std::vector<EyePlace>& eyes, double step_mm) {
  return Follower(meridian, eyes).from({start_t, start_turn_rad}, step_mm);
}

}  // namespace afptraj
