#include "trajectory/source_curve.h"

#include <algorithm>
#include <cmath>

#include "geometry/curvature.h"

namespace afptraj {

GeodesicChart::Place PathChart::place(const Skin& skin, const Uv& at, const Uv& inward) const {
  if (about) return about->place(at);
  GeodesicChart::Place out;
  out.at = {face, at};
  out.normal_sign = normal_sign;
  const Surface& surface = skin.face(face).surface;
  // A place on a crease stands off it by rounding.
  out.d = surface.derivatives(surface.span_at(at + 1e-9 * inward, inward), at);
  out.normal = (skin.face(face).reversed ? -normal_sign : normal_sign) * unit_normal(out.d);
  return out;
}

SplinePath::SplinePath(const Skin& skin, std::vector<Piece> pieces, bool closed)
    : skin_(&skin), pieces_(std::move(pieces)), closed_(closed) {}

SourceCurve::Frame SplinePath::at(double t) const {
  const Piece* piece = &pieces_.front();
  for (const Piece& candidate : pieces_) {
    piece = &candidate;
    if (t <= candidate.curve.last()) break;
  }
  const auto c = piece->curve.derivatives(std::clamp(t, piece->curve.first(), piece->curve.last()));
  const bool in_first_half = t - piece->curve.first() < piece->curve.last() - t;
  const GeodesicChart::Place place = piece->chart.place(*skin_, c.c, in_first_half ? c.d1 : Uv(-c.d1));
  const Vec3 velocity = uv_to_tangent(place.d, c.d1);
  Frame out;
  out.at = place.at;
  out.normal_sign = place.normal_sign;
  out.speed = velocity.norm();
  out.frame = {place.d.S, velocity / out.speed, place.normal};
  out.kg_per_mm = geodesic_curvature(place.d, place.normal, c.d1, c.d2);
  // The stepped path ends at outer boundaries: where the spline is off the skin, it spans a hole.
  out.outside = out.in_hole = !skin_->trim(out.at.face).contains(out.at.uv);
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

SourceCurve::Frame LaidPath::at(double t) const {
  Frame out;
  static_cast<CurveFrame&>(out) = frame_at(*skin_, curve_, t);
  out.outside = !skin_->trim(out.at.face).contains(out.at.uv);
  return out;
}

}  // namespace afptraj
