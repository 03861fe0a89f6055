#include "geometry/geodesic.h"

#include <algorithm>
#include <cmath>

#include "geometry/curvature.h"
#include "geometry/dormand_prince.h"

namespace afptraj {
namespace {

using State = std::array<double, 6>;  // u, v, u', v', y, y'

State pack(const GeodesicState& g) { return {g.at.uv.x(), g.at.uv.y(), g.duv.x(), g.duv.y(), g.y, g.dy}; }
void unpack(const State& x, GeodesicState& g) {
  g.at.uv = Uv(x[0], x[1]);
  g.duv = Uv(x[2], x[3]);
  g.y = x[4];
  g.dy = x[5];
}

/// The right-hand side: acceleration normal to the surface, and the Jacobi equation.
State slope(const SurfaceDerivatives& d, const State& x) {
  const Vec3 a = x[2] * x[2] * d.Suu + 2 * x[2] * x[3] * d.Suv + x[3] * x[3] * d.Svv;
  const Vec3 n = d.Su.cross(d.Sv);
  const double E = d.Su.dot(d.Su), F = d.Su.dot(d.Sv), G = d.Sv.dot(d.Sv), det = E * G - F * F;
  const double p = a.dot(d.Su), q = a.dot(d.Sv), r = 1 / det;
  const double g = n.squaredNorm();  // det, but with less cancellation
  const double L = d.Suu.dot(n), M = d.Suv.dot(n), N = d.Svv.dot(n);
  const double curvature = g > 0 ? (L * N - M * M) / (g * g) : 0;
  return {x[2], x[3], (F * q - G * p) * r, (F * p - E * q) * r, x[5], -curvature * x[4]};
}

State slope(const Surface& surface, const Span& span, const State& x) {
  return slope(surface.derivatives(span, Uv(x[0], x[1])), x);
}

/// The least s > 0 with velocity s + acceleration s^2 / 2 = way (way and velocity of one sign).
double time_to(double way, double velocity, double acceleration) {
  const double under = velocity * velocity + 2 * acceleration * way;
  if (!(way * velocity > 0) || under < 0) return std::numeric_limits<double>::infinity();
  return 2 * way / (velocity + std::copysign(std::sqrt(under), velocity));
}

double eighth_root(double x) { return std::sqrt(std::sqrt(std::sqrt(x))); }

/// The jump of y' on crossing an edge: the curvature of a fold is concentrated on it, with weight
/// k_A + k_B per length, the geodesic curvatures of the edge toward either side (Gauss-Bonnet). With
/// the edge's curvature vector c and the conormals that is c . (into - out); zero where tangent planes agree.
double fold_jump(double y, const Vec3& curvature, const Vec3& out, const Vec3& into, const Vec3& tangent) {
  const double across = std::abs(tangent.dot(out));
  return across > 1e-6 ? -y * curvature.dot(into - out) / across : 0;
}

/// Curvature vector of a curve from its first two derivatives.
Vec3 curvature_vector(const Vec3& d1, const Vec3& d2) {
  const double speed2 = d1.squaredNorm();
  return speed2 > 0 ? Vec3((d2 - d2.dot(d1) / speed2 * d1) / speed2) : Vec3(Vec3::Zero());
}

void renormalise(GeodesicState& g, const SurfaceDerivatives& d) {
  const double speed = uv_to_tangent(d, g.duv).norm();
  if (speed > 0) g.duv /= speed;
}

}  // namespace

Vec3 turn_across(const Vec3& tangent, const Vec3& edge, const Vec3& n_from, const Vec3& n_to) {
  return tangent.dot(edge) * edge + tangent.dot(n_from.cross(edge)) * n_to.cross(edge);
}

PathFrame frame_of(const Skin& skin, const GeodesicState& state) {
  const SurfaceDerivatives d = skin.derivatives(state.at);
  const double sign = skin.face(state.at.face).reversed ? -state.normal_sign : state.normal_sign;
  return {d.S, uv_to_tangent(d, state.duv).normalized(), sign * unit_normal(d)};
}

GeodesicTracer::GeodesicTracer(const Skin& skin, const GeodesicOptions& options) : skin_(&skin), options_(options) {
  poles_.resize(skin.part().faces.size());
  for (const Pole& pole : poles_of(skin))
    for (int face : pole.faces) poles_[static_cast<std::size_t>(face)].push_back(pole);
  // Within this radius the skin is flat to 1e-12 of its size: a hop over the pole is exact enough.
  pole_radius_mm_ = 1e-6 * std::min(1.0, skin.diagonal() / 100);
  lever_mm_ = 0.02 * skin.diagonal();
}

GeodesicState GeodesicTracer::start(const SurfacePoint& at, const Vec3& direction, int normal_sign, double y,
                                    double dy, bool outside) const {
  GeodesicState g;
  g.at = at;
  g.normal_sign = normal_sign;
  g.y = y;
  g.dy = dy;
  g.outside = outside;
  const SurfaceDerivatives d = skin_->derivatives(at);
  g.duv = tangent_to_uv(d, direction);
  renormalise(g, d);
  return g;
}

struct GeodesicTracer::Here {
  SurfaceDerivatives d;
  State slope;
};

GeodesicTracer::Here GeodesicTracer::look(const GeodesicState& g, const Span& span) const {
  Here here;
  here.d = skin_->face(g.at.face).surface.derivatives(span, g.at.uv);
  here.slope = slope(here.d, pack(g));
  return here;
}

/// One step of the piece's own polynomial; `error` is the estimate over the tolerance.
bool GeodesicTracer::integrate(GeodesicState& g, const Here& here, const Span& span, double h, double* error) const {
  const Surface& surface = skin_->face(g.at.face).surface;
  State e5, e3;
  const auto f = [&](const State& at) { return slope(surface, span, at); };
  const State x = dop853::step(pack(g), here.slope, h, f, error ? &e5 : nullptr, error ? &e3 : nullptr);
  for (double value : x)
    if (!std::isfinite(value)) return false;
  if (error) {
    // An error in direction acts over the rest of the way: short steps (near a pole) get no discount.
    const double lever = std::max(std::abs(h), lever_mm_);
    const auto size = [&](const State& e) {
      const double position = uv_to_tangent(here.d, Uv(e[0], e[1])).norm();
      const double direction = uv_to_tangent(here.d, Uv(e[2], e[3])).norm() * lever;
      return std::abs(h) * std::max({position, direction, std::abs(e[4]), std::abs(e[5]) * lever});
    };
    const double of5 = size(e5), of3 = size(e3);
    *error = of5 > 0 ? of5 * of5 / std::sqrt(of5 * of5 + 0.01 * of3 * of3) / options_.tolerance_mm : of5;
    if (!std::isfinite(*error)) return false;
  }
  unpack(x, g);
  g.s_mm += h;
  return true;
}

/// Moves a state by a small correction, at the least cost that is exact beside a step of length `scale`.
bool GeodesicTracer::shift(GeodesicState& g, const Here& here, const Span& span, double by, double scale) const {
  if (std::abs(by) > 0.01 * scale) return integrate(g, here, span, by, nullptr);
  const Surface& surface = skin_->face(g.at.face).surface;
  const auto f = [&](const State& at) { return slope(surface, span, at); };
  const State x = std::abs(by) < 1e-8 ? dop853::tiny_step(pack(g), here.slope, by)
                                      : dop853::short_step(pack(g), here.slope, by, f);
  for (double value : x)
    if (!std::isfinite(value)) return false;
  unpack(x, g);
  g.s_mm += by;
  return true;
}

/// The side of the piece's box that the state is on its way to, by its acceleration: the length to it.
double GeodesicTracer::way_to_box(const GeodesicState& g, const Here& here, const Uv& lo, const Uv& hi) const {
  double first = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 2; ++k) {
    const double side = g.duv[k] > 0 ? hi[k] : lo[k];
    if (!std::isfinite(side)) continue;
    first = std::min(first, time_to(side - g.at.uv[k], g.duv[k], here.slope[static_cast<std::size_t>(k) + 2]));
  }
  return first;
}

/// Lengthens or shortens a step that ended near a side of the piece's box or beyond it so that it ends on that side.
void GeodesicTracer::land_on_box(GeodesicState& state, const GeodesicState& from, const Here& start, const Span& span,
                                 double longest, double& h) const {
  Uv lo, hi;
  skin_->face(from.at.face).surface.span_box(span, lo, hi);
  const auto beyond = [&](const Uv& p, int axis) {
    return p[axis] < lo[axis] ? lo[axis] - p[axis] : p[axis] > hi[axis] ? p[axis] - hi[axis] : 0.0;
  };
  const auto settle = [&](GeodesicState& g, int axis, double side, double& length) {
    for (int i = 0; i < 5; ++i) {
      const double miss = side - g.at.uv[axis];
      if (std::abs(miss) <= 4e-16 * std::max(1.0, std::abs(side)) || g.duv[axis] == 0) break;
      const Here here = look(g, span);
      double correction = miss / g.duv[axis];
      const double turn = here.slope[static_cast<std::size_t>(axis) + 2] * correction / g.duv[axis];
      if (std::abs(turn) < 0.1) correction *= 1 - 0.5 * turn;
      if (!(std::abs(correction) < std::abs(length) + 1e-9) || !shift(g, here, span, correction, h)) break;
      length += correction;
    }
    g.at.uv[axis] = side;
  };
  if (beyond(state.at.uv, 0) <= 0 && beyond(state.at.uv, 1) <= 0) {
    // Just short of the side: the rest belongs to this step.
    for (int k = 0; k < 2; ++k) {
      const double side = state.duv[k] > 0 ? hi[k] : lo[k];
      const double rest = (side - state.at.uv[k]) / state.duv[k];
      if (!(rest > 0 && rest < 0.02 * h && h + 2 * rest < longest)) continue;
      GeodesicState landed = state;
      double length = h;
      settle(landed, k, side, length);
      if (!landed.at.uv.allFinite() || beyond(landed.at.uv, 1 - k) > 0) continue;
      state = landed;
      h = length;
      return;
    }
    return;
  }
  // First side met by the cubic through both ends.
  const UvCubic path = UvCubic::hermite(from.at.uv, h * from.duv, state.at.uv, h * state.duv);
  double first = 1;
  int axis = -1;
  double side = 0;
  for (int k = 0; k < 2; ++k) {
    if (beyond(state.at.uv, k) <= 0) continue;
    const double bound = state.at.uv[k] > hi[k] ? hi[k] : lo[k];
    double a = 0, b = 1;
    const double sign = state.at.uv[k] > hi[k] ? 1 : -1;
    for (int i = 0; i < 20; ++i) {
      const double m = 0.5 * (a + b);
      (sign * (path.point(m)[k] - bound) > 0 ? b : a) = m;
    }
    if (axis < 0 || b < first) {
      first = b;
      axis = k;
      side = bound;
    }
  }
  double length = h;
  if (first < 0.99) {
    length = h * first;
    state = from;
    integrate(state, start, span, length, nullptr);
  }
  settle(state, axis, side, length);
  h = length;
}

/// On a knot line: takes the next piece and carries the tangent over.
bool GeodesicTracer::cross_knot(GeodesicState& state, Span& span) const {
  const Surface& surface = skin_->face(state.at.face).surface;
  const Span next = surface.span_at(state.at.uv, state.duv);
  if (next == span) return true;
  const SurfaceDerivatives a = surface.derivatives(span, state.at.uv);
  const SurfaceDerivatives b = surface.derivatives(next, state.at.uv);
  const Vec3 na = unit_normal(a), nb = unit_normal(b);
  Vec3 t = uv_to_tangent(a, state.duv);
  if (na.dot(nb) < 1 - 1e-14) {
    const bool across_u = next.iu != span.iu;
    const Vec3 edge = (across_u ? a.Sv : a.Su).normalized();
    const Vec3 curvature = across_u ? curvature_vector(a.Sv, a.Svv) : curvature_vector(a.Su, a.Suu);
    const double sense = t.dot(na.cross(edge)) >= 0 ? 1 : -1;
    state.dy += fold_jump(state.y, curvature, sense * na.cross(edge), sense * nb.cross(edge), t);
    t = turn_across(t, edge, na, nb);
  }
  state.duv = tangent_to_uv(b, t);
  renormalise(state, b);
  span = next;
  return state.duv.allFinite();
}

/// Carries a state that stands on an edge into the face on the other side.
GeodesicTracer::Crossing GeodesicTracer::enter_mate(GeodesicState& state, const EdgeUse& use, double t) const {
  const EdgeUse other = *skin_->mate(use);
  const Face& from = skin_->face(use.face);
  const Face& to = skin_->face(other.face);
  const SurfaceDerivatives a = from.surface.derivatives(state.at.uv);
  const Coedge& out = skin_->coedge(use);
  const Coedge& in = skin_->coedge(other);
  const Uv uv = skin_->across(use, t, a.S).uv;
  const SurfaceDerivatives b = to.surface.derivatives(uv);
  const Vec3 na = unit_normal(a), nb = unit_normal(b);
  if (na.isZero() || nb.isZero()) return Crossing::singular;
  // Unit edge tangent in the sense of the loop on this side, and the conormals that point out of
  // this face and into the next: left of each loop lies its material.
  const auto c = out.pcurve.derivatives(t);
  const Uv c1 = c.d1 * (out.reversed ? -1 : 1);
  const Vec3 edge = uv_to_tangent(a, c1).normalized();
  const Vec3 outward = edge.cross(na);
  const Uv c2 = in.pcurve.derivatives(std::clamp(t, in.pcurve.first(), in.pcurve.last())).d1 * (in.reversed ? -1 : 1);
  const Vec3 other_edge = uv_to_tangent(b, c2).normalized();
  Vec3 inward = nb.cross(other_edge);
  inward = (inward - inward.dot(edge) * edge).normalized();
  const Vec3 tangent = uv_to_tangent(a, state.duv);
  const Vec3 velocity = uv_to_tangent(a, c.d1);
  const Vec3 acceleration = uv_to_tangent(a, c.d2) + c.d1.x() * c.d1.x() * a.Suu + 2 * c.d1.x() * c.d1.y() * a.Suv +
                            c.d1.y() * c.d1.y() * a.Svv;
  state.dy += fold_jump(state.y, curvature_vector(velocity, acceleration), outward, inward, tangent);
  const Vec3 turned = tangent.dot(edge) * edge + tangent.dot(outward) * inward;
  // (edge, outward, na) is right-handed; the normal goes over with the same handedness.
  const bool kept = edge.cross(inward).dot(nb) * edge.cross(outward).dot(na) > 0;
  const int sign_from = from.reversed ? -state.normal_sign : state.normal_sign;
  const int sign_to = kept ? sign_from : -sign_from;
  state.normal_sign = to.reversed ? -sign_to : sign_to;
  state.at = {other.face, uv};
  state.duv = tangent_to_uv(b, turned);
  renormalise(state, b);
  return state.duv.allFinite() ? Crossing::moved : Crossing::singular;
}

/// Outside of a face whose loops span a period, (u, v) is kept in the window of the loops.
void GeodesicTracer::wrap_outside(GeodesicState& state, Span& span) const {
  const Surface& surface = skin_->face(state.at.face).surface;
  const TrimRegion& trim = skin_->trim(state.at.face);
  const double period[2] = {surface.period_u(), surface.period_v()};
  for (int k = 0; k < 2; ++k) {
    if (period[k] <= 0) continue;
    const double lo = trim.box_min()[k], hi = trim.box_max()[k];
    if (hi - lo < period[k] * (1 - 1e-9)) continue;
    const double shift = period[k] * std::floor((state.at.uv[k] - lo) / period[k]);
    state.at.uv[k] -= shift;
    (k == 0 ? span.shift_u : span.shift_v) -= shift;  // the same piece, one period back
  }
}

bool GeodesicTracer::beside_hole(const GeodesicState& state) const {
  const Eigen::Matrix2d metric = first_form(skin_->derivatives(state.at)).matrix();
  return skin_->is_hole(state.at.face, skin_->trim(state.at.face).nearest(state.at.uv, metric).loop);
}

/// Finds the face that really holds a state that should lie inside its face but does not.
bool GeodesicTracer::relocate(GeodesicState& state) const {
  const PathFrame frame = frame_of(*skin_, state);
  const double reach = 1e-5 * std::max(1.0, skin_->diagonal() / 1000);
  const auto found = skin_->closest_point().closest(frame.position, reach);
  if (!found) return false;
  const Vec3 n = skin_->normal(found->at);
  if (n.isZero()) return false;
  const int sign = n.dot(frame.normal) >= 0 ? 1 : -1;  // skin_->normal is already turned by the face
  GeodesicState moved = start(found->at, frame.tangent, sign, state.y, state.dy);
  if (!moved.duv.allFinite()) return false;
  moved.s_mm = state.s_mm;
  moved.step_mm = state.step_mm;
  state = moved;
  return true;
}

GeodesicTracer::Crossing GeodesicTracer::cross_loops(GeodesicState& state, const GeodesicState& from,
                                                     const Here& start, Span& span, double& h) const {
  const int face = from.at.face;
  const TrimRegion& trim = skin_->trim(face);
  const UvCubic path = UvCubic::hermite(from.at.uv, h * from.duv, state.at.uv, h * state.duv);
  const auto hit = trim.first_crossing(path, !from.outside);
  if (!hit) return Crossing::none;
  const EdgeUse use{face, hit->loop, hit->coedge};
  if (skin_->edge(use).degenerate) return Crossing::none;  // the pole is hopped over before it is reached
  // Walk again, to the crossing, and polish it: path(s) = pcurve(t).
  const Coedge& coedge = skin_->coedge(use);
  GeodesicState at = from;
  const double whole = h;
  h *= hit->x;
  if (!shift(at, start, span, h, whole)) return Crossing::singular;
  double t = hit->t;
  for (int i = 0; i < 5; ++i) {
    const auto c = coedge.pcurve.derivatives(t);
    Eigen::Matrix2d J;
    J << at.duv, -c.d1;
    const Uv r = c.c - at.at.uv;
    const Eigen::Vector2d step = J.partialPivLu().solve(r);
    if (!step.allFinite() || std::abs(step.x()) > 1 + 0.5 * std::abs(h)) break;
    t = std::clamp(t + step.y(), coedge.pcurve.first(), coedge.pcurve.last());
    if (!shift(at, look(at, span), span, step.x(), whole)) return Crossing::singular;
    h += step.x();
    if (std::abs(step.x()) < 1e-12) break;
  }
  state = at;
  if (from.outside) {
    if (skin_->mate(use) && !skin_->is_seam(use)) return Crossing::left;
    state.outside = state.in_hole = false;
    state.outside_mm = 0;
    return Crossing::moved;
  }
  if (skin_->mate(use)) {
    const Crossing entered = enter_mate(state, use, t);
    if (entered == Crossing::moved) {
      span = skin_->face(state.at.face).surface.span_at(state.at.uv, state.duv);
    }
    return entered;
  }
  state.outside = true;
  state.outside_mm = 0;
  state.in_hole = skin_->is_hole(face, hit->loop);
  return Crossing::moved;
}

/// How long a path may run outside before it counts as having left. Exact, so that every path to a place is judged
/// alike, whatever its steps; but for a start on an edge or a period away, which a first step finds inside.
double GeodesicTracer::longest_outside(const GeodesicState& state, const Span& span) const {
  const Surface& surface = skin_->face(state.at.face).surface;
  // Farther round a part that is open there the continuation would come upon the other rim.
  const TrimRegion& trim = skin_->trim(state.at.face);
  const double period[2] = {surface.period_u(), surface.period_v()};
  for (int k = 0; k < 2; ++k) {
    const double missing = period[k] - (trim.box_max()[k] - trim.box_min()[k]);
    const double past = std::max(trim.box_min()[k] - state.at.uv[k], state.at.uv[k] - trim.box_max()[k]);
    if (missing > 1e-9 * period[k] && past > 0.5 * missing) return false;
  }
  const bool continued = span.iu < 0 || span.iv < 0 ||
                         span.iu >= static_cast<int>(std::max<std::size_t>(surface.breaks_u().size(), 2)) - 1 ||
                         span.iv >= static_cast<int>(std::max<std::size_t>(surface.breaks_v().size(), 2)) - 1;
  const bool alone = skin_->faces().size() == 1;
  const double limit = continued || (!alone && !state.in_hole)
                           ? options_.margin_mm
                           : std::max(options_.margin_mm, state.in_hole ? skin_->diagonal() : options_.outside_limit_mm);
  return limit + 1e-6;
}

const Pole* GeodesicTracer::approached_pole(const GeodesicState& state, const SurfaceDerivatives& d,
                                                            double& distance, double& miss) const {
  const Pole* nearest = nullptr;
  distance = std::numeric_limits<double>::infinity();
  const Vec3 t = uv_to_tangent(d, state.duv);
  for (const Pole& pole : poles_[static_cast<std::size_t>(state.at.face)]) {
    const Vec3 to = pole.point - d.S;
    const double along = to.dot(t);
    if (along <= 0 || to.norm() >= distance) continue;
    nearest = &pole;
    distance = to.norm();
    miss = std::sqrt(std::max(0.0, to.squaredNorm() - along * along));
  }
  return nearest;
}

/// Crosses a smooth pole along the straight line in space: within the pole radius the skin is flat.
GeodesicTracer::Crossing GeodesicTracer::hop_pole(GeodesicState& state, const Pole& pole, double& walked) const {
  if (!pole.smooth) return Crossing::singular;
  const PathFrame frame = frame_of(*skin_, state);
  walked = 2 * std::max((pole.point - frame.position).dot(frame.tangent), 0.5 * pole_radius_mm_);
  const Vec3 target = frame.position + walked * frame.tangent;
  const auto found = skin_->closest_point().closest(target, 10 * pole_radius_mm_, nullptr);
  if (!found) return Crossing::left;
  const Vec3 n = skin_->normal(found->at);
  if (n.isZero()) return Crossing::singular;
  GeodesicState moved =
      start(found->at, frame.tangent, n.dot(frame.normal) >= 0 ? 1 : -1, state.y + walked * state.dy, state.dy);
  if (!moved.duv.allFinite()) return Crossing::singular;
  moved.s_mm = state.s_mm + walked;
  moved.step_mm = pole_radius_mm_;
  state = moved;
  return Crossing::moved;
}

/// Carries a state outside over the period. A step may end on the loop exactly (where it is a knot line too): that
/// is back inside.
void GeodesicTracer::settle_outside(GeodesicState& state, Span& span) const {
  wrap_outside(state, span);
  if (!skin_->trim(state.at.face).contains(state.at.uv)) return;
  state.outside = state.in_hole = false;
  state.outside_mm = 0;
}

TraceEnd GeodesicTracer::advance(GeodesicState& state, double length) const {
  double remaining = length;
  double h = state.step_mm > 0 ? state.step_mm : std::min(length, 0.02 * skin_->diagonal());
  Span span = skin_->face(state.at.face).surface.span_at(state.at.uv, state.duv);
  const double longest = 0.1 * skin_->diagonal();
  const double least = 1e-13 * skin_->diagonal();
  // A start on the boundary may lead off the skin across nothing.
  bool verify = state.s_mm == 0 && !state.outside;
  int idle = 0;
  Here here;
  bool looked = false;
  while (remaining > least) {
    if (!looked) here = look(state, span);
    looked = false;
    double step = std::min({h, remaining, longest});
    double room = remaining;  // how far it may go before it has left
    if (state.outside) {
      room = std::min(room, longest_outside(state, span) - state.outside_mm);
      if (room <= least) return TraceEnd::left;
      step = std::min({step, room, std::max(1.0, 0.02 * skin_->diagonal())});
    }
    if (!poles_[static_cast<std::size_t>(state.at.face)].empty() && !state.outside) {
      double distance = 0, miss = 0;
      if (const Pole* pole = approached_pole(state, here.d, distance, miss)) {
        if (distance <= 2 * pole_radius_mm_) {
          double walked = 0;
          const Crossing hop = hop_pole(state, *pole, walked);
          if (hop == Crossing::left) return TraceEnd::left;
          if (hop == Crossing::singular) return TraceEnd::singular;
          remaining -= walked;
          span = skin_->face(state.at.face).surface.span_at(state.at.uv, state.duv);
          continue;
        }
        step = std::min(step, std::max(0.5 * distance, distance - 0.5 * pole_radius_mm_ - distance * 0.02));
        step = std::min(step, std::max(distance - pole_radius_mm_, 0.5 * pole_radius_mm_));
      }
    }
    Uv lo, hi;
    skin_->face(state.at.face).surface.span_box(span, lo, hi);
    if (const double exit = way_to_box(state, here, lo, hi); exit > least) step = std::min(step, exit);
    const GeodesicState from = state;
    double error = 0;
    if (!integrate(state, here, span, step, &error) || error > 1) {
      state = from;
      looked = true;
      h = step * (std::isfinite(error) && error > 1 ? std::clamp(0.9 / eighth_root(error), 0.1, 0.9) : 0.1);
      if (h < 1e-12 * skin_->diagonal()) return TraceEnd::singular;
      continue;
    }
    const double grown = step * std::clamp(0.9 / eighth_root(std::max(error, 1e-10)), 0.5, 5.0);
    double taken = step;
    land_on_box(state, from, here, span, std::min(room, 2 * step), taken);
    const Crossing crossing = cross_loops(state, from, here, span, taken);
    remaining -= taken;
    if (crossing == Crossing::left) return TraceEnd::left;
    if (crossing == Crossing::singular) return TraceEnd::singular;
    // A step cut short by a knot or an edge says nothing about the next one's length.
    h = step < h || taken < step ? std::max(grown, h) : grown;
    state.step_mm = h;
    if (crossing == Crossing::moved) {
      verify = !state.outside;
      idle = taken < 1e-9 ? idle + 1 : 0;
      if (idle > 20) return TraceEnd::singular;
      continue;
    }
    if (verify) {
      verify = false;
      if (!skin_->trim(state.at.face).contains(state.at.uv)) {
        if (!relocate(state)) {
          state.outside = true;
          state.outside_mm = 0;
          state.in_hole = beside_hole(state);
        }
        span = skin_->face(state.at.face).surface.span_at(state.at.uv, state.duv);
      }
    }
    if (state.outside) {
      state.outside_mm += taken;
      settle_outside(state, span);
    }
    if (!cross_knot(state, span)) return TraceEnd::singular;
    idle = taken < 1e-9 && remaining > 1e-9 ? idle + 1 : 0;
    if (idle > 50) return TraceEnd::singular;
  }
  return TraceEnd::reached;
}

}  // namespace afptraj
