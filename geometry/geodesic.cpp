#include "geometry/geodesic.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/curvature.h"

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
State slope(const Surface& surface, const Span& span, const State& x) {
  const SurfaceDerivatives d = surface.derivatives(span, Uv(x[0], x[1]));
  const Vec3 a = x[2] * x[2] * d.Suu + 2 * x[2] * x[3] * d.Suv + x[3] * x[3] * d.Svv;
  const Uv acceleration = -tangent_to_uv(d, a);
  return {x[2], x[3], acceleration.x(), acceleration.y(), x[5], -gaussian_curvature(d) * x[4]};
}

// Dormand & Prince, RK5(4)7M.
constexpr double A[7][6] = {{},
                            {1. / 5},
                            {3. / 40, 9. / 40},
                            {44. / 45, -56. / 15, 32. / 9},
                            {19372. / 6561, -25360. / 2187, 64448. / 6561, -212. / 729},
                            {9017. / 3168, -355. / 33, 46732. / 5247, 49. / 176, -5103. / 18656},
                            {35. / 384, 0, 500. / 1113, 125. / 192, -2187. / 6784, 11. / 84}};
constexpr double B4[7] = {5179. / 57600, 0, 7571. / 16695, 393. / 640, -92097. / 339200, 187. / 2100, 1. / 40};

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

/// The least angle between normals on opposite sides of a pole tells a dome from a cone.
bool smooth_pole(const Face& face, const Coedge& coedge) {
  const double t0 = coedge.pcurve.first(), t1 = coedge.pcurve.last();
  const Uv a = coedge.pcurve.point(t0), b = coedge.pcurve.point(t1);
  const Uv along = b - a;
  Uv inward(-along.y(), along.x());  // left of the loop's run
  if (coedge.reversed) inward = -inward;
  const Interval du = face.surface.domain_u(), dv = face.surface.domain_v();
  const double scale = std::abs(inward.x()) > std::abs(inward.y()) ? du.length() : dv.length();
  const double reach = 1e-6 * (std::isfinite(scale) ? scale : 1.0);
  inward *= reach / inward.norm();
  Vec3 first = Vec3::Zero();
  for (int i = 0; i <= 8; ++i) {
    const Vec3 n = unit_normal(face.surface.derivatives(coedge.pcurve.point(t0 + (t1 - t0) * i / 8) + inward));
    if (i == 0) first = n;
    if (n.dot(first) < std::cos(1e-3)) return false;
  }
  return true;
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
  const auto& faces = skin.part().faces;
  poles_.resize(faces.size());
  for (int f : skin.faces()) {
    const auto index = static_cast<std::size_t>(f);
    for (const Loop& loop : faces[index].loops) {
      for (const Coedge& c : loop.coedges)
        if (skin.part().edges[static_cast<std::size_t>(c.edge)].degenerate)
          poles_[index].push_back({faces[index].surface.point(c.pcurve.point(c.pcurve.first())),
                                   smooth_pole(faces[index], c)});
    }
  }
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

/// One step of the piece's own polynomial; `error` is the estimate over the tolerance.
bool GeodesicTracer::integrate(GeodesicState& g, const Span& span, double h, double* error) const {
  const Surface& surface = skin_->face(g.at.face).surface;
  const State x0 = pack(g);
  State k[7];
  State x = x0;
  for (int stage = 0; stage < 7; ++stage) {
    if (stage > 0) {
      for (std::size_t i = 0; i < 6; ++i) {
        double sum = 0;
        for (int j = 0; j < stage; ++j) sum += A[stage][j] * k[j][i];
        x[i] = x0[i] + h * sum;
      }
    }
    k[stage] = slope(surface, span, x);
  }
  for (double value : x)
    if (!std::isfinite(value)) return false;
  if (error) {
    State e{};
    for (std::size_t i = 0; i < 6; ++i)
      for (int j = 0; j < 7; ++j) e[i] += h * ((j < 6 ? A[6][j] : 0) - B4[j]) * k[j][i];
    const SurfaceDerivatives d = surface.derivatives(span, Uv(x[0], x[1]));
    const double position = uv_to_tangent(d, Uv(e[0], e[1])).norm();
    // An error in direction acts over the rest of the way: short steps (near a pole) get no discount.
    const double lever = std::max(std::abs(h), lever_mm_);
    const double direction = uv_to_tangent(d, Uv(e[2], e[3])).norm() * lever;
    *error = std::max({position, direction, std::abs(e[4]), std::abs(e[5]) * lever}) / options_.tolerance_mm;
    if (!std::isfinite(*error)) return false;
  }
  unpack(x, g);
  g.s_mm += h;
  return true;
}

/// Shortens a step that went through a side of the piece's box so that it ends on that side.
void GeodesicTracer::land_on_box(GeodesicState& state, const GeodesicState& from, const Span& span, double& h) const {
  Uv lo, hi;
  skin_->face(from.at.face).surface.span_box(span, lo, hi);
  const auto beyond = [&](const Uv& p, int axis) {
    return p[axis] < lo[axis] ? lo[axis] - p[axis] : p[axis] > hi[axis] ? p[axis] - hi[axis] : 0.0;
  };
  if (beyond(state.at.uv, 0) <= 0 && beyond(state.at.uv, 1) <= 0) return;
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
    for (int i = 0; i < 40; ++i) {
      const double m = 0.5 * (a + b);
      (sign * (path.point(m)[k] - bound) > 0 ? b : a) = m;
    }
    if (axis < 0 || b < first) {
      first = b;
      axis = k;
      side = bound;
    }
  }
  h *= first;
  state = from;
  integrate(state, span, h, nullptr);
  for (int i = 0; i < 4; ++i) {
    const double miss = side - state.at.uv[axis];
    if (std::abs(miss) <= 4e-16 * std::max(1.0, std::abs(side)) || state.duv[axis] == 0) break;
    const double correction = miss / state.duv[axis];
    if (!(std::abs(correction) < std::abs(h) + 1e-9)) break;
    integrate(state, span, correction, nullptr);
    h += correction;
  }
  state.at.uv[axis] = side;
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

GeodesicTracer::Crossing GeodesicTracer::cross_loops(GeodesicState& state, const GeodesicState& from, Span& span,
                                                     double& h) const {
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
  h *= hit->x;
  if (!integrate(at, span, h, nullptr)) return Crossing::singular;
  double t = hit->t;
  for (int i = 0; i < 5; ++i) {
    const auto c = coedge.pcurve.derivatives(t);
    Eigen::Matrix2d J;
    J << at.duv, -c.d1;
    const Uv r = c.c - at.at.uv;
    const Eigen::Vector2d step = J.partialPivLu().solve(r);
    if (!step.allFinite() || std::abs(step.x()) > 1 + 0.5 * std::abs(h)) break;
    t = std::clamp(t + step.y(), coedge.pcurve.first(), coedge.pcurve.last());
    if (!integrate(at, span, step.x(), nullptr)) return Crossing::singular;
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

bool GeodesicTracer::may_stay_outside(const GeodesicState& state, const Span& span) const {
  const Surface& surface = skin_->face(state.at.face).surface;
  const bool continued = span.iu < 0 || span.iv < 0 ||
                         span.iu >= static_cast<int>(std::max<std::size_t>(surface.breaks_u().size(), 2)) - 1 ||
                         span.iv >= static_cast<int>(std::max<std::size_t>(surface.breaks_v().size(), 2)) - 1;
  const bool alone = skin_->faces().size() == 1;
  const double limit = continued || (!alone && !state.in_hole)
                           ? options_.margin_mm
                           : std::max(options_.margin_mm, state.in_hole ? skin_->diagonal() : options_.outside_limit_mm);
  return state.outside_mm <= limit;
}

const GeodesicTracer::Pole* GeodesicTracer::approached_pole(const GeodesicState& state, const SurfaceDerivatives& d,
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

TraceEnd GeodesicTracer::advance(GeodesicState& state, double length) const {
  double remaining = length;
  double h = state.step_mm > 0 ? state.step_mm : std::min(length, 0.02 * skin_->diagonal());
  Span span = skin_->face(state.at.face).surface.span_at(state.at.uv, state.duv);
  const double longest = 0.1 * skin_->diagonal();
  const double least = 1e-13 * skin_->diagonal();
  bool verify = false;
  int idle = 0;
  while (remaining > least) {
    double step = std::min({h, remaining, longest});
    if (state.outside) step = std::min(step, std::max(1.0, 0.02 * skin_->diagonal()));
    if (!poles_[static_cast<std::size_t>(state.at.face)].empty() && !state.outside) {
      const SurfaceDerivatives d = skin_->derivatives(state.at);
      double distance = 0, miss = 0;
      if (const Pole* pole = approached_pole(state, d, distance, miss)) {
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
    const GeodesicState from = state;
    double error = 0;
    if (!integrate(state, span, step, &error) || error > 1) {
      state = from;
      h = step * (std::isfinite(error) && error > 1 ? std::clamp(0.9 * std::pow(error, -0.2), 0.1, 0.9) : 0.1);
      if (h < 1e-12 * skin_->diagonal()) return TraceEnd::singular;
      continue;
    }
    const double grown = step * std::clamp(0.9 * std::pow(std::max(error, 1e-10), -0.2), 0.5, 5.0);
    double taken = step;
    land_on_box(state, from, span, taken);
    const Crossing crossing = cross_loops(state, from, span, taken);
    remaining -= taken;
    if (crossing == Crossing::left) return TraceEnd::left;
    if (crossing == Crossing::singular) return TraceEnd::singular;
    // A step cut short by a knot or an edge says nothing about the next one's length.
    h = std::max(grown, taken < step ? std::min(h, step) : grown);
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
        }
        span = skin_->face(state.at.face).surface.span_at(state.at.uv, state.duv);
      }
    }
    if (state.outside) {
      state.outside_mm += taken;
      wrap_outside(state, span);
      // A step may end on the loop exactly (where it is a knot line too): that is back inside.
      if (skin_->trim(state.at.face).contains(state.at.uv)) {
        state.outside = state.in_hole = false;
        state.outside_mm = 0;
      }
      if (state.outside && !may_stay_outside(state, span)) return TraceEnd::left;
    }
    if (!cross_knot(state, span)) return TraceEnd::singular;
    idle = taken < 1e-9 && remaining > 1e-9 ? idle + 1 : 0;
    if (idle > 50) return TraceEnd::singular;
  }
  return TraceEnd::reached;
}

}  // namespace afptraj
