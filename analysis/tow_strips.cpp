#include "analysis/tow_strips.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "geometry/curvature.h"

namespace afptraj {
namespace {

using Nodes = std::vector<CurveNode>;

/// A stretch of one edge line in one chart.
struct LinePiece {
  std::size_t line;
  const Nodes* nodes;
  bool comes, goes;  // from another chart, on to another one
  double first() const { return nodes->front().t; }
  double last() const { return nodes->back().t; }
  int face() const { return nodes->front().at.face; }
};

Uv point_at(const Nodes& nodes, double t) {
  if (t <= nodes.front().t) return nodes.front().at.uv + (t - nodes.front().t) * nodes.front().duv;
  if (t >= nodes.back().t) return nodes.back().at.uv + (t - nodes.back().t) * nodes.back().duv;
  const auto after = [&](const CurveNode& node) { return node.t <= t; };
  const auto i =
      static_cast<std::size_t>(std::partition_point(nodes.begin(), nodes.end(), after) - nodes.begin()) - 1;
  return cubic(nodes, i).point((t - nodes[i].t) / (nodes[i + 1].t - nodes[i].t));
}

// Times the tow's width:
constexpr double straight_on = 8;
constexpr double tip = 8;

/// One visit of a band to a face: pieces of neighbouring lines side by side in one chart.
struct Visit {
  std::vector<std::vector<const LinePiece*>> lines;  // by edge, in order of t
  Interval range{1e300, -1e300};
  int face = -1, normal_sign = 1;
  bool at_pole = false;  // the face has a side that is a point
};

struct Sample {
  double t;
  Uv uv;
};

class BandStrips {
 public:
  BandStrips(const Skin& skin, const Ply& ply, std::size_t band, double chord_mm)
      : skin_(skin), band_(ply.bands[band]), index_(band), chord_mm_(chord_mm) {
    const double round = band_.last - band_.first;
    for (const TowPiece& piece : ply.tows) {
      if (piece.band != band) continue;
      // Over the seam of a closed band a piece goes on from the start.
      if (piece.range.lo < band_.last)
        pieces_.push_back({piece.tow, {piece.range.lo, std::min(piece.range.hi, band_.last)}});
      if (band_.closed && piece.range.hi > band_.last)
        pieces_.push_back({piece.tow, {band_.first, piece.range.hi - round}});
    }
    width_mm_ = band_.edges.front().offset_mm - band_.edges[1].offset_mm;
  }

  std::vector<TowStrip> strips() const {
    std::vector<TowStrip> out;
    std::vector<LinePiece> pieces;
    for (std::size_t e = 0; e < band_.edges.size(); ++e)
      for (const SurfaceCurve& run : band_.edges[e].runs)
        for (const Nodes& nodes : run.pieces)
          if (nodes.size() > 1)
            pieces.push_back({e, &nodes, &nodes != &run.pieces.front(), &nodes != &run.pieces.back()});
    for (const Visit& visit : visits(pieces)) add(visit, out);
    return out;
  }

 private:
  struct Cut {
    int tow;
    Interval range;
  };

  std::vector<Visit> visits(const std::vector<LinePiece>& pieces) const {
    std::vector<std::size_t> group(pieces.size());
    std::iota(group.begin(), group.end(), std::size_t{0});
    const auto root = [&](std::size_t i) {
      while (group[i] != i) i = group[i];
      return i;
    };
    for (std::size_t i = 0; i < pieces.size(); ++i)
      for (std::size_t j = i + 1; j < pieces.size() && pieces[j].line <= pieces[i].line + 1; ++j)
        if (side_by_side(pieces[i], pieces[j])) {
          const std::size_t a = root(i), b = root(j);
          group[std::max(a, b)] = std::min(a, b);
        }
    std::vector<Visit> out;
    std::vector<std::size_t> place(pieces.size());
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      const std::size_t r = root(i);
      if (r == i) {
        place[i] = out.size();
        out.emplace_back().lines.resize(band_.edges.size());
      }
      Visit& visit = out[place[r]];
      visit.lines[pieces[i].line].push_back(&pieces[i]);
      visit.range = {std::min(visit.range.lo, pieces[i].first()), std::max(visit.range.hi, pieces[i].last())};
      visit.face = pieces[i].face();
      visit.at_pole = has_pole(visit.face);
      visit.normal_sign = pieces[i].nodes->front().normal_sign;
    }
    for (Visit& visit : out)
      for (auto& line : visit.lines)
        std::sort(line.begin(), line.end(),
                  [](const auto* a, const auto* b) { return a->first() < b->first(); });
    return out;
  }

  bool has_pole(int face) const {
    const std::vector<Loop>& loops = skin_.face(face).loops;
    for (int l = 0; l < static_cast<int>(loops.size()); ++l)
      for (int c = 0; c < static_cast<int>(loops[static_cast<std::size_t>(l)].coedges.size()); ++c)
        if (skin_.edge({face, l, c}).degenerate) return true;
    return false;
  }

  /// Whether two pieces belong to one chart: neighbours abreast, or one line's that goes on.
  bool side_by_side(const LinePiece& a, const LinePiece& b) const {
    if (a.face() != b.face() || a.nodes->front().normal_sign != b.nodes->front().normal_sign) return false;
    const double lo = std::max(a.first(), b.first()), hi = std::min(a.last(), b.last());
    if (a.line == b.line ? std::abs(hi - lo) > 1e-9 : !(hi > lo)) return false;
    const Uv at = point_at(*a.nodes, 0.5 * (lo + hi));
    const Uv off = point_at(*b.nodes, 0.5 * (lo + hi)) - at;
    const double apart = uv_to_tangent(skin_.derivatives({a.face(), at}), off).norm();
    return apart < (a.line == b.line ? 0.1 : 3.0) * width_mm_;
  }

  void add(const Visit& visit, std::vector<TowStrip>& out) const {
    std::vector<std::vector<Sample>> lines(visit.lines.size());
    for (std::size_t e = 0; e < lines.size(); ++e) lines[e] = samples(visit, e);
    for (const Cut& cut : pieces_)
      for (const Interval& range : stretches(visit, cut)) out.push_back(strip(visit, lines, cut, range));
  }

  /// Where a tow may lie on the chart: along its edges' pieces and a little beyond, for the tip of a face
  /// that reaches in between them.
  std::vector<Interval> stretches(const Visit& visit, const Cut& cut) const {
    std::vector<Interval> on;
    const auto j = static_cast<std::size_t>(cut.tow);
    const double reach = visit.at_pole ? 0 : tip * width_mm_;
    for (const std::size_t e : {j - 1, j})
      for (const LinePiece* piece : visit.lines[e])
        on.push_back({piece->first() - reach, piece->last() + reach});
    std::sort(on.begin(), on.end(), [](const Interval& a, const Interval& b) { return a.lo < b.lo; });
    std::vector<Interval> out;
    const double first = std::max(cut.range.lo, visit.range.lo);
    const double last = std::min(cut.range.hi, visit.range.hi);
    for (const Interval& i : on) {
      const double lo = std::max(i.lo, first), hi = std::min(i.hi, last);
      if (!(hi > lo)) continue;
      if (!out.empty() && lo <= out.back().hi)
        out.back().hi = std::max(out.back().hi, hi);
      else
        out.push_back({lo, hi});
    }
    return out;
  }

  TowStrip strip(const Visit& visit, const std::vector<std::vector<Sample>>& lines, const Cut& cut,
                 const Interval& range) const {
    const auto j = static_cast<std::size_t>(cut.tow);
    TowStrip out;
    out.face = visit.face;
    out.band = index_;
    out.course = band_.course;
    out.tow = cut.tow;
    out.turned = (skin_.face(visit.face).reversed ? -1 : 1) * visit.normal_sign < 0;
    out.whole = spans(visit.lines[j - 1], cut.range) && spans(visit.lines[j], cut.range);
    for (const Sample& s : lines[j - 1])
      if (s.t >= range.lo && s.t <= range.hi) out.left.push_back(s.uv);
    for (const Sample& s : lines[j])
      if (s.t >= range.lo && s.t <= range.hi) out.right.push_back(s.uv);
    if (range.lo == cut.range.lo) end_square(visit, j, range.lo, true, out);
    if (range.hi == cut.range.hi) end_square(visit, j, range.hi, false, out);
    return out;
  }

  static bool spans(const std::vector<const LinePiece*>& pieces, const Interval& range) {
    double to = range.lo;
    for (const LinePiece* piece : pieces)
      if (piece->first() <= to + 1e-9) to = std::max(to, piece->last());
    return to >= range.hi - 1e-9;
  }

  /// A cut is straight on the surface, not in (u, v): it goes by the tow's middle line. What is left of its
  /// sag, the bound of an arc's, goes into the error.
  void end_square(const Visit& visit, std::size_t j, double t, bool start, TowStrip& strip) const {
    const Uv left = start ? strip.left.front() : strip.left.back();
    const Uv right = start ? strip.right.front() : strip.right.back(), straight = 0.5 * (left + right);
    const SurfaceDerivatives d = skin_.derivatives({visit.face, straight});
    for (const SurfaceCurve& run : band_.middles[j - 1].runs)
      for (const Nodes& nodes : run.pieces) {
        if (nodes.size() < 2 || nodes.front().at.face != visit.face || t < nodes.front().t ||
            t > nodes.back().t)
          continue;
        const Uv middle = point_at(nodes, t);
        const double sag = uv_to_tangent(d, middle - straight).norm();
        if (sag > 0.5 * width_mm_) continue;  // another turn of the tow
        (start ? strip.start : strip.end) = middle;
        strip.ends_mm2 += sag * width_mm_ / 6;
        return;
      }
  }

  /// Points of a line over the visit: nodes, points between them, ends of pieces and cuts of the tows on
  /// either side; where the line is not on this chart those of its neighbours.
  std::vector<Sample> samples(const Visit& visit, std::size_t e) const {
    std::vector<double> at = {visit.range.lo, visit.range.hi};
    const auto& own = visit.lines[e];
    for (const LinePiece* piece : own) subdivide(*piece->nodes, at);
    if (!spans(own, visit.range))
      for (const std::size_t other : neighbours(visit, e))
        for (const LinePiece* piece : visit.lines[other])
          for (const CurveNode& node : *piece->nodes)
            if (!covering(own, node.t)) at.push_back(node.t);
    for (const Cut& cut : pieces_)
      if (const auto j = static_cast<std::size_t>(cut.tow); j == e || j == e + 1)
        for (const Interval& range : stretches(visit, cut)) {
          at.push_back(range.lo);
          at.push_back(range.hi);
        }
    std::sort(at.begin(), at.end());
    at.erase(std::unique(at.begin(), at.end()), at.end());
    std::vector<Sample> out;
    std::size_t next = 1;
    for (const double t : at) {
      for (; next < own.size() && own[next]->first() <= t; ++next)
        around_pole(*own[next - 1], *own[next], out);
      if (const LinePiece* piece = begins(own, t); piece && piece->comes)
        if (const auto pole = pole_near(piece->nodes->front().at)) out.push_back({t, *pole});
      out.push_back({t, on_line(visit, e, t)});
      if (const LinePiece* piece = ends(own, t); piece && piece->goes)
        if (const auto pole = pole_near(piece->nodes->back().at)) out.push_back({t, *pole});
    }
    return out;
  }

  /// The piece that begins at t, where none goes before; and the one that ends there, where none goes on.
  static const LinePiece* begins(const std::vector<const LinePiece*>& pieces, double t) {
    for (std::size_t i = 0; i < pieces.size(); ++i)
      if (pieces[i]->first() == t) return i > 0 && pieces[i - 1]->last() >= t - 1e-9 ? nullptr : pieces[i];
    return nullptr;
  }
  static const LinePiece* ends(const std::vector<const LinePiece*>& pieces, double t) {
    for (std::size_t i = 0; i < pieces.size(); ++i)
      if (pieces[i]->last() == t)
        return i + 1 < pieces.size() && pieces[i + 1]->first() <= t + 1e-9 ? nullptr : pieces[i];
    return nullptr;
  }

  /// Where a line leaves a face for its neighbour close to the pole that both share, the edge between them
  /// leads to the pole: what of the tow lies beyond is on other faces.
  std::optional<Uv> pole_near(const SurfacePoint& at) const {
    const Surface& surface = skin_.face(at.face).surface;
    const double reach = 3 * width_mm_ * static_cast<double>(band_.middles.size());
    const SurfaceDerivatives here = surface.derivatives(at.uv);
    for (int axis = 0; axis < 2; ++axis)
      for (const double end : {axis == 0 ? surface.domain_v().lo : surface.domain_u().lo,
                               axis == 0 ? surface.domain_v().hi : surface.domain_u().hi}) {
        if (!std::isfinite(end)) continue;
        Uv there = at.uv;
        there[1 - axis] = end;
        const SurfaceDerivatives d = surface.derivatives(there);
        const bool shrinks =
            axis == 0 ? d.Su.norm() < 1e-6 * here.Su.norm() : d.Sv.norm() < 1e-6 * here.Sv.norm();
        if (shrinks && (d.S - here.S).norm() < reach) return there;
      }
    return std::nullopt;
  }

  /// A line that goes on beyond a seam, while others of its band pass on the other side of the pole: by way
  /// of the pole. What two edges of one tow do both cancels out.
  void around_pole(const LinePiece& before, const LinePiece& after, std::vector<Sample>& out) const {
    const Surface& surface = skin_.face(before.face()).surface;
    const Uv from = before.nodes->back().at.uv, to = after.nodes->front().at.uv;
    const double periods[2] = {surface.period_u(), surface.period_v()};
    for (int axis = 0; axis < 2; ++axis) {
      if (periods[axis] <= 0 || std::abs(to[axis] - from[axis]) < 0.5 * periods[axis]) continue;
      const Interval ends = axis == 0 ? surface.domain_v() : surface.domain_u();
      double best = 1e300, pole = 0;
      for (const double end : {ends.lo, ends.hi}) {
        Uv there = from;
        there[1 - axis] = end;
        if (!std::isfinite(end) || std::abs(end - from[1 - axis]) > best) continue;
        const SurfaceDerivatives d = surface.derivatives(there), here = surface.derivatives(from);
        const Vec3 turn = axis == 0 ? d.Su : d.Sv, usual = axis == 0 ? here.Su : here.Sv;
        if (turn.norm() > 1e-6 * usual.norm()) continue;
        best = std::abs(end - from[1 - axis]);
        pole = end;
      }
      if (best > 1e299) return;
      Uv a = from, b = to;
      a[1 - axis] = b[1 - axis] = pole;
      const double t = before.last();
      for (const Uv& uv : {from, a, b, to}) out.push_back({t, uv});
    }
  }

  void subdivide(const Nodes& nodes, std::vector<double>& at) const {
    for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
      at.push_back(nodes[i].t);
      const UvCubic c = cubic(nodes, i);
      const SurfaceDerivatives d = skin_.derivatives(nodes[i].at);
      const double bend =
          std::max(uv_to_tangent(d, 2 * c.c).norm(), uv_to_tangent(d, 2 * c.c + 6 * c.d).norm());
      const int n = static_cast<int>(std::min(64.0, std::ceil(std::sqrt(bend / 8 / chord_mm_))));
      for (int k = 1; k < n; ++k) at.push_back(nodes[i].t + (nodes[i + 1].t - nodes[i].t) * k / n);
    }
    at.push_back(nodes.back().t);
  }

  /// Other lines of the visit, the nearest first, to the first on either side that is on the chart.
  static std::vector<std::size_t> neighbours(const Visit& visit, std::size_t e) {
    std::vector<std::size_t> out;
    std::size_t lo = e, hi = e + 1;
    while (lo > 0 && visit.lines[lo - 1].empty()) --lo;
    while (hi < visit.lines.size() && visit.lines[hi].empty()) ++hi;
    if (lo > 0) out.push_back(lo - 1);
    if (hi < visit.lines.size()) out.push_back(hi);
    return out;
  }
  static const LinePiece* covering(const std::vector<const LinePiece*>& pieces, double t) {
    for (const LinePiece* piece : pieces)
      if (t >= piece->first() && t <= piece->last()) return piece;
    return nullptr;
  }

  /// Where the line is not on this chart it goes straight on for a little, then beside the nearest that is
  /// there.
  Uv on_line(const Visit& visit, std::size_t e, double t) const {
    const std::size_t n = visit.lines.size();
    if (!visit.lines[e].empty()) {
      const LinePiece& own = nearest(visit.lines[e], t);
      const double way = visit.at_pole ? 0 : straight_on;
      if (std::max(own.first() - t, t - own.last()) < way * width_mm_) return beside(visit, own, e, t);
    }
    for (std::size_t step = 1; step < n; ++step)
      for (const std::size_t other : {e - step, e + step})  // a wrapped e - step is no line
        if (other < n)
          if (const LinePiece* piece = covering(visit.lines[other], t)) return beside(visit, *piece, e, t);
    for (std::size_t step = 0; step < n; ++step)
      for (const std::size_t other : {e - step, e + step})
        if (other < n && !visit.lines[other].empty())
          return beside(visit, nearest(visit.lines[other], t), e, t);
    return Uv::Zero();
  }
  Uv beside(const Visit& visit, const LinePiece& piece, std::size_t e, double t) const {
    const Nodes& nodes = *piece.nodes;
    const Uv uv = point_at(nodes, t);
    if (piece.line == e) return uv;
    const double ahead = 1e-3 * width_mm_;
    const Uv along = t + ahead > nodes.back().t ? Uv(uv - point_at(nodes, t - ahead))
                                                : Uv(point_at(nodes, t + ahead) - uv);
    const SurfaceDerivatives d = skin_.derivatives({visit.face, uv});
    const double sign = (skin_.face(visit.face).reversed ? -1 : 1) * visit.normal_sign;
    const Vec3 left = (sign * unit_normal(d)).cross(uv_to_tangent(d, along)).normalized();
    return uv + (band_.edges[e].offset_mm - band_.edges[piece.line].offset_mm) * tangent_to_uv(d, left);
  }
  static const LinePiece& nearest(const std::vector<const LinePiece*>& pieces, double t) {
    const auto off = [t](const LinePiece* p) { return std::max({p->first() - t, t - p->last(), 0.0}); };
    return **std::min_element(pieces.begin(), pieces.end(),
                              [&](auto* a, auto* b) { return off(a) < off(b); });
  }

  const Skin& skin_;
  const TowBand& band_;
  std::size_t index_;
  double chord_mm_, width_mm_ = 0;
  std::vector<Cut> pieces_;
};

}  // namespace

std::vector<TowStrip> tow_strips(const Skin& skin, const Ply& ply, double chord_mm) {
  std::vector<std::vector<TowStrip>> by_band(ply.bands.size());
  tbb::parallel_for(std::size_t{0}, by_band.size(),
                    [&](std::size_t b) { by_band[b] = BandStrips(skin, ply, b, chord_mm).strips(); });
  std::vector<TowStrip> out;
  for (auto& strips : by_band)
    for (TowStrip& strip : strips) out.push_back(std::move(strip));
  return out;
}

}  // namespace afptraj
