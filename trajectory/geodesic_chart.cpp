#include "trajectory/geodesic_chart.h"

#include <algorithm>
#include <cmath>

#include "trajectory/source_curve.h"

namespace afptraj {
namespace {

/// The states of a geodesic every 2 mm over `length`, fewer where it ends sooner.
std::vector<GeodesicState> walk_states(const GeodesicTracer& tracer, GeodesicState g, double length) {
  std::vector<GeodesicState> out = {g};
  const int count = std::max(1, static_cast<int>(std::ceil(length / 2)));
  for (int i = 0; i < count && tracer.advance(g, length / count) == TraceEnd::reached; ++i) out.push_back(g);
  return out;
}

}  // namespace

GeodesicChart::GeodesicChart(const Skin& skin, const SurfacePoint& at, const Vec3& direction, int normal_sign,
                             double back_mm, double ahead_mm, const GeodesicOptions& options)
    : tracer_(std::make_shared<const GeodesicTracer>(skin, options)) {
  std::vector<GeodesicState> back =
      walk_states(*tracer_, tracer_->start(at, -direction, normal_sign), back_mm);
  std::vector<GeodesicState> states =
      walk_states(*tracer_, tracer_->start(at, direction, normal_sign), ahead_mm);
  origin_mm_ = back.back().s_mm;
  for (GeodesicState& g : states) g.s_mm += origin_mm_;
  for (GeodesicState& g : back) {  // turned round: the same geodesic in the sense of the rest
    g.duv = -g.duv;
    g.s_mm = origin_mm_ - g.s_mm;
  }
  states.insert(states.begin(), back.rbegin(), back.rend() - 1);
  base_ = std::make_shared<const GeodesicPath>(*tracer_, std::move(states), false);
}

double GeodesicChart::length_mm() const { return base_->last(); }

GeodesicState GeodesicChart::walk(const Uv& sw) const {
  const SourceCurve::Frame foot = base_->at(sw.x());
  const double side = sw.y() < 0 ? -1 : 1;
  GeodesicState g = tracer_->start(foot.at, side * foot.frame.left(), foot.normal_sign, 1, 0, foot.outside);
  g.in_hole = foot.in_hole;
  tracer_->advance(g, std::abs(sw.y()));
  return g;
}

GeodesicChart::Place GeodesicChart::place(const Uv& sw) const {
  const GeodesicState g = walk(sw);
  const PathFrame end = frame_of(tracer_->skin(), g);
  const double side = sw.y() < 0 ? -1 : 1;
  const Vec3 across = side * end.tangent, along = across.cross(end.normal);
  constexpr double reach_mm = 0.25;  // y is flat along s: its difference over this is off by reach^2
  const double s0 = std::max(sw.x() - reach_mm, 0.0), s1 = std::min(sw.x() + reach_mm, length_mm());
  const double y_w = side * g.dy;
  const double y_s = s1 > s0 ? (walk(Uv(s1, sw.y())).y - walk(Uv(s0, sw.y())).y) / (s1 - s0) : 0;
  Place out;
  out.at = g.at;
  out.normal_sign = g.normal_sign;
  out.normal = end.normal;
  // From the metric; lines of constant s are geodesics.
  out.d = {end.position, g.y * along, across, y_s * along - g.y * y_w * across, y_w * along, Vec3::Zero()};
  return out;
}

std::optional<Uv> GeodesicChart::coordinates(const Vec3& p, const Uv& seed) const {
  Uv sw = seed;
  for (int i = 0; i < 20; ++i) {
    const SurfaceDerivatives d = place(sw).d;
    const double y2 = d.Su.squaredNorm();
    if (!(y2 > 0.25 && y2 < 4)) return std::nullopt;
    const Vec3 miss = p - d.S;
    if (miss.norm() < 1e-7) return sw;
    sw = Uv(std::clamp(sw.x() + miss.dot(d.Su) / y2, 0.0, length_mm()), sw.y() + miss.dot(d.Sv));
  }
  return std::nullopt;
}

}  // namespace afptraj
