#include "chart_free_geodesic.h"

#include <algorithm>
#include <cmath>

namespace oracle {
namespace {

struct State {
  Foot at;  // where x projects; seed of the next projection
  Vec x, t;
  double y, dy;
  // Over an apex, where there is no tangent plane, nothing leads straight on.
  bool lost() const { return !std::isfinite(x.SquareModulus()) || !std::isfinite(t.SquareModulus()); }
};

struct Rate {
  Vec dx, dt;
  double dy, ddy;
};

class Walker {
 public:
  explicit Walker(const Skin& skin) : skin_(skin) {}

  // One Gauss-Newton correction per stage is enough: stages lie within O(h^2) of the surface.
  Rate rate(const State& s, Foot& seed) const {
    if (s.lost()) return {s.t, s.t, 0, 0};
    Jet j = skin_.jet(seed.face, seed.u, seed.v);
    for (int i = 0; i < 2; ++i) {
      const Vec r = s.x - j.S;
      const double E = j.Su * j.Su, F = j.Su * j.Sv, G = j.Sv * j.Sv, det = E * G - F * F;
      if (!(det > 1e-14 * E * G)) break;
      seed.u += (G * (r * j.Su) - F * (r * j.Sv)) / det;
      seed.v += (E * (r * j.Sv) - F * (r * j.Su)) / det;
      j = skin_.jet(seed.face, seed.u, seed.v);
    }
    const Vec n = j.normal();
    const Vec t = s.t - n * (n * s.t);
    return {s.t, n * j.normal_curvature(t), s.dy, -j.gaussian() * s.y};
  }

  State rk4(const State& s, double h) const {
    const auto moved = [&](const Rate& k, double f) {
      return State{s.at, s.x + k.dx * f, s.t + k.dt * f, s.y + k.dy * f, s.dy + k.ddy * f};
    };
    Foot seed = s.at;
    const Rate k1 = rate(s, seed);
    seed = s.at;
    const Rate k2 = rate(moved(k1, h / 2), seed);
    const Rate k3 = rate(moved(k2, h / 2), seed);
    const Rate k4 = rate(moved(k3, h), seed);
    State end = s;
    end.x = s.x + (k1.dx + k2.dx * 2 + k3.dx * 2 + k4.dx) * (h / 6);
    end.t = s.t + (k1.dt + k2.dt * 2 + k3.dt * 2 + k4.dt) * (h / 6);
    end.y = s.y + h / 6 * (k1.dy + 2 * k2.dy + 2 * k3.dy + k4.dy);
    end.dy = s.dy + h / 6 * (k1.ddy + 2 * k2.ddy + 2 * k3.ddy + k4.ddy);
    return settled(end, seed);
  }

  // x back on the surface, t back into its tangent plane.
  State settled(State s, const Foot& seed) const {
    if (s.lost()) return s;
    s.at = skin_.foot(seed.face, s.x, seed.u, seed.v);
    if (s.at.distance > 1) s.at = skin_.nearest_on(seed.face, s.x);
    s.x = s.at.point;
    const Vec n = skin_.jet(s.at.face, s.at.u, s.at.v).normal();
    s.t -= n * (n * s.t);
    s.t.Normalize();
    return s;
  }

  // Two half steps, extrapolated, with the difference to one whole step as the error.
  State doubled(const State& s, double h, double remaining, double& error) const {
    const State whole = rk4(s, h);
    State half = rk4(rk4(s, h / 2), h / 2);
    const Vec dx = (half.x - whole.x) / 15, dt = (half.t - whole.t) / 15;
    error = dx.Modulus() + dt.Modulus() * std::max(remaining - h, 0.0);
    half.x += dx;
    half.t += dt;
    half.y += (half.y - whole.y) / 15;
    half.dy += (half.dy - whole.dy) / 15;
    return settled(half, half.at);
  }

 private:
  const Skin& skin_;
};

bool too_far(const Skin& skin, const Foot& at) {
  const auto& b = skin.box(at.face);
  const double mu = 0.4 * (b[1] - b[0]), mv = 0.4 * (b[3] - b[2]);
  return (skin.period_u(at.face) == 0 && (at.u < b[0] - mu || at.u > b[1] + mu)) ||
         (skin.period_v(at.face) == 0 && (at.v < b[2] - mv || at.v > b[3] + mv));
}

}  // namespace

Vec transported(const Vec& t, const Vec& from, const Vec& to) {
  const Vec axis = from ^ to;
  const double c = from * to;
  if (c < -0.999999) return t;
  // Rodrigues' formula with sin and 1 - cos taken from axis and c.
  return t * c + (axis ^ t) + axis * ((axis * t) / (1 + c));
}

Shot shoot(const Skin& skin, const Foot& start, const Vec& normal, const Vec& direction, double length,
           double dy0, const ShotOptions& options) {
  const Walker walker(skin);
  State s{start, start.point, direction, 1, dy0};
  Shot shot;
  Vec n = normal;
  double travelled = 0, h = options.fixed_step_mm > 0 ? options.fixed_step_mm : length / 4;
  const double least = std::min(1e-4, 1e-3 * length);
  while (travelled < length * (1 - 1e-15) && shot.steps < 20000) {
    h = std::min(h, length - travelled);
    double error = 0;
    State next =
        options.fixed_step_mm > 0 ? walker.rk4(s, h) : walker.doubled(s, h, length - travelled, error);
    if (options.fixed_step_mm <= 0 && !(error <= options.tolerance_mm) && h > least) {
      h = std::max(least, h * std::clamp(0.9 * std::pow(options.tolerance_mm / error, 0.2), 0.1, 0.5));
      continue;
    }
    if (next.lost()) break;  // the shot falls short
    Vec after = skin.jet(next.at.face, next.at.u, next.at.v).normal();
    if (after * n < 0) after.Reverse();
    const bool outside = !skin.inside(next.at.face, next.at.u, next.at.v);
    if (outside) {
      // Come up to the edge closely, then change to the face that takes over there, if any.
      if (h > 10 * least && skin.inside(s.at.face, s.at.u, s.at.v)) {
        h = std::max(least, h / 4);
        continue;
      }
      const std::optional<Foot> other = skin.other_face_at(next.x, next.at.face);
      if (other && skin.inside(other->face, other->u, other->v)) {
        const Vec before = after;
        next.at = *other;
        next.x = other->point;
        after = skin.jet(other->face, other->u, other->v).normal();
        if (after * before < 0) after.Reverse();
        next.t = transported(next.t, before, after);
        next.t.Normalize();
      } else {
        shot.left_skin = true;
        if (too_far(skin, next.at)) break;
      }
    } else if (h <= least && after * n < 1 - 1e-8) {
      // A crease of the surface: the rotation, not the projection, keeps the geodesic straight.
      next.t = transported(s.t, n, after);
      next.t.Normalize();
    }
    travelled += h;
    ++shot.steps;
    s = next;
    n = after;
    if (options.fixed_step_mm <= 0)
      h *= error > 0 ? std::clamp(0.9 * std::pow(options.tolerance_mm / error, 0.2), 0.5, 4.0) : 4.0;
  }
  shot.at = s.at;
  shot.tangent = s.t;
  shot.normal = n;
  shot.length = travelled;
  shot.y = s.y;
  return shot;
}

}  // namespace oracle
