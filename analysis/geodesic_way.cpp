#include "analysis/geodesic_way.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace afptraj {
namespace {

constexpr int most_iterations = 24;

/// A residual whose square, over a radius of curvature, is no more than the error of the walk.
double close_enough(const GeodesicTracer& tracer) { return std::clamp(1e4 * tracer.options().tolerance_mm, 1e-6, 1e-3); }

GeodesicState leave(const GeodesicTracer& tracer, const CourseLine& line, const CurveFrame& foot, double side) {
  GeodesicState g = tracer.start(foot.at, side * foot.frame.left(), foot.normal_sign, 1, -side * foot.kg_per_mm);
  g.outside = line.off_skin && !tracer.skin().trim(foot.at.face).contains(foot.at.uv);
  return g;
}

/// At a pole a cubic in (u, v) may run away: a point off the loops' box by more than its size is none of the line.
bool near_face(const Skin& skin, const SurfacePoint& at) {
  const TrimRegion& trim = skin.trim(at.face);
  const Uv lo = trim.box_min(), hi = trim.box_max(), size = hi - lo;
  return (at.uv.array() >= (lo - size).array()).all() && (at.uv.array() <= (hi + size).array()).all();
}

/// The Jacobi field as a divisor: kept away from its zeros.
double divisor(double y, double least) { return std::copysign(std::max(std::abs(y), least), y); }

/// Whether a walk is outside anywhere on its way; its ends may lie on the boundary.
bool leaves(const GeodesicTracer& tracer, GeodesicState g, double length_mm) {
  constexpr int parts = 16;
  for (int i = 0; i < parts; ++i)
    if (tracer.advance(g, length_mm / parts * (i + 1 < parts ? 1 : 0.99)) != TraceEnd::reached || g.outside) return true;
  return false;
}

}  // namespace

GeodesicOptions judge_geodesics(const Skin& skin, double band_width_mm, double tolerance_mm) {
  GeodesicOptions out;
  out.tolerance_mm = tolerance_mm;
  out.outside_limit_mm = skin.diagonal();
  out.margin_mm = band_width_mm;
  return out;
}

Way way_from_line(const GeodesicTracer& tracer, const CourseLine& line, const WaySeed& seed, const Vec3& p) {
  const double first = line.t.front(), last = line.t.back(), turn = last - first;
  const double close_mm = close_enough(tracer);
  const double longest = 3 * std::max(seed.distance_mm, 1e-3);
  const double side = seed.side;
  double t = std::clamp(seed.t, first, last), d = seed.distance_mm;
  int pinned = 0;  // iterations in a row that wanted to go past an end
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    const CurveFrame foot = frame_at(tracer.skin(), line.curve, t);
    if (!near_face(tracer.skin(), foot.at)) return {Way::End::failed, t, d, side};
    GeodesicState g = leave(tracer, line, foot, side);
    if (d > 0 && tracer.advance(g, d) != TraceEnd::reached) return {Way::End::failed, t, d, side};
    const PathFrame end = frame_of(tracer.skin(), g);
    const Vec3 miss = p - end.position;
    const Vec3 image = side * end.tangent.cross(end.normal);  // of the line's tangent
    const double along = miss.dot(end.tangent), across = miss.dot(image);
    const double dt = across / (divisor(g.y, 0.1) * std::max(foot.speed, 1e-6));
    const bool there = std::abs(along) < close_mm && std::abs(across) < close_mm;
    if (there && std::abs(miss.dot(end.normal)) > 10 * close_mm) return {Way::End::failed, t, d, side};  // another sheet
    double wanted = t + dt;
    const bool past_end = !line.closed() && (wanted < first - close_mm || wanted > last + close_mm);
    if (there && !past_end && std::abs(dt) < 100 * close_mm) return {Way::End::foot, wanted, d + along, side};
    pinned = past_end ? pinned + 1 : 0;
    if (pinned > 4 || (pinned > 2 && std::abs(along) < 1e-3 * d)) return {Way::End::beyond_end, t, d + along, side};
    const double stride = std::max(0.5 * d, 0.1 * seed.distance_mm);
    d = std::max(0.0, d + std::clamp(along, -stride, stride));
    if (d > longest) break;
    t += std::clamp(dt, -stride, stride);
    if (line.closed())
      t -= turn * std::floor((t - first) / turn);
    else
      t = std::clamp(t, first, last);
  }
  return {Way::End::failed, t, d, side};
}

std::optional<PointWay> way_from_point(const GeodesicTracer& tracer, const CurveFrame& from, const Vec3& p,
                                       double distance_mm) {
  const double close_mm = close_enough(tracer);
  const Vec3 n = from.frame.normal;
  const Vec3 chord = p - from.frame.position;
  Vec3 direction = chord - chord.dot(n) * n;
  if (direction.norm() <= 1e-9 * distance_mm) return std::nullopt;
  direction.normalize();
  double d = distance_mm;
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    GeodesicState g = tracer.start(from.at, direction, from.normal_sign, 0, 1);
    if (tracer.advance(g, d) != TraceEnd::reached) return std::nullopt;
    const PathFrame end = frame_of(tracer.skin(), g);
    const Vec3 miss = p - end.position;
    const double along = miss.dot(end.tangent), across = miss.dot(end.left());
    if (std::abs(along) < close_mm && std::abs(across) < close_mm) {
      if (std::abs(miss.dot(end.normal)) > 10 * close_mm) return std::nullopt;  // another sheet
      return PointWay{d + along, leaves(tracer, tracer.start(from.at, direction, from.normal_sign), d)};
    }
    const double turn = std::clamp(across / divisor(g.y, 0.1 * d), -0.5, 0.5);
    direction = (std::cos(turn) * direction + std::sin(turn) * n.cross(direction)).normalized();
    d += std::clamp(along, -0.5 * d, 0.5 * d);
    if (d > 3 * distance_mm) return std::nullopt;
  }
  return std::nullopt;
}

Way way_by_search(const GeodesicTracer& tracer, const CourseLine& line, double t, double reach, const Vec3& p,
                  double distance_mm) {
  const double first = line.t.front(), last = line.t.back(), turn = last - first;
  const auto foot_at = [&](double at) {
    return frame_at(tracer.skin(), line.curve, line.closed() ? at - turn * std::floor((at - first) / turn) : at);
  };
  const auto distance = [&](double at) {
    const auto way = way_from_point(tracer, foot_at(at), p, distance_mm);
    return way ? way->distance_mm : std::numeric_limits<double>::infinity();
  };
  const double lo = line.closed() ? t - reach : std::max(first, t - reach);
  const double hi = line.closed() ? t + reach : std::min(last, t + reach);
  // Golden section. The distance is flat at its least: an error of t counts by its square.
  constexpr double golden = 0.6180339887498949;
  double a = lo, b = hi, x = b - golden * (b - a), y = a + golden * (b - a);
  double at_x = distance(x), at_y = distance(y);
  while (b - a > 1e-4 * (hi - lo)) {
    if (at_x <= at_y) {
      b = y;
      y = x;
      at_y = at_x;
      x = b - golden * (b - a);
      at_x = distance(x);
    } else {
      a = x;
      x = y;
      at_x = at_y;
      y = a + golden * (b - a);
      at_y = distance(y);
    }
  }
  Way out;
  out.t = at_x <= at_y ? x : y;
  out.distance_mm = std::min(at_x, at_y);
  const CurveFrame foot = foot_at(out.t);
  out.side = (p - foot.frame.position).dot(foot.frame.left()) >= 0 ? 1 : -1;
  if (std::isfinite(out.distance_mm) && a > lo && b < hi) out.end = Way::End::foot;
  return out;
}

bool leaves_skin(const GeodesicTracer& tracer, const CourseLine& line, const Way& way) {
  if (line.off_skin) return true;
  return leaves(tracer, leave(tracer, line, frame_at(tracer.skin(), line.curve, way.t), way.side), way.distance_mm);
}

double arc_of(double chord_mm, double cosine_of_normals) {
  const double half = 0.5 * std::acos(std::clamp(cosine_of_normals, -1.0, 1.0));
  return half < 1e-6 ? chord_mm : chord_mm * half / std::sin(half);
}

}  // namespace afptraj
