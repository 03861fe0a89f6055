#include "geometry/surface_curve.h"

#include <algorithm>
#include <cmath>

#include "geometry/curvature.h"

namespace afptraj {

namespace {

constexpr double on_line = 1e-10;  // of the domain: what counts as on a line

struct Lines {
  const std::vector<double>* values;
  double period, size, origin;
};

Lines lines_of(const Surface& surface, int axis) {
  const Interval d = axis == 0 ? surface.domain_u() : surface.domain_v();
  return {axis == 0 ? &surface.creases_u() : &surface.creases_v(), axis == 0 ? surface.period_u() : surface.period_v(),
          d.length(), d.lo};
}

double periods_below(const Lines& lines, double t) {
  return lines.period > 0 ? lines.period * std::floor((t - lines.origin) / lines.period) : 0.0;
}

}  // namespace

std::optional<CreaseCrossing> crease_between(const Surface& surface, const Uv& a, const Uv& b) {
  std::optional<CreaseCrossing> first;
  for (int axis = 0; axis < 2; ++axis) {
    const Lines lines = lines_of(surface, axis);
    if (lines.values->empty()) continue;
    const double shift = periods_below(lines, a[axis]), slack = on_line * lines.size;
    const double lo = std::min(a[axis], b[axis]) + slack, hi = std::max(a[axis], b[axis]) - slack;
    auto it = std::lower_bound(lines.values->begin(), lines.values->end(), lo - shift);
    for (; it != lines.values->end() && *it + shift < hi; ++it) {
      const double x = (*it + shift - a[axis]) / (b[axis] - a[axis]);
      if (!first || x < first->x) first = CreaseCrossing{x, axis, *it + shift};
    }
  }
  return first;
}

bool on_crease(const Surface& surface, const Uv& uv) {
  for (int axis = 0; axis < 2; ++axis) {
    const Lines lines = lines_of(surface, axis);
    const double shift = periods_below(lines, uv[axis]), slack = on_line * lines.size;
    for (double value : *lines.values)
      if (std::abs(value + shift - uv[axis]) <= slack) return true;
  }
  return false;
}

UvCubic cubic(const std::vector<CurveNode>& piece, std::size_t i) {
  const CurveNode& a = piece[i];
  const CurveNode& b = piece[i + 1];
  const double h = b.t - a.t;
  return UvCubic::hermite(a.at.uv, h * a.duv, b.at.uv, h * b.duv);
}

CurveFrame frame_at(const Skin& skin, const std::vector<CurveNode>& piece, std::size_t i, double x) {
  const CurveNode& a = piece[i];
  const CurveNode& b = piece[i + 1];
  const UvCubic path = cubic(piece, i);
  CurveFrame out;
  out.at = {a.at.face, path.point(x)};
  const SurfaceDerivatives d = skin.derivatives(out.at);
  const Vec3 velocity = uv_to_tangent(d, path.derivative(x)) / (b.t - a.t);
  out.speed = velocity.norm();
  out.normal_sign = a.normal_sign;
  const double sign = skin.face(a.at.face).reversed ? -a.normal_sign : a.normal_sign;
  out.frame = {d.S, velocity / std::max(out.speed, 1e-300), sign * unit_normal(d)};
  out.kg_per_mm = (1 - x) * a.kg_per_mm + x * b.kg_per_mm;
  return out;
}

CurveFrame frame_at(const Skin& skin, const SurfaceCurve& curve, double t) {
  const auto* piece = &curve.pieces.front();
  for (const auto& candidate : curve.pieces) {
    piece = &candidate;
    if (candidate.back().t >= t) break;
  }
  const auto it = std::upper_bound(piece->begin(), piece->end(), t,
                                   [](double value, const CurveNode& node) { return value < node.t; });
  const auto last = static_cast<std::ptrdiff_t>(piece->size()) - 2;
  const auto i = static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(it - piece->begin() - 1, 0, last));
  const double x = (t - (*piece)[i].t) / ((*piece)[i + 1].t - (*piece)[i].t);
  return frame_at(skin, *piece, i, std::clamp(x, 0.0, 1.0));
}

double arc_length(const Skin& skin, const std::vector<CurveNode>& piece, std::size_t i, double x0, double x1) {
  static constexpr double node[5] = {-0.906179845938663993, -0.538469310105683091, 0, 0.538469310105683091,
                                     0.906179845938663993};
  static constexpr double weight[5] = {0.236926885056189088, 0.478628670499366468, 0.568888888888888889,
                                       0.478628670499366468, 0.236926885056189088};
  const UvCubic path = cubic(piece, i);
  double sum = 0;
  for (int k = 0; k < 5; ++k) {
    const double x = 0.5 * (x0 + x1) + 0.5 * (x1 - x0) * node[k];
    const SurfaceDerivatives d = skin.derivatives({piece[i].at.face, path.point(x)});
    sum += weight[k] * uv_to_tangent(d, path.derivative(x)).norm();
  }
  return 0.5 * (x1 - x0) * sum;
}

std::optional<GeodesicFoot> geodesic_foot(const GeodesicTracer& tracer, const SurfaceCurve& curve, double t_seed,
                                          const Vec3& p, double tolerance_mm, double slack_mm) {
  const Skin& skin = tracer.skin();
  double t = std::clamp(t_seed, curve.first(), curve.last());
  CurveFrame foot = frame_at(skin, curve, t);
  const double side = (p - foot.frame.position).dot(foot.frame.left()) >= 0 ? 1 : -1;
  double distance = (p - foot.frame.position).norm();
  double last_miss = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < 25; ++iteration) {
    GeodesicState g = tracer.start(foot.at, side * foot.frame.left(), foot.normal_sign, 1, -side * foot.kg_per_mm);
    g.outside = !skin.trim(foot.at.face).contains(foot.at.uv);
    if (distance > 0 && tracer.advance(g, distance) != TraceEnd::reached) return std::nullopt;
    const PathFrame end = frame_of(skin, g);
    const Vec3 miss = p - end.position;
    if (miss.norm() < tolerance_mm) return GeodesicFoot{t, side * distance, miss.norm()};
    // Two iterations that gain nothing mean that p is not to be reached this way.
    if (iteration > 1 && miss.norm() > 0.7 * last_miss) return std::nullopt;
    if (iteration > 0) last_miss = miss.norm();
    const Vec3 along = side * end.tangent.cross(end.normal);  // image of the curve's tangent
    const double stretch = std::copysign(std::max(std::abs(g.y), 0.05), g.y) * foot.speed;
    const double dt = miss.dot(along) / stretch;
    const double limit = std::max(distance, 1.0);
    distance += std::clamp(miss.dot(end.tangent), -0.5 * limit, 0.5 * limit);
    const double wanted = t + std::clamp(dt, -limit, limit);
    t = std::clamp(wanted, curve.first(), curve.last());
    if (std::abs(wanted - t) > slack_mm && std::abs(wanted - t) > 10 * tolerance_mm && iteration > 2)
      return std::nullopt;
    if (distance < 0) distance = 0;
    foot = frame_at(skin, curve, t);
  }
  return std::nullopt;
}

}  // namespace afptraj
