#include "trajectory/level_curve.h"

#include <algorithm>
#include <cmath>

#include "geometry/curvature.h"

namespace afptraj {
namespace {

constexpr double bracket_mm = 1e-3;  // how closely two rays enclose a passage before it is solved

class CurveBuilder {
 public:
  CurveBuilder(const GeodesicTracer& tracer, const Front& front, int level)
      : skin_(tracer.skin()), front_(front), level_(level) {}

  void begin_strand(int source, double offset) {
    if (source != source_ || std::abs(offset - offset_) > 1e-9)
      last_source_ = -1;  // also round a closed source
    source_ = source;
    offset_ = offset;
  }

  void add(const Ray& ray) {
    const CurveNode node = node_of(ray);
    if (!curve_.pieces.empty()) {
      const CurveNode& last = curve_.pieces.back().back();
      if (last_source_ != source_ && node.t - last.t < 1e-9) {
        // Strands join at one ray: same place and direction, but the speed may jump. A new piece.
        curve_.pieces.emplace_back();
        push(node);
        last_ray_ = ray;
        last_source_ = source_;
        return;
      }
      if (node.t - last.t < 1e-9) return;
      if (same_chart(skin_, last, node))
        reach(ray, 0);
      else
        pass_over(last_ray_, ray, 0);
    } else {
      curve_.pieces.emplace_back();
      push(node);
    }
    last_ray_ = ray;
    last_source_ = source_;
  }

  SurfaceCurve take(bool closed) {
    curve_.closed = closed;
    return without_loops(skin_, curve_);
  }

 private:
  CurveNode node_of(const Ray& ray) const {
    CurveNode node = level_node(skin_, *front_.source(source_).curve, ray, front_.side());
    node.t += offset_;
    return node;
  }
  void push(const CurveNode& node) { curve_.pieces.back().push_back(node); }

  /// Whether the cubic between two nodes runs straight enough to be a curve between samples: an arc that
  /// turns by a is longer than its chord by a^2 / 24 of it, 3 % at 48 degrees. More only asks for rays
  /// between; the bound is chosen, not derived.
  bool follows(const CurveNode& a, const CurveNode& b) const {
    const double arc = arc_length(skin_, {a, b}, 0, 0, 1);
    const double chord = (skin_.point(a.at) - skin_.point(b.at)).norm();
    return arc <= chord + 0.03 * arc + 1e-5;
  }

  /// Goes on from the last node to `ray` on one chart. Where the parametrisation changes its speed within
  /// a sample (towards a side that it nearly shrinks to a point) the cubic would loop: rays are added there.
  void reach(const Ray& ray, int depth) {
    const CurveNode node = node_of(ray);
    if (depth < 30 && last_source_ == source_) {
      const CurveNode last = curve_.pieces.back().back();
      if (node.t - last.t > 1e-7 && same_chart(skin_, last, node) && !follows(last, node)) {
        bool alive = false;
        const Ray mid = front_.shoot(source_, 0.5 * (last.t + node.t) - offset_, level_, &alive);
        if (alive) {
          const CurveNode between = node_of(mid);
          if (same_chart(skin_, last, between) && same_chart(skin_, between, node)) {
            reach(mid, depth + 1);
            reach(ray, depth + 1);
            return;
          }
        }
      }
    }
    push(node);
  }

  /// From ray `from` (whose node is in place) to ray `to` over one or more passages.
  void pass_over(const Ray& from, const Ray& to, int depth) {
    Ray a = from, b = to;
    std::vector<Ray> before,
        after;  // rays on the chart of `from`, of `to`: the way there, where it is no smooth cubic
    for (int i = 0; i < 60; ++i) {
      const CurveNode na = node_of(a), nb = node_of(b);
      if ((skin_.point(na.at) - skin_.point(nb.at)).norm() < bracket_mm || b.t - a.t < 1e-9) break;
      bool alive = false;
      const Ray mid = front_.shoot(source_, 0.5 * (a.t + b.t), level_, &alive);
      if (!alive) break;
      const CurveNode nm = node_of(mid);
      const bool joins_a = same_chart(skin_, na, nm), joins_b = same_chart(skin_, nm, nb);
      if (joins_a) {
        a = mid;
        before.push_back(mid);
        if (joins_b) break;
      } else if (joins_b) {
        b = mid;
        after.insert(after.begin(), mid);
      } else if (depth < 6) {  // a third chart lies between
        reach_over(before);
        pass_over(a, mid, depth + 1);
        pass_over(mid, b, depth + 1);
        after.push_back(to);
        reach_over(after);
        return;
      } else {
        break;
      }
    }
    reach_over(before);
    if (!same_chart(skin_, node_of(a), node_of(b))) {
      join(node_of(a), node_of(b));
      reach_if_later(b);
    }
    after.push_back(to);
    reach_over(after);
  }

  /// Goes on over rays of which each joins the one before, over as few as join, to the last.
  void reach_over(const std::vector<Ray>& rays) {
    for (std::size_t i = 0; i < rays.size(); ++i)
      if (i + 1 == rays.size() || !same_chart(skin_, curve_.pieces.back().back(), node_of(rays[i + 1])))
        reach_if_later(rays[i]);
  }

  void reach_if_later(const Ray& ray) {
    if (node_of(ray).t - curve_.pieces.back().back().t > 1e-9) reach(ray, 0);
  }

  /// Where the curve leaves the face of `a` for that of `b`: along the tangent, or where a stands on the
  /// edge (between faces that gap neighbouring rays never come closer than the gap) at the nearest place of
  /// it.
  std::optional<LoopCrossing> way_out(const CurveNode& a, const CurveNode& b) const {
    const TrimRegion& trim = skin_.trim(a.at.face);
    const auto leads_to_b = [&](const LoopCrossing& hit) {
      const auto mate = skin_.mate({a.at.face, hit.loop, hit.coedge});
      return mate && mate->face == b.at.face;
    };
    const double gap = std::max(b.t - a.t, 1e-9);
    auto hit = trim.first_crossing(UvCubic::line(a.at.uv, a.at.uv + 2 * gap * a.duv), true);
    if (hit && leads_to_b(*hit)) return hit;
    hit = trim.nearest(a.at.uv, first_form(skin_.derivatives(a.at)).matrix());
    hit->x = 0;
    const double off = (skin_.point({a.at.face, hit->uv}) - skin_.point(a.at)).norm();
    if (off < 2 * bracket_mm && leads_to_b(*hit)) return hit;
    return std::nullopt;
  }

  /// Ends the piece of `a` on the edge between a and b, and begins the piece of `b` there.
  void join(const CurveNode& a, const CurveNode& b) {
    CurveNode out = a, in = b;
    const double gap = std::max(b.t - a.t, 1e-9);
    const double apart = uv_to_tangent(skin_.derivatives(a.at), b.at.uv - a.at.uv).norm();
    if (a.at.face == b.at.face && apart < 10 * bracket_mm) {  // farther apart: a seam or pole between
      if (const auto crease = crease_between(skin_.face(a.at.face).surface, a.at.uv, b.at.uv)) {
        // The same point of the same face, with the derivatives of either side.
        out.at.uv = a.at.uv + crease->x * (b.at.uv - a.at.uv);
        out.at.uv[crease->axis] = crease->value;
        out.t = a.t + crease->x * gap;
        in.at.uv = out.at.uv;
        begin_piece(out, in);
        return;
      }
    }
    if (const auto hit = way_out(a, b)) {
      out.at.uv = hit->uv;
      out.t = a.t + std::min(2 * gap * hit->x, 0.999 * gap);
      in.at = skin_.across({a.at.face, hit->loop, hit->coedge}, hit->t, skin_.point(out.at));
    } else {
      // A corner or a pole between: carry a's point over as it is.
      const auto foot = foot_point(skin_.face(b.at.face).surface, skin_.point(a.at), b.at.uv);
      if (foot) in.at.uv = *foot;
    }
    begin_piece(out, in);
  }

  void begin_piece(const CurveNode& out, CurveNode in) {
    in.t = out.t;
    if (out.t - curve_.pieces.back().back().t > 1e-12) push(out);
    curve_.pieces.emplace_back();
    push(in);
  }

  const Skin& skin_;
  const Front& front_;
  int level_;
  int source_ = 0, last_source_ = -1;
  double offset_ = 0;
  Ray last_ray_;
  SurfaceCurve curve_;
};

struct Link {
  std::size_t strand;
  int end;
};

std::optional<Link> partner(const std::vector<Strand>& strands, std::size_t i, int e) {
  if (strands[i].end[e] != StrandEnd::linked) return std::nullopt;
  for (std::size_t j = 0; j < strands.size(); ++j)
    for (int f = 0; f < 2; ++f)
      if ((j != i || f != e) && strands[j].end[f] == StrandEnd::linked &&
          strands[j].link[f] == strands[i].link[e])
        return Link{j, f};
  return std::nullopt;
}

bool loops(const Skin& skin, const CurveNode& a, const CurveNode& b) {
  constexpr double noise_mm = 1e-6;
  return arc_length(skin, {a, b}, 0, 0, 1) > 1.5 * (skin.point(a.at) - skin.point(b.at)).norm() + noise_mm;
}

}  // namespace

SurfaceCurve without_loops(const Skin& skin, const SurfaceCurve& curve) {
  SurfaceCurve out;
  out.closed = curve.closed;
  for (const auto& piece : curve.pieces) {
    out.pieces.emplace_back();
    for (std::size_t i = 0; i < piece.size(); ++i) {
      out.pieces.back().push_back(piece[i]);
      if (i + 1 == piece.size() || !loops(skin, piece[i], piece[i + 1])) continue;
      CurveNode a = piece[i], b = piece[i + 1];
      a.duv = b.duv = (b.at.uv - a.at.uv) / (b.t - a.t);
      out.pieces.push_back({a, b});
      out.pieces.emplace_back();
    }
  }
  std::erase_if(out.pieces, [](const auto& piece) { return piece.size() < 2; });
  return out;
}

std::vector<ChainedCurve> level_curves(const GeodesicTracer& tracer, const Front& front, int level) {
  const auto& strands = front.strands();
  std::vector<char> used(strands.size(), 0);
  std::vector<ChainedCurve> out;
  for (std::size_t start = 0; start < strands.size(); ++start) {
    if (used[start]) continue;
    // Back to the first strand of the chain; all strands run the same way along it.
    std::size_t first = start;
    bool closed = false;
    while (const auto before = partner(strands, first, 0)) {
      if (before->end != 1) break;
      if (before->strand == start) {
        closed = true;
        first = start;
        break;
      }
      first = before->strand;
    }
    ChainedCurve chain;
    CurveBuilder builder(tracer, front, level);
    double reached = strands[first].rays.front().t;
    for (std::size_t at = first;;) {
      used[at] = 1;
      const Strand& strand = strands[at];
      const double offset = reached - strand.rays.front().t;
      chain.strands.push_back(at);
      chain.offsets.push_back(offset);
      builder.begin_strand(strand.source, offset);
      for (const Ray& ray : strand.rays) builder.add(ray);
      reached = strand.rays.back().t + offset;
      const auto after = partner(strands, at, 1);
      if (!after || after->end != 0 || used[after->strand]) break;
      at = after->strand;
    }
    chain.curve = builder.take(closed);
    if (!chain.curve.empty()) out.push_back(std::move(chain));
  }
  return out;
}

}  // namespace afptraj
