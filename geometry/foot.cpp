#include "geometry/foot.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/closest_point.h"

namespace afptraj {
namespace foot {
namespace {

double turned(double x, double to, double period) {
  return period > 0 && std::isfinite(x) ? x - period * std::round((x - to) / period) : x;
}

/// The step from r = S - p; false where both forms of it are singular.
bool step_of(const SurfaceDerivatives& d, const Vec3& r, Uv& step) {
  const double gu = r.dot(d.Su), gv = r.dot(d.Sv);
  const double E = d.Su.squaredNorm(), F = d.Su.dot(d.Sv), G = d.Sv.squaredNorm();
  double a = E + r.dot(d.Suu), b = F + r.dot(d.Suv), c = G + r.dot(d.Svv);
  double det = a * c - b * b;
  // Not (or hardly) positive definite: Newton would run to a saddle or a maximum.
  if (!(a > 0 && c > 0 && det > 1e-6 * a * c)) {
    a = E;
    b = F;
    c = G;
    // A little of the identity keeps poles (Su = 0) solvable.
    a += 1e-12 * (E + G) * (E > 0 ? 1 : 0);
    det = a * c - b * b;
    if (!(det > 0)) {
      step = Uv(E > 0 ? -gu / E : 0, G > 0 ? -gv / G : 0);
      return E > 0 || G > 0;
    }
  }
  step = Uv((b * gv - c * gu) / det, (b * gu - a * gv) / det);
  return true;
}

/// r.Su is known no better than |r| times the rounding of Su, which counts near a pole: there Su is
/// small against the coordinates it is a difference of.
bool is_foot(const SurfaceDerivatives& d, const Vec3& r, double tolerance, const Uv& size) {
  const double rounding = 1e-15 * r.norm() * d.S.cwiseAbs().maxCoeff();
  return std::abs(r.dot(d.Su)) <= tolerance * d.Su.norm() + rounding / size.x() &&
         std::abs(r.dot(d.Sv)) <= tolerance * d.Sv.norm() + rounding / size.y();
}

}  // namespace

Uv unwrap(const Surface& surface, Uv uv, const Uv& to) {
  uv.x() = turned(uv.x(), to.x(), surface.period_u());
  uv.y() = turned(uv.y(), to.y(), surface.period_v());
  return uv;
}

Feet analytic_feet(const Surface& surface, const Vec3& p, const Uv& seed) {
  const Frame& frame = surface.frame();
  const Vec3 d = p - frame.origin;
  const double x = d.dot(frame.x), y = d.dot(frame.y), z = d.dot(frame.z);
  Feet feet;
  const auto add = [&](double u, double v) {
    feet.uv[static_cast<std::size_t>(feet.count++)] = unwrap(surface, Uv(u, v), seed);
  };
  if (surface.kind() == SurfaceKind::plane) {
    add(x, y);
    return feet;
  }
  const double rho = std::hypot(x, y);
  const double u = rho > 0 ? std::atan2(y, x) : seed.x();
  const double R = surface.radius(), second = surface.second_parameter();
  switch (surface.kind()) {
    case SurfaceKind::cylinder:
      add(u, z);
      break;
    case SurfaceKind::sphere:
      add(u, rho > 0 || z != 0 ? std::atan2(z, rho) : std::clamp(seed.y(), -pi / 2, pi / 2));
      break;
    case SurfaceKind::cone: {
      const double s = std::sin(second), c = std::cos(second);
      add(u, (rho - R) * s + z * c);
      add(u + pi, (-rho - R) * s + z * c);
      break;
    }
    case SurfaceKind::torus:
      for (const double side : {rho, -rho}) {
        const double v = side != R || z != 0 ? std::atan2(z, side - R) : seed.y();
        add(side >= 0 && side == rho ? u : u + pi, v);
      }
      break;
    default:
      break;
  }
  return feet;
}

std::optional<Foot> descend(const Surface& surface, const Vec3& p, const Uv& seed, const Limits& limits,
                            double tolerance_mm) {
  constexpr int most_steps = 40;
  // Rounding of S: about 4 ulp of the coordinates.
  const double noise = 8e-15 * p.cwiseAbs().maxCoeff();
  const double tolerance = std::max(tolerance_mm, 0.125 * noise);
  const auto evaluate = [&](const Uv& at) {
    return limits.span ? surface.derivatives(*limits.span, at) : surface.derivatives(at);
  };
  Uv uv = seed;
  SurfaceDerivatives d = evaluate(uv);
  Vec3 r = d.S - p;
  double f = r.squaredNorm();
  for (int i = 0; i < most_steps; ++i) {
    if (is_foot(d, r, tolerance, limits.most)) return Foot{uv, d.S, std::sqrt(f)};
    Uv step;
    if (!step_of(d, r, step)) return std::nullopt;
    const double too_long = (step.cwiseAbs().cwiseQuotient(limits.most)).maxCoeff();
    if (too_long > 1) step /= too_long;
    double length = 1;
    for (int halvings = 0;; ++halvings) {
      const Uv next = uv + length * step;
      const SurfaceDerivatives dn = evaluate(next);
      const Vec3 rn = dn.S - p;
      const double fn = rn.squaredNorm();
      // Near the foot f is flat to the rounding of S: then the Newton step itself is trusted.
      if (fn <= f + noise * std::sqrt(f) + noise * noise || halvings == 12) {
        uv = next;
        d = dn;
        r = rn;
        f = fn;
        break;
      }
      length *= halvings < 2 ? 0.5 : 0.25;
    }
    if ((uv.array() < limits.lo.array()).any() || (uv.array() > limits.hi.array()).any()) return std::nullopt;
  }
  return is_foot(d, r, 10 * tolerance, limits.most) ? std::optional<Foot>(Foot{uv, d.S, std::sqrt(f)})
                                                    : std::nullopt;
}

}  // namespace foot

std::optional<Uv> foot_point(const Surface& surface, const Vec3& p, const Uv& seed, double tolerance_mm) {
  if (surface.spline() == nullptr) {
    const foot::Feet feet = foot::analytic_feet(surface, p, seed);
    double best = std::numeric_limits<double>::infinity();
    std::optional<Uv> nearest;
    for (int i = 0; i < feet.count; ++i) {
      const Uv& uv = feet.uv[static_cast<std::size_t>(i)];
      const double distance = (surface.point(uv) - p).norm();
      if (distance >= best) continue;
      best = distance;
      nearest = uv;
    }
    return nearest;
  }
  constexpr double inf = std::numeric_limits<double>::infinity();
  const Uv size(surface.domain_u().length(), surface.domain_v().length());
  const foot::Limits limits{Uv::Constant(-inf), Uv::Constant(inf), 0.25 * size, nullptr};
  const std::optional<foot::Foot> found = foot::descend(surface, p, seed, limits, tolerance_mm);
  if (!found) return std::nullopt;
  return found->uv;
}

}  // namespace afptraj
