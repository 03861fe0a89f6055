#include "geometry/skin.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "geometry/curvature.h"

namespace afptraj {
namespace {

std::vector<std::vector<EdgeUse>> edge_uses(const Part& part, const std::vector<int>& faces) {
  std::vector<std::vector<EdgeUse>> uses(part.edges.size());
  for (int f : faces) {
    const Face& face = part.faces[static_cast<std::size_t>(f)];
    for (std::size_t l = 0; l < face.loops.size(); ++l)
      for (std::size_t c = 0; c < face.loops[l].coedges.size(); ++c)
        uses[static_cast<std::size_t>(face.loops[l].coedges[c].edge)].push_back(
            {f, static_cast<int>(l), static_cast<int>(c)});
  }
  return uses;
}

Vec3 oriented_normal(const Face& face, const Uv& uv) {
  const Vec3 n = unit_normal(face.surface.derivatives(uv));
  return face.reversed ? Vec3(-n) : n;
}

const Coedge& coedge_of(const Part& part, const EdgeUse& use) {
  return part.faces[static_cast<std::size_t>(use.face)]
      .loops[static_cast<std::size_t>(use.loop)]
      .coedges[static_cast<std::size_t>(use.coedge)];
}

/// Whether the normals of both sides agree along the whole edge. Loose faces may be oriented
/// against each other: then one sense of the normal is as good as the other.
bool is_tangent(const Part& part, const EdgeUse& a, const EdgeUse& b, double angle_rad) {
  const Coedge& ca = coedge_of(part, a);
  const Coedge& cb = coedge_of(part, b);
  const bool opposed = ca.reversed == cb.reversed;
  constexpr int samples = 16;
  for (int i = 0; i < samples; ++i) {
    const double x = (i + 0.5) / samples;
    const double ta = ca.pcurve.first() + x * (ca.pcurve.last() - ca.pcurve.first());
    const double tb = cb.pcurve.first() + x * (cb.pcurve.last() - cb.pcurve.first());
    const Vec3 na = unit_normal(part.faces[static_cast<std::size_t>(a.face)].surface.derivatives(ca.pcurve.point(ta)));
    Vec3 nb = unit_normal(part.faces[static_cast<std::size_t>(b.face)].surface.derivatives(cb.pcurve.point(tb)));
    if (opposed) nb = -nb;
    if (na.isZero() || nb.isZero()) continue;
    if (na.dot(nb) < std::cos(angle_rad)) return false;
  }
  return true;
}

bool runs_clockwise(const Loop& loop) {
  double area = 0;
  for (const Coedge& c : loop.coedges) {
    const double t0 = c.reversed ? c.pcurve.last() : c.pcurve.first();
    const double t1 = c.reversed ? c.pcurve.first() : c.pcurve.last();
    constexpr int n = 16;
    Uv p = c.pcurve.point(t0);
    for (int i = 1; i <= n; ++i) {
      const Uv q = c.pcurve.point(t0 + (t1 - t0) * i / n);
      area += p.x() * q.y() - q.x() * p.y();
      p = q;
    }
  }
  return area < 0;
}

}  // namespace

Skin::Skin(std::shared_ptr<const Part> part, std::vector<int> faces) : part_(std::move(part)), faces_(std::move(faces)) {
  if (faces_.empty()) throw std::invalid_argument("a skin needs at least one face");
  std::sort(faces_.begin(), faces_.end());
  faces_.erase(std::unique(faces_.begin(), faces_.end()), faces_.end());
  trim_.resize(part_->faces.size());
  holes_.resize(part_->faces.size());
  for (int f : faces_) {
    if (f < 0 || f >= static_cast<int>(part_->faces.size())) throw std::invalid_argument("face index out of range");
    trim_[static_cast<std::size_t>(f)] = std::make_shared<const TrimRegion>(face(f));
    for (const Loop& loop : face(f).loops) holes_[static_cast<std::size_t>(f)].push_back(runs_clockwise(loop));
  }
  uses_ = edge_uses(*part_, faces_);
  closest_ = std::make_shared<const ClosestPointFinder>(part_, faces_, trim_);
  box_min_.setConstant(std::numeric_limits<double>::infinity());
  box_max_ = -box_min_;
  for (int f : faces_)
    for (const AreaSample& sample : area_samples(*part_, f, trim(f), 1000)) {
      const Vec3 p = point(sample.at);
      box_min_ = box_min_.cwiseMin(p);
      box_max_ = box_max_.cwiseMax(p);
      area_ += sample.area_mm2;
    }
  for (int f : faces_)
    for (const Loop& loop : face(f).loops)
      for (const Coedge& c : loop.coedges)
        for (int i = 0; i <= 32; ++i) {
          const double t = c.pcurve.first() + (c.pcurve.last() - c.pcurve.first()) * i / 32;
          const Vec3 p = face(f).surface.point(c.pcurve.point(t));
          box_min_ = box_min_.cwiseMin(p);
          box_max_ = box_max_.cwiseMax(p);
        }
}

std::optional<EdgeUse> Skin::mate(const EdgeUse& use) const {
  const auto& all = uses_[static_cast<std::size_t>(coedge(use).edge)];
  if (edge(use).degenerate) return std::nullopt;
  for (const EdgeUse& other : all)
    if (!(other == use)) return other;
  return std::nullopt;
}

SurfacePoint Skin::across(const EdgeUse& use, double t, const Vec3& p) const {
  constexpr double meet_mm = 1e-5;
  const EdgeUse other = *mate(use);
  const BSplineCurve2& pcurve = coedge(other).pcurve;
  const Surface& surface = face(other.face).surface;
  t = std::clamp(t, pcurve.first(), pcurve.last());
  Uv uv = pcurve.point(t);
  const auto foot = foot_point(surface, p, uv);
  const auto meets = [&] { return foot && (surface.point(*foot) - surface.point(uv)).norm() < meet_mm; };
  if (meets()) return {other.face, *foot};
  // Both uses give the same point at the same parameter only to the edge's tolerance.
  for (int i = 0; i < 10; ++i) {
    const auto c = pcurve.derivatives(t);
    const SurfaceDerivatives d = surface.derivatives(c.c);
    const Vec3 along = uv_to_tangent(d, c.d1);
    if (!(along.squaredNorm() > 0)) break;
    const double next = std::clamp(t + (p - d.S).dot(along) / along.squaredNorm(), pcurve.first(), pcurve.last());
    const bool settled = std::abs(next - t) * along.norm() < 1e-10;
    t = next;
    if (settled) break;
  }
  uv = pcurve.point(t);
  return {other.face, meets() ? *foot : uv};
}

const Edge& Skin::edge(const EdgeUse& use) const { return part_->edges[static_cast<std::size_t>(coedge(use).edge)]; }

const Coedge& Skin::coedge(const EdgeUse& use) const { return coedge_of(*part_, use); }

bool Skin::is_seam(const EdgeUse& use) const {
  const auto other = mate(use);
  return other && other->face == use.face;
}

Vec3 Skin::normal(const SurfacePoint& at) const { return oriented_normal(face(at.face), at.uv); }

std::vector<int> grow_tangent(const Part& part, const std::vector<int>& seeds, double angle_rad) {
  std::vector<int> all(part.faces.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
  const auto uses = edge_uses(part, all);
  std::vector<std::vector<int>> neighbours(part.faces.size());
  for (std::size_t e = 0; e < uses.size(); ++e) {
    if (uses[e].size() != 2 || part.edges[e].degenerate || uses[e][0].face == uses[e][1].face) continue;
    if (!is_tangent(part, uses[e][0], uses[e][1], angle_rad)) continue;
    neighbours[static_cast<std::size_t>(uses[e][0].face)].push_back(uses[e][1].face);
    neighbours[static_cast<std::size_t>(uses[e][1].face)].push_back(uses[e][0].face);
  }
  std::set<int> reached(seeds.begin(), seeds.end());
  std::vector<int> open(seeds);
  while (!open.empty()) {
    const int f = open.back();
    open.pop_back();
    for (int g : neighbours[static_cast<std::size_t>(f)])
      if (reached.insert(g).second) open.push_back(g);
  }
  return {reached.begin(), reached.end()};
}

namespace {

/// Bounds of about `count` cells from lo to hi; each knot span gets its share by length on the surface.
std::vector<double> cell_bounds(const Surface& surface, int axis, double lo, double hi, double count) {
  const std::vector<double>& breaks = axis == 0 ? surface.breaks_u() : surface.breaks_v();
  const double period = axis == 0 ? surface.period_u() : surface.period_v();
  std::vector<double> spans = {lo};
  if (!breaks.empty()) {
    const double start = period > 0 ? period * std::floor((lo - breaks.front()) / period) : 0;
    for (double shift = start; shift < hi - lo + start + std::max(period, 1e-300); shift += period) {
      for (double b : breaks)
        if (b + shift > spans.back() + 1e-12 * (hi - lo) && b + shift < hi - 1e-12 * (hi - lo)) spans.push_back(b + shift);
      if (period <= 0) break;
    }
  }
  spans.push_back(hi);
  const Interval other = axis == 0 ? surface.domain_v() : surface.domain_u();
  const double middle = std::isfinite(other.lo + other.hi) ? 0.5 * (other.lo + other.hi) : 0;
  std::vector<double> length(spans.size() - 1);
  double total = 0;
  for (std::size_t i = 0; i < length.size(); ++i) {
    const double t = 0.5 * (spans[i] + spans[i + 1]);
    const SurfaceDerivatives d = surface.derivatives(axis == 0 ? Uv(t, middle) : Uv(middle, t));
    length[i] = (axis == 0 ? d.Su : d.Sv).norm() * (spans[i + 1] - spans[i]);
    total += length[i];
  }
  std::vector<double> out = {lo};
  for (std::size_t i = 0; i < length.size(); ++i) {
    const double share = total > 0 ? length[i] / total : 1.0 / static_cast<double>(length.size());
    const int n = std::max(1, static_cast<int>(std::lround(count * share)));
    for (int k = 1; k <= n; ++k) out.push_back(spans[i] + (spans[i + 1] - spans[i]) * k / n);
  }
  return out;
}

}  // namespace

std::vector<AreaSample> area_samples(const Part& part, int face, const TrimRegion& trim, int count) {
  // Midpoints of a tensor grid; cells are shaped so that they are about square on the surface.
  const Surface& surface = part.faces[static_cast<std::size_t>(face)].surface;
  const Uv lo = trim.box_min(), size = trim.box_max() - trim.box_min();
  double lu = 0, lv = 0;
  for (int i = 0; i < 7; ++i)
    for (int j = 0; j < 7; ++j) {
      const SurfaceDerivatives d = surface.derivatives(lo + size.cwiseProduct(Uv((i + 0.5) / 7, (j + 0.5) / 7)));
      lu += d.Su.norm() * size.x() / 49;
      lv += d.Sv.norm() * size.y() / 49;
    }
  // Cells do not straddle knots: the speed of the parametrisation may jump there.
  const double cell_mm = std::sqrt(std::max(lu * lv, 1e-300) / count);
  const auto u = cell_bounds(surface, 0, lo.x(), lo.x() + size.x(), std::max(3.0, lu / cell_mm));
  const auto v = cell_bounds(surface, 1, lo.y(), lo.y() + size.y(), std::max(3.0, lv / cell_mm));
  std::vector<AreaSample> out;
  out.reserve(u.size() * v.size());
  for (std::size_t i = 0; i + 1 < u.size(); ++i)
    for (std::size_t j = 0; j + 1 < v.size(); ++j) {
      const Uv uv(0.5 * (u[i] + u[i + 1]), 0.5 * (v[j] + v[j + 1]));
      if (!trim.contains(uv)) continue;
      const SurfaceDerivatives d = surface.derivatives(uv);
      out.push_back({{face, uv}, d.Su.cross(d.Sv).norm() * (u[i + 1] - u[i]) * (v[j + 1] - v[j])});
    }
  return out;
}

}  // namespace afptraj
