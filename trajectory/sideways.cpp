#include "trajectory/sideways.h"

#include <algorithm>
#include <cmath>

namespace afptraj {

GeodesicTracer sideways_tracer(const Skin& skin, double reach_mm) {
  GeodesicOptions options;
  options.margin_mm = reach_mm;
  options.outside_limit_mm = reach_mm;
  return GeodesicTracer(skin, options);
}

bool move_sideways(const GeodesicTracer& tracer, SteppedPoint& p, double w_mm) {
  const Skin& skin = tracer.skin();
  const Vec3 n = p.normal_sign * skin.normal(p.at);
  const bool outside = !skin.trim(p.at.face).contains(p.at.uv);
  GeodesicState g = tracer.start(p.at, std::copysign(1.0, w_mm) * n.cross(p.direction), p.normal_sign, 1, 0, outside);
  g.in_hole = outside;
  if (tracer.advance(g, std::abs(w_mm)) != TraceEnd::reached) return false;
  p.at = g.at;
  p.normal_sign = g.normal_sign;
  p.position = skin.point(g.at);
  return true;
}

void renew_directions(std::vector<SteppedPoint>& points, bool closed) {
  double s = points.front().s_mm;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& before = points[i > 0 ? i - 1 : 0].position;
    const auto& after = points[std::min(i + 1, points.size() - 1)].position;
    if ((after - before).norm() > 0) points[i].direction = (after - before).normalized();
    if (i > 0) s += (points[i].position - before).norm();
    points[i].s_mm = s;
  }
  if (closed)
    points.front().direction = points.back().direction =
        (points[1].position - points[points.size() - 2].position).normalized();
}

}  // namespace afptraj
