#include "boundary/clip.h"

#include <algorithm>
#include <cmath>

#include "geometry/curvature.h"

namespace afptraj {
namespace {

using Piece = std::vector<CurveNode>;

constexpr double on_edge_mm = 1e-6;  // how well samples at edges stand on them (design: ends within 1e-6 mm)
constexpr double least_gap_mm =
    1e-4;  // wider gaps between faces that share an edge get a sample on either side

CurveNode node_at(const Piece& piece, std::size_t i, double x, const Uv& uv) {
  const CurveNode& a = piece[i];
  const CurveNode& b = piece[i + 1];
  CurveNode node = a;
  node.t = a.t + x * (b.t - a.t);
  node.at.uv = uv;
  node.duv = cubic(piece, i).derivative(x) / (b.t - a.t);
  node.kg_per_mm = (1 - x) * a.kg_per_mm + x * b.kg_per_mm;
  return node;
}

class Clipper {
 public:
  /// Keeps the stretches inside the loops, or those outside.
  Clipper(const Skin& skin, double least_mm, bool keep_inside)
      : skin_(skin), least_mm_(least_mm), keep_(keep_inside) {}

  void add(const Piece& piece) {
    const TrimRegion& trim = skin_.trim(piece.front().at.face);
    const std::vector<Hit> hits = hits_of(trim, piece);
    bool inside = starts_inside(trim, piece, inside_);
    const Hit* late = inside_ ? begins_in_gap(piece, hits) : nullptr;
    if (late && keep_) {
      inside = false;  // the gap ends at that hit
    } else if (inside == keep_) {
      current_.emplace_back();
      push(piece.front());
    } else {
      finish();
    }
    const bool ends_in_gap = !hits.empty() && is_way_out(hits.back());
    std::size_t next = 0;
    for (std::size_t i = 0; i + 1 < piece.size(); ++i) {
      for (; next < hits.size() && hits[next].span == i; ++next) {
        const LoopCrossing& hit = hits[next].crossing;
        if (hits[next].degenerate || hit.outward != inside) continue;
        const CurveNode node = node_at(piece, i, hit.x, hit.uv);
        if (is_way_out(hits[next])) {
          // Out over a shared edge is no end: the next piece goes on there.
          if (!keep_ || !ends_in_gap || next + 1 < hits.size() || distance(node, piece.back()) < on_edge_mm)
            continue;
          push(node);
          inside_ = true;
          return;
        }
        if (inside == keep_) {
          push(node);
          finish();
        } else {
          current_.emplace_back();
          push(node);
        }
        inside = !inside;
      }
      if (inside == keep_) push(piece[i + 1]);
    }
    inside_ = inside;
  }

  std::vector<SurfaceCurve> take() {
    finish();
    return std::move(out_);
  }

 private:
  struct Hit {
    std::size_t span = 0;
    LoopCrossing crossing;
    bool degenerate = false, shared = false;
  };
  std::vector<Hit> hits_of(const TrimRegion& trim, const Piece& piece) const {
    std::vector<Hit> out;
    for (std::size_t i = 0; i + 1 < piece.size(); ++i)
      for (const LoopCrossing& crossing : trim.crossings(cubic(piece, i))) {
        const EdgeUse use{piece.front().at.face, crossing.loop, crossing.coedge};
        out.push_back({i, crossing, skin_.edge(use).degenerate, skin_.mate(use).has_value()});
      }
    return out;
  }
  static bool is_way_out(const Hit& hit) { return hit.shared && hit.crossing.outward; }
  double distance(const CurveNode& a, const CurveNode& b) const {
    return (skin_.point(a.at) - skin_.point(b.at)).norm();
  }
  /// A piece that goes on over a gap between faces may begin before the loop of its face: where it enters.
  const Hit* begins_in_gap(const Piece& piece, const std::vector<Hit>& hits) const {
    if (hits.empty() || hits.front().crossing.outward || !hits.front().shared) return nullptr;
    const Hit& hit = hits.front();
    const bool off =
        distance(piece.front(), node_at(piece, hit.span, hit.crossing.x, hit.crossing.uv)) > on_edge_mm;
    return off ? &hit : nullptr;
  }
  /// A piece that goes on from one that ended inside stands on the shared edge, to the solver's accuracy
  /// on either side of it: what lies just beyond decides.
  bool starts_inside(const TrimRegion& trim, const Piece& piece, bool goes_on) const {
    const UvCubic first = cubic(piece, 0);
    if (goes_on && trim.contains(piece.front().at.uv) && off_loops(trim, piece.front()) > on_edge_mm)
      return true;
    const double length = arc_length(skin_, piece, 0, 0, 1);
    const double skip = goes_on && length > 0 ? std::min(0.5, 1e-3 / length) : 1e-7;
    double x = 1;
    for (const LoopCrossing& hit : trim.crossings(first))
      if (hit.x > skip) {
        x = hit.x;
        break;
      }
    return trim.contains(first.point(0.5 * (skip + x)));
  }
  double off_loops(const TrimRegion& trim, const CurveNode& node) const {
    const Eigen::Matrix2d metric = first_form(skin_.derivatives(node.at)).matrix();
    return (skin_.point({node.at.face, trim.nearest(node.at.uv, metric).uv}) - skin_.point(node.at)).norm();
  }
  void push(const CurveNode& node) {
    if (!current_.back().empty() && node.t - current_.back().back().t < 1e-9) return;
    current_.back().push_back(node);
  }
  void finish() {
    std::erase_if(current_, [](const Piece& piece) { return piece.size() < 2; });
    double length = 0;
    for (const Piece& piece : current_)
      for (std::size_t i = 0; i + 1 < piece.size() && length < least_mm_; ++i)
        length += arc_length(skin_, piece, i, 0, 1);
    if (length >= least_mm_) out_.push_back({std::move(current_), false});
    current_.clear();
  }

  const Skin& skin_;
  double least_mm_;
  bool keep_;
  bool inside_ = false;  ///< where the last piece ended
  std::vector<Piece> current_;
  std::vector<SurfaceCurve> out_;
};

}  // namespace

std::vector<SurfaceCurve> off_skin(const Skin& skin, const SurfaceCurve& curve, double least_mm) {
  Clipper clipper(skin, least_mm, false);
  for (const Piece& piece : curve.pieces) clipper.add(piece);
  return clipper.take();
}

std::vector<SurfaceCurve> clip_to_skin(const Skin& skin, const SurfaceCurve& curve, double least_mm) {
  Clipper clipper(skin, least_mm, true);
  for (const Piece& piece : curve.pieces) clipper.add(piece);
  std::vector<SurfaceCurve> out = clipper.take();
  if (!curve.closed || out.empty()) return out;
  const bool whole_start = out.front().first() <= curve.first() + 1e-9;
  const bool whole_end = out.back().last() >= curve.last() - 1e-9;
  if (out.size() == 1) {
    out.front().closed = whole_start && whole_end;
  } else if (whole_start && whole_end) {
    // The first stretch goes on where the last one ends: join them, with t running on.
    SurfaceCurve joined = std::move(out.back());
    out.pop_back();
    const double shift = curve.last() - curve.first();
    for (Piece piece : out.front().pieces) {
      for (CurveNode& node : piece) node.t += shift;
      joined.pieces.push_back(std::move(piece));
    }
    out.front() = std::move(joined);
  }
  return out;
}

double axis_deviation(const Vec3& asked, const Vec3& tangent, const Vec3& normal) {
  double angle = std::atan2(asked.cross(tangent).dot(normal), asked.dot(tangent));
  if (angle > pi / 2) angle -= pi;
  if (angle <= -pi / 2) angle += pi;
  return angle;
}

CourseSegment sample_segment(const Skin& skin, const SurfaceCurve& curve, const DirectionField& field) {
  CourseSegment out;
  out.closed = curve.closed;
  double s = 0;
  for (const auto& piece : curve.pieces)
    for (std::size_t i = 0; i < piece.size(); ++i) {
      if (i > 0) s += arc_length(skin, piece, i - 1, 0, 1);
      if (i == 0 && !out.samples.empty()) {
        // The same point on the next face; where the faces gap, the other side of the gap.
        const double gap = (skin.point(piece[i].at) - out.samples.back().position).norm();
        if (gap < least_gap_mm) continue;
        s += gap;
      }
      const CurveNode& node = piece[i];
      const SurfaceDerivatives d = skin.derivatives(node.at);
      CourseSample sample;
      sample.at = node.at;
      sample.s_mm = s;
      sample.position = d.S;
      sample.normal = node.normal_sign * skin.normal(node.at);
      sample.tangent = uv_to_tangent(d, node.duv).normalized();
      sample.kn_per_mm = normal_curvature(d, sample.normal, sample.tangent);
      sample.kg_per_mm = node.kg_per_mm;
      const AskedDirection asked = field.at(sample.position, sample.normal, sample.tangent);
      sample.deviation_rad =
          asked.singular ? 0 : axis_deviation(asked.direction, sample.tangent, sample.normal);
      out.samples.push_back(sample);
    }
  return out;
}

namespace {

/// Whether a sample stands on an edge that its face shares with `face`.
bool on_edge_to(const Skin& skin, const CourseSample& sample, int face) {
  const LoopCrossing edge =
      skin.trim(sample.at.face).nearest(sample.at.uv, first_form(skin.derivatives(sample.at)).matrix());
  const auto mate = skin.mate({sample.at.face, edge.loop, edge.coedge});
  return mate && mate->face == face &&
         (skin.point({sample.at.face, edge.uv}) - sample.position).norm() < on_edge_mm;
}

/// Where a course that left another chart at `before`, on its edge, enters the face of `sample`.
Uv entry(const Skin& skin, const CourseSample& before, const CourseSample& sample, const Uv& seed) {
  const Surface& surface = skin.face(sample.at.face).surface;
  if (before.at.face == sample.at.face && on_crease(surface, before.at.uv)) return before.at.uv;
  if (before.at.face != sample.at.face) {
    const LoopCrossing edge =
        skin.trim(before.at.face).nearest(before.at.uv, first_form(skin.derivatives(before.at)).matrix());
    const EdgeUse use{before.at.face, edge.loop, edge.coedge};
    const double off = (skin.point({before.at.face, edge.uv}) - before.position).norm();
    const auto mate = skin.mate(use);
    if (off < on_edge_mm && mate && mate->face == sample.at.face)
      return skin.across(use, edge.t, before.position).uv;
  }
  const auto foot = foot_point(surface, before.position, seed);  // a seam, a corner or a pole
  return foot ? *foot : seed;
}

}  // namespace

SurfaceCurve curve_of(const Skin& skin, const CourseSegment& segment) {
  SurfaceCurve out;
  out.closed = segment.closed;
  // On a crease the derivatives are those of the side that `heading` points to.
  const auto node_of = [&](const CourseSample& sample, const SurfacePoint& at, const Uv& heading) {
    CurveNode node;
    node.t = sample.s_mm;
    node.at = at;
    const Surface& surface = skin.face(at.face).surface;
    node.duv = tangent_to_uv(surface.derivatives(surface.span_at(at.uv, heading), at.uv), sample.tangent);
    node.kg_per_mm = sample.kg_per_mm;
    node.normal_sign = skin.normal(at).dot(sample.normal) >= 0 ? 1 : -1;
    return node;
  };
  for (std::size_t i = 0; i < segment.samples.size(); ++i) {
    const CourseSample& sample = segment.samples[i];
    if (out.pieces.empty()) {
      const Uv ahead =
          segment.samples.size() > 1 ? Uv(segment.samples[1].at.uv - sample.at.uv) : Uv(Uv::Zero());
      out.pieces.emplace_back();
      out.pieces.back().push_back(node_of(sample, sample.at, ahead));
      continue;
    }
    const CourseSample& before = segment.samples[i - 1];
    const CurveNode& last = out.pieces.back().back();
    const CurveNode node = node_of(sample, sample.at, last.at.uv - sample.at.uv);
    const Surface& surface = skin.face(sample.at.face).surface;
    const Uv off = node.at.uv - last.at.uv - 0.5 * (node.t - last.t) * (node.duv + last.duv);
    const bool joined = before.at.face == sample.at.face && !on_crease(surface, last.at.uv) &&
                        uv_to_tangent(skin.derivatives(sample.at), off).norm() < 0.25 * (node.t - last.t);
    if (!joined) {
      // The sample before stands on the edge: find it on this face (or side of the seam or crease).
      const Uv seed = sample.at.uv - (node.t - last.t) * node.duv;
      const Uv uv = entry(skin, before, sample, seed);
      out.pieces.emplace_back();
      // Over a gap this sample itself stands there or on the edge: its piece begins with it.
      const bool over_gap = before.at.face != sample.at.face &&
                            ((skin.point({sample.at.face, uv}) - sample.position).norm() < on_edge_mm ||
                             on_edge_to(skin, sample, before.at.face));
      if (!over_gap) out.pieces.back().push_back(node_of(before, {sample.at.face, uv}, sample.at.uv - uv));
    }
    out.pieces.back().push_back(node);
  }
  std::erase_if(out.pieces, [](const Piece& piece) { return piece.size() < 2; });
  return out;
}

}  // namespace afptraj
