#include "geometry/closest_point.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "geometry/closest_index.h"
#include "geometry/curvature.h"
#include "geometry/foot.h"

namespace afptraj {
namespace {

/// A foot inside a face is preferred to a point of its boundary as near as this (a seam, a smooth
/// shared edge); a tenth of what law (C1) allows.
constexpr double tie_mm = 1e-10;
constexpr double foot_tolerance_mm = 1e-11;

/// One item of the tree.
struct Item {
  enum class Kind { patch, curve, analytic } kind;
  int index;  // of the patch, the curve piece, or the face
};

}  // namespace

struct ClosestPointFinder::Data {
  std::shared_ptr<const Part> part;
  std::vector<std::shared_ptr<const TrimRegion>> trim;
  std::vector<closest::Patch> patches;
  std::vector<closest::CurvePiece> curves;
  std::vector<Item> items;
  closest::Tree tree{{}};

  const Face& face(int i) const { return part->faces[static_cast<std::size_t>(i)]; }
  const TrimRegion& region(int i) const { return *trim[static_cast<std::size_t>(i)]; }
  void build(const std::vector<int>& faces);
};

namespace {

/// One query: the best point so far, and how each kind of item may better it.
class Query {
 public:
  Query(const Vec3& p, double limit_mm, const Vec3* facing) : p_(p), facing_(facing), limit_(limit_mm) {}

  double limit2() const { return reach() * reach(); }
  double reach() const { return limit_ + (best_.at.face >= 0 ? tie_mm : 0); }
  const ClosestPoint& best() const { return best_; }

  void visit(const Face& face, const TrimRegion& trim, const closest::Patch& patch) {
    if (patch.distance2(p_) > limit2()) return;
    // The middle of the patch bounds the distance at once and spares many patches.
    if (patch.inside) offer(face, {patch.face, patch.mid_uv}, patch.mid, false);
    Uv seed = patch.mid_uv + patch.to_uv * (p_ - patch.mid);
    seed = seed.cwiseMax(patch.lo).cwiseMin(patch.hi);
    // The foot, if any, lies on this piece; a little beyond is where Newton may pass on its way.
    const Uv size = patch.hi - patch.lo;
    const foot::Limits limits{patch.lo - size, patch.hi + size, size, &patch.span};
    const auto found = foot::descend(face.surface, p_, seed, limits, foot_tolerance_mm);
    if (!found || found->distance > reach()) return;
    const Uv slack = 1e-9 * (patch.span_hi - patch.span_lo);
    const bool on_span = ((found->uv - patch.span_lo + slack).array() >= 0).all() &&
                         ((patch.span_hi + slack - found->uv).array() >= 0).all();
    if (!on_span) return;
    const Uv uv = found->uv.cwiseMax(patch.span_lo).cwiseMin(patch.span_hi);
    const bool on_patch = (uv.array() >= patch.lo.array()).all() && (uv.array() <= patch.hi.array()).all();
    if (!(patch.inside && on_patch) && !trim.contains(uv)) return;
    offer(face, {patch.face, uv}, found->point, false);
  }

  void visit(const Face& face, int index, const TrimRegion& trim) {
    const Uv middle = 0.5 * (trim.box_min() + trim.box_max());
    const foot::Feet feet = foot::analytic_feet(face.surface, p_, middle);
    for (int i = 0; i < feet.count; ++i) {
      const Uv& uv = feet.uv[static_cast<std::size_t>(i)];
      const Vec3 point = face.surface.point(uv);
      if ((point - p_).norm() > reach()) continue;
      const std::optional<Uv> inside = inside_copy(face.surface, trim, uv);
      if (inside) offer(face, {index, *inside}, point, false);
    }
  }

  void visit(const Face& face, const TrimRegion& trim, const closest::CurvePiece& piece) {
    if (piece.distance(p_) > limit_) return;
    const double t = nearest_parameter(face.surface, piece);
    const Uv uv = piece.curve->point(t);
    const Vec3 point = face.surface.point(uv);
    if ((point - p_).norm() > limit_) return;
    if (piece.crease && !trim.contains(uv)) return;
    offer(face, {piece.face, uv}, point, !piece.crease);
  }

 private:
  /// The parameters of a point on a periodic surface that lie in the material, if any do.
  static std::optional<Uv> inside_copy(const Surface& surface, const TrimRegion& trim, const Uv& uv) {
    const double pu = surface.period_u(), pv = surface.period_v();
    for (int i = pu > 0 ? -1 : 0; i <= (pu > 0 ? 1 : 0); ++i) {
      for (int j = pv > 0 ? -1 : 0; j <= (pv > 0 ? 1 : 0); ++j) {
        const Uv copy = uv + Uv(i * pu, j * pv);
        if (trim.contains(copy)) return copy;
      }
    }
    return std::nullopt;
  }

  void offer(const Face& face, const SurfacePoint& at, const Vec3& point, bool on_boundary) {
    const double distance = (point - p_).norm();
    if (distance > limit_ + (best_.on_boundary && !on_boundary ? tie_mm : 0)) return;
    if (best_.at.face >= 0 && on_boundary && !best_.on_boundary && distance >= best_.distance_mm - tie_mm)
      return;
    if (best_.at.face >= 0 && on_boundary == best_.on_boundary && distance >= best_.distance_mm) return;
    if (facing_ != nullptr) {
      const double turn = unit_normal(face.surface.derivatives(at.uv)).dot(*facing_);
      if ((face.reversed ? -turn : turn) < 0) return;
    }
    best_ = {at, point, distance, on_boundary};
    limit_ = std::min(limit_, distance);
  }

  /// The least distance on one nearly straight piece: Newton on (C - p).C' = 0, kept in [t0, t1].
  double nearest_parameter(const Surface& surface, const closest::CurvePiece& piece) const {
    const Vec3 chord = piece.b - piece.a;
    const double cc = chord.squaredNorm();
    const double s = cc > 0 ? std::clamp((p_ - piece.a).dot(chord) / cc, 0.0, 1.0) : 0.5;
    double lo = piece.t0, hi = piece.t1;
    double t = lo + s * (hi - lo);
    const double tiny = 1e-15 * std::max(std::abs(lo), std::abs(hi));
    for (int i = 0; i < 30; ++i) {
      const auto c = piece.curve->derivatives(t);
      const SurfaceDerivatives d = surface.derivatives(c.c);
      const Vec3 r = d.S - p_;
      const Vec3 d1 = uv_to_tangent(d, c.d1);
      const double slope = r.dot(d1);
      if (std::abs(slope) <= foot_tolerance_mm * 0.1 * d1.norm()) return t;
      // Between lo and hi the distance falls, then rises: the slope tells on which side t is.
      (slope > 0 ? hi : lo) = t;
      const Vec3 d2 = d.Suu * (c.d1.x() * c.d1.x()) + 2 * d.Suv * (c.d1.x() * c.d1.y()) +
                      d.Svv * (c.d1.y() * c.d1.y()) + uv_to_tangent(d, c.d2);
      const double bend = d1.squaredNorm() + r.dot(d2);
      double next = bend > 0 ? t - slope / bend : (slope > 0 ? piece.t0 : piece.t1);
      if (next < lo || next > hi) {
        // At an end of the piece the minimum may be the end itself.
        if (next <= piece.t0 && lo == piece.t0)
          next = piece.t0;
        else if (next >= piece.t1 && hi == piece.t1)
          next = piece.t1;
        else
          next = 0.5 * (lo + hi);
      }
      if (std::abs(next - t) <= tiny) return next;
      t = next;
    }
    return t;
  }

  Vec3 p_;
  const Vec3* facing_;
  double limit_;
  ClosestPoint best_;
};

}  // namespace

void ClosestPointFinder::Data::build(const std::vector<int>& faces) {
  std::vector<closest::Box> boxes;
  for (const int f : faces) {
    const Surface& surface = face(f).surface;
    if (surface.spline() != nullptr) {
      for (closest::Patch& patch : closest::patches_of(surface, f, region(f))) {
        items.push_back({Item::Kind::patch, static_cast<int>(patches.size())});
        boxes.push_back(closest::box_of(patch));
        patches.push_back(std::move(patch));
      }
    } else {
      items.push_back({Item::Kind::analytic, f});
      boxes.push_back(closest::box_of_analytic(surface, region(f)));
    }
    for (closest::CurvePiece& curve : closest::curves_of(face(f), f, region(f))) {
      items.push_back({Item::Kind::curve, static_cast<int>(curves.size())});
      boxes.push_back(closest::box_of(curve));
      curves.push_back(std::move(curve));
    }
  }
  tree = closest::Tree(boxes);
}

ClosestPointFinder::ClosestPointFinder(std::shared_ptr<const Part> part, std::vector<int> faces,
                                       std::vector<std::shared_ptr<const TrimRegion>> trim) {
  auto data = std::make_shared<Data>();
  data->part = std::move(part);
  data->trim = std::move(trim);
  const auto count = static_cast<int>(data->part->faces.size());
  if (faces.empty()) {
    for (int f = 0; f < count; ++f) faces.push_back(f);
  }
  for (const int f : faces) {
    const bool known = f >= 0 && f < count && static_cast<std::size_t>(f) < data->trim.size() &&
                       data->trim[static_cast<std::size_t>(f)] != nullptr;
    if (!known) throw std::invalid_argument("ClosestPointFinder: a face without its trim region");
  }
  data->build(faces);
  data_ = std::move(data);
}

std::optional<ClosestPoint> ClosestPointFinder::closest(const Vec3& p, double limit_mm,
                                                        const Vec3* facing) const {
  const Data& data = *data_;
  if (!p.allFinite()) return std::nullopt;
  Query query(p, limit_mm, facing);
  data.tree.walk(
      p, [&] { return query.limit2(); },
      [&](int i) {
        const Item& item = data.items[static_cast<std::size_t>(i)];
        const auto index = static_cast<std::size_t>(item.index);
        if (item.kind == Item::Kind::patch) {
          const closest::Patch& patch = data.patches[index];
          query.visit(data.face(patch.face), data.region(patch.face), patch);
        } else if (item.kind == Item::Kind::curve) {
          const closest::CurvePiece& piece = data.curves[index];
          query.visit(data.face(piece.face), data.region(piece.face), piece);
        } else {
          query.visit(data.face(item.index), item.index, data.region(item.index));
        }
      });
  if (query.best().at.face < 0) return std::nullopt;
  return query.best();
}

}  // namespace afptraj
