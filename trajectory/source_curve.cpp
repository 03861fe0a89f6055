#include "trajectory/source_curve.h"

#include <algorithm>
#include <cmath>

#include "geometry/curvature.h"

namespace afptraj {

SplinePath::SplinePath(const Skin& skin, std::vector<Piece> pieces, bool closed)
    : skin_(&skin), pieces_(std::move(pieces)), closed_(closed) {}

SourceCurve::Frame SplinePath::at(double t) const {
  const Piece* piece = &pieces_.front();
  for (const Piece& candidate : pieces_) {
    piece = &candidate;
    if (t <= candidate.curve.last()) break;
  }
  const auto c = piece->curve.derivatives(std::clamp(t, piece->curve.first(), piece->curve.last()));
  Frame out;
  out.at = {piece->face, c.c};
  const SurfaceDerivatives d = skin_->derivatives(out.at);
  const double sign = skin_->face(piece->face).reversed ? -piece->normal_sign : piece->normal_sign;
  const Vec3 normal = sign * unit_normal(d);
  const Vec3 velocity = uv_to_tangent(d, c.d1);
  out.speed = velocity.norm();
  out.frame = {d.S, velocity / out.speed, normal};
  out.normal_sign = piece->normal_sign;
  out.kg_per_mm = geodesic_curvature(d, normal, c.d1, c.d2);
  // The stepped path ends at outer boundaries: where the spline is off the skin, it spans a hole.
  out.outside = out.in_hole = !skin_->trim(piece->face).contains(c.c);
  return out;
}

GeodesicPath::GeodesicPath(const GeodesicTracer& tracer, std::vector<GeodesicState> states, bool backward)
    : tracer_(&tracer), states_(std::move(states)), backward_(backward) {}

double GeodesicPath::first() const { return backward_ ? -states_.back().s_mm : states_.front().s_mm; }
double GeodesicPath::last() const { return backward_ ? -states_.front().s_mm : states_.back().s_mm; }

SourceCurve::Frame GeodesicPath::at(double t) const {
  const double s = std::clamp(backward_ ? -t : t, states_.front().s_mm, states_.back().s_mm);
  auto it = std::upper_bound(states_.begin(), states_.end(), s,
                             [](double value, const GeodesicState& g) { return value < g.s_mm; });
  GeodesicState g = it == states_.begin() ? *it : *(it - 1);
  if (s > g.s_mm) tracer_->advance(g, s - g.s_mm);
  Frame out;
  out.at = g.at;
  out.frame = frame_of(tracer_->skin(), g);
  if (backward_) out.frame.tangent = -out.frame.tangent;
  out.normal_sign = g.normal_sign;
  out.speed = 1;
  out.kg_per_mm = 0;
  out.outside = g.outside;
  out.in_hole = g.in_hole;
  return out;
}

}  // namespace afptraj
