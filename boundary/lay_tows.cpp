#include "boundary/lay_tows.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <tbb/parallel_for.h>

#include "boundary/clip.h"

namespace afptraj {
namespace {

constexpr double least_on_skin_mm = 1e-3;

/// Arc length along a curve and its inverse.
class ArcLength {
 public:
  ArcLength(const Skin& skin, const SurfaceCurve& curve) : skin_(skin), curve_(curve) {
    double s = 0;
    for (std::size_t p = 0; p < curve.pieces.size(); ++p)
      for (std::size_t i = 0; i + 1 < curve.pieces[p].size(); ++i) {
        spans_.push_back({p, i, s});
        s += arc_length(skin, curve.pieces[p], i, 0, 1);
      }
    length_ = s;
  }
  double length() const { return length_; }

  double at(double t) const {
    if (t <= curve_.first()) return 0;
    if (t >= curve_.last()) return length_;
    const auto after = [&](const Span& span) { return node(span).t <= t; };
    const Span& span = *(std::partition_point(spans_.begin(), spans_.end(), after) - 1);
    return span.s + part(span, (t - node(span).t) / width(span));
  }
  double t_at(double s) const {
    if (s <= 0) return curve_.first();
    if (s >= length_) return curve_.last();
    const auto after = [&](const Span& span) { return span.s <= s; };
    const auto it = std::partition_point(spans_.begin(), spans_.end(), after) - 1;
    const double end = it + 1 == spans_.end() ? length_ : (it + 1)->s;
    const double all = end - it->s;
    double x = all > 0 ? (s - it->s) / all : 0;
    // Speed is nearly constant within a span: each step of Newton-Raphson with the mean speed gains two digits.
    for (int i = 0; i < 20 && all > 0; ++i) {
      const double off = s - it->s - part(*it, x);
      x = std::clamp(x + off / all, 0.0, 1.0);
      if (std::abs(off) < 1e-10) break;
    }
    return node(*it).t + x * width(*it);
  }

 private:
  struct Span {
    std::size_t piece, node;
    double s;
  };
  const CurveNode& node(const Span& span) const { return curve_.pieces[span.piece][span.node]; }
  double width(const Span& span) const { return curve_.pieces[span.piece][span.node + 1].t - node(span).t; }
  double part(const Span& span, double x) const {
    return x > 0 ? arc_length(skin_, curve_.pieces[span.piece], span.node, 0, x) : 0;  // most are asked for at nodes
  }

  const Skin& skin_;
  const SurfaceCurve& curve_;
  std::vector<Span> spans_;
  double length_ = 0;
};

Stretches runs_of(const TowLine& line) {
  Stretches out;
  for (const SurfaceCurve& run : line.runs) out.push_back({run.first(), run.last()});
  return out;
}

Stretches common(const Stretches& a, const Stretches& b) {
  Stretches out;
  for (const Interval& x : a)
    for (const Interval& y : b)
      if (std::min(x.hi, y.hi) > std::max(x.lo, y.lo)) out.push_back({std::max(x.lo, y.lo), std::min(x.hi, y.hi)});
  return out;
}

/// Samples of a tow's middle line over `range`, which may run over the end of a closed line.
std::vector<TowSample> samples_of(const Skin& skin, const SurfaceCurve& middle, const ArcLength& arc,
                                  const Interval& range, double start_s) {
  const double round = middle.last() - middle.first(), close = 1e-6 * range.length();
  std::vector<double> at = {range.lo};
  for (const double turn : {0.0, round})
    for (const auto& piece : middle.pieces)
      for (const CurveNode& node : piece)
        if (const double t = node.t + turn; t > at.back() + close && t < range.hi - close) at.push_back(t);
  at.push_back(range.hi);
  std::vector<TowSample> out;
  out.reserve(at.size());
  for (const double t : at) {
    const bool beyond = t > middle.last() + 1e-9 * round;
    const double here = beyond ? t - round : t;
    const CurveFrame frame = frame_at(skin, middle, here);
    TowSample sample;
    sample.at = frame.at;
    sample.s_mm = arc.at(here) + (beyond ? arc.length() : 0) - start_s;
    sample.position = frame.frame.position;
    sample.normal = frame.frame.normal;
    sample.tangent = frame.frame.tangent;
    sample.kg_per_mm = frame.kg_per_mm;
    sample.on_skin = skin.trim(frame.at.face).contains(frame.at.uv);
    out.push_back(sample);
  }
  out.front().s_mm = 0;
  return out;
}

struct TowOfBand {
  std::vector<TowPiece> pieces;
  int bridged = 0, extended = 0, dropped = 0;
};

class TowCutter {
 public:
  TowCutter(const Skin& skin, const CutRule& rule) : skin_(skin), rule_(rule) {}

  std::vector<TowOfBand> cut(const TowBand& band) const {
    std::vector<Stretches> edges;
    for (const TowLine& line : band.edges) edges.push_back(on_skin(skin_, line));
    std::vector<TowOfBand> out(band.middles.size());
    for (std::size_t j = 0; j < out.size(); ++j) {
      TowCover cover;
      cover.left = edges[j];
      cover.right = edges[j + 1];
      cover.middle = on_skin(skin_, band.middles[j]);
      const double p = rule_.coverage_rule;
      cover.from_left = p <= 0 ? cover.left : p >= 1 ? cover.right : cover.middle;
      cover.from_right = p <= 0 ? cover.right : p >= 1 ? cover.left : cover.middle;
      if (!band.from_left.empty()) {
        cover.from_left = on_skin(skin_, band.from_left[j]);
        cover.from_right = on_skin(skin_, band.from_right[j]);
      }
      lay(band, j, apply_rule(cover, p), out[j]);
    }
    return out;
  }

 private:
  void lay(const TowBand& band, std::size_t j, const Stretches& wanted, TowOfBand& out) const {
    if (wanted.empty()) return;
    const Stretches ground = common(runs_of(band.edges[j]), runs_of(band.edges[j + 1]));
    for (const SurfaceCurve& middle : band.middles[j].runs)
      for (const Interval& run : common(ground, {{middle.first(), middle.last()}})) {
        const ArcLength arc(skin_, middle);
        TowRun way;
        way.range = {arc.at(run.lo), arc.at(run.hi)};
        way.closed = middle.closed && run.length() >= 0.999999 * (middle.last() - middle.first());
        Stretches pieces;
        for (const Interval& i : common(wanted, {run})) pieces.push_back({arc.at(i.lo), arc.at(i.hi)});
        const CutResult settled = settle_pieces(pieces, way, rule_);
        out.bridged += settled.bridged;
        out.extended += settled.extended;
        out.dropped += settled.dropped;
        for (const Interval& s : settled.pieces) {
          TowPiece piece;
          piece.course = band.course;
          piece.tow = static_cast<int>(j) + 1;
          const double round = middle.last() - middle.first();
          const auto t_at = [&](double x) { return x > arc.length() ? round + arc.t_at(x - arc.length()) : arc.t_at(x); };
          piece.range = {t_at(s.lo), t_at(s.hi)};
          piece.closed = way.closed && s.length() >= way.range.length() - 1e-9;
          piece.samples = samples_of(skin_, middle, arc, piece.range, s.lo);
          out.pieces.push_back(std::move(piece));
        }
      }
  }

  const Skin& skin_;
  const CutRule& rule_;
};

TowReport report_of(const std::vector<TowPiece>& pieces) {
  TowReport out;
  out.pieces = static_cast<int>(pieces.size());
  out.adds = out.cuts = out.pieces;
  std::set<std::pair<int, int>> tows;
  for (const TowPiece& piece : pieces) {
    tows.insert({piece.course, piece.tow});
    const double length = piece.length_mm();
    out.length_mm += length;
    out.shortest_mm = out.shortest_mm == 0 ? length : std::min(out.shortest_mm, length);
    out.longest_mm = std::max(out.longest_mm, length);
    for (const TowSample& sample : piece.samples)
      if (sample.on_skin && std::abs(sample.kg_per_mm) * out.tightest.radius_mm > 1)
        out.tightest = {1 / std::abs(sample.kg_per_mm), piece.course, piece.tow, sample.position};
  }
  out.tows = static_cast<int>(tows.size());
  return out;
}

}  // namespace

LaidTows lay_tows(const Skin& skin, const std::vector<LevelCurve>& levels, const TowLineOptions& options,
                  const CutRule& rule, bool keep_bands) {
  std::vector<std::pair<int, const SurfaceCurve*>> curves;
  for (const LevelCurve& level : levels)
    for (const SurfaceCurve& curve : level.curves) curves.emplace_back(level.number, &curve);
  struct Made {
    bool any = false;
    TowBand band;
    std::vector<TowOfBand> tows;
  };
  std::vector<Made> made(curves.size());
  const TowBandMaker maker(skin, options);
  const TowCutter cutter(skin, rule);
  tbb::parallel_for(std::size_t{0}, made.size(), [&](std::size_t i) {
    std::optional<TowBand> band = maker.band(curves[i].first, *curves[i].second);
    if (!band) return;
    made[i].any = true;
    made[i].tows = cutter.cut(*band);
    if (keep_bands) made[i].band = std::move(*band);
  });
  LaidTows out;
  int bridged = 0, extended = 0, dropped = 0;
  std::size_t bands = 0;
  for (Made& one : made) {
    if (!one.any) continue;
    for (TowOfBand& tow : one.tows) {
      bridged += tow.bridged;
      extended += tow.extended;
      dropped += tow.dropped;
      for (TowPiece& piece : tow.pieces) {
        piece.band = bands;
        out.pieces.push_back(std::move(piece));
      }
    }
    if (keep_bands) out.bands.push_back(std::move(one.band));
    ++bands;
  }
  std::stable_sort(out.pieces.begin(), out.pieces.end(), [](const TowPiece& a, const TowPiece& b) {
    return std::make_pair(a.course, a.tow) < std::make_pair(b.course, b.tow);
  });
  for (std::size_t i = 1; i < out.pieces.size(); ++i)
    if (out.pieces[i].course == out.pieces[i - 1].course && out.pieces[i].tow == out.pieces[i - 1].tow)
      out.pieces[i].segment = out.pieces[i - 1].segment + 1;
  out.report = report_of(out.pieces);
  out.report.bridged = bridged;
  out.report.extended = extended;
  out.report.dropped = dropped;
  return out;
}

Stretches on_skin(const Skin& skin, const TowLine& line) {
  Stretches out;
  for (SurfaceCurve run : line.runs) {
    run.closed = false;
    for (const SurfaceCurve& stretch : clip_to_skin(skin, run, least_on_skin_mm))
      out.push_back({stretch.first(), stretch.last()});
  }
  return out;
}

std::optional<CurveFrame> frame_on(const Skin& skin, const TowLine& line, double t) {
  for (const SurfaceCurve& run : line.runs) {
    const double slack = 1e-9 * (run.last() - run.first());
    if (t >= run.first() - slack && t <= run.last() + slack) return frame_at(skin, run, t);
  }
  return std::nullopt;
}

}  // namespace afptraj
