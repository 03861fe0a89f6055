#include "trajectory/lost_fronts.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "trajectory/level_curve.h"

namespace afptraj {
namespace {

constexpr double same_place_mm = 1e-9;  // along a laid curve
constexpr double beyond_mm = 1e-4;      // past a stop, which is located to 1e-7: safely beyond

double parent_first(const Strand& strand) { return strand.rays.front().t + strand.parent_offset; }
double parent_last(const Strand& strand) { return strand.rays.back().t + strand.parent_offset; }

/// The curve that stopped a strand at end `e`.
std::optional<LaidCurves::Rival> stopped_by(const Front& front, const Strand& strand, int e, int level,
                                            const LaidCurves& laid) {
  const Ray& end = e == 0 ? strand.rays.front() : strand.rays.back();
  bool alive = false;
  const Ray beyond = front.shoot(strand.source, end.t + (e == 0 ? -beyond_mm : beyond_mm), level, &alive);
  if (!alive) return std::nullopt;
  const PathFrame at = frame_of(front.skin(), beyond.state);
  const bool plain = end.state.y > 0.5;
  return laid.rival(front.probe_tracer(), at.position, at.normal, front.options().spacing_mm,
                    plain ? strand.parent : -1, plain ? end.t + strand.parent_offset : 0,
                    plain ? 1.5 * front.options().sample_mm : 0);
}

/// The strand of the rays of `source` at this level whose run is nearest to its parameter t.
std::optional<Strand> strand_of(const Front& front, int source, double t, int level) {
  const SourceCurve& curve = *front.source(source).curve;
  Strand strand;
  strand.source = source;
  const double length = curve.last() - curve.first();
  const int n = std::max(2, static_cast<int>(std::ceil(length / front.options().sample_mm)));
  std::vector<char> alive;
  for (int i = 0; i <= n; ++i) {
    bool ok = false;
    strand.rays.push_back(front.shoot(source, curve.first() + length * i / n, level, &ok));
    alive.push_back(ok);
  }
  std::optional<Strand> nearest;
  double least = 1e300;
  for (Strand& run : front.alive_runs(strand, alive, level)) {
    const double off = std::max({0.0, run.rays.front().t - t, t - run.rays.back().t});
    if (off >= least) continue;
    least = off;
    nearest = std::move(run);
  }
  if (nearest) front.refine(*nearest, level);
  return nearest;
}

class LostFronts {
 public:
  LostFronts(const std::array<Front*, 2>& fronts, const std::array<std::vector<Strand>, 2>& untrimmed,
             int level, LaidCurves& laid)
      : fronts_(fronts), untrimmed_(untrimmed), level_(level), laid_(laid) {}

  std::array<std::vector<Strand>, 2> find() {
    for (const Front* front : fronts_)
      for (const Strand& strand : front->strands())
        for (int e = 0; e < 2; ++e)
          if (strand.end[e] == StrandEnd::stopped) {
            const auto rival = stopped_by(*front, strand, e, level_, laid_);
            if (rival) go_on_from(*rival);
          }
    for (std::size_t f = 0; f < 2; ++f) lay_behind(f);
    return std::move(found_);
  }

 private:
  /// Goes on from the end of the curve near which the foot stands, if it does.
  void go_on_from(const LaidCurves::Rival& rival) {
    const int number = laid_.number(rival.curve);
    const double distance = rival.foot.distance_mm;
    // Only the level before, and from the side to which it has not been.
    if (std::abs(number) != level_ - 1 || number * distance < 0) return;
    const std::size_t f = distance > 0 ? 0 : 1;
    const SurfaceCurve& curve = laid_.curve(rival.curve);
    if (curve.closed) return;
    const double t = rival.foot.t;
    const int e = t - curve.first() < curve.last() - t ? 0 : 1;
    const double end = e == 0 ? curve.first() : curve.last();
    if (std::abs(end - t) > fronts_[f]->options().spacing_mm) return;
    if (std::any_of(done_.begin(), done_.end(),
                    [&](const Done& d) { return d.front == f && d.curve == rival.curve && d.end == e; }))
      return;
    done_.push_back({f, rival.curve, e});
    add_uncovered(f, rival.curve, e);
    add_continuation(f, rival.curve, e);
  }

  /// The stretch of the curve up to its end from which no ray has come.
  void add_uncovered(std::size_t f, int index, int e) {
    const SurfaceCurve& curve = laid_.curve(index);
    double first = curve.first(), last = curve.last();
    for (const Strand& strand : untrimmed_[f]) {
      if (strand.parent != index) continue;
      if (e == 0) last = std::min(last, parent_first(strand));
      if (e == 1) first = std::max(first, parent_last(strand));
    }
    if (last - first < 1e-3) return;
    const int source = fronts_[f]->add_source(
        std::make_shared<LaidPath>(fronts_[f]->skin(), curve, first, last), level_ - 1, true);
    add(f, source, e == 0 ? first : last, index, 0);
  }

  /// The continuation of the curve outside, along its geodesic.
  void add_continuation(std::size_t f, int index, int e) {
    const Front& front = *fronts_[f];
    const SurfaceCurve& curve = laid_.curve(index);
    const double end = e == 0 ? curve.first() : curve.last();
    const CurveFrame frame = frame_at(front.skin(), curve, end);
    const bool outside = !front.skin().trim(frame.at.face).contains(frame.at.uv);
    GeodesicState g =
        front.wide_tracer().start(frame.at, e == 0 ? Vec3(-frame.frame.tangent) : frame.frame.tangent,
                                  frame.normal_sign, 1, 0, outside);
    std::vector<GeodesicState> states = {g};
    const double step = front.options().sample_mm;
    while (g.s_mm < 2 * front.options().spacing_mm &&
           front.wide_tracer().advance(g, step) == TraceEnd::reached && g.outside)
      states.push_back(g);
    if (states.size() < 2) return;
    const int source = fronts_[f]->add_source(
        std::make_shared<GeodesicPath>(front.wide_tracer(), std::move(states), e == 0), level_ - 1, true);
    add(f, source, 0, index, end);
  }

  void add(std::size_t f, int source, double near_t, int parent, double offset) {
    auto strand = strand_of(*fronts_[f], source, near_t, level_);
    if (!strand) return;
    strand->parent = parent;
    strand->parent_offset = offset;
    found_[f].push_back(std::move(*strand));
    if (auto behind = strand_of(*fronts_[f], source, near_t, level_ - 1))
      behind_[f].push_back(std::move(*behind));
  }

  /// What the fronts come from has been laid too: what they sweep is swept.
  void lay_behind(std::size_t f) {
    if (behind_[f].empty()) return;
    Front front = *fronts_[f];
    front.strands() = std::move(behind_[f]);
    for (ChainedCurve& chain : level_curves(front.wide_tracer(), front, level_ - 1))
      laid_.add(std::move(chain.curve), front.side() * (level_ - 1), &fronts_[f]->wide_tracer());
  }

  struct Done {
    std::size_t front;
    int curve, end;
  };
  std::array<Front*, 2> fronts_;
  const std::array<std::vector<Strand>, 2>& untrimmed_;
  int level_;
  LaidCurves& laid_;
  std::array<std::vector<Strand>, 2> found_, behind_;
  std::vector<Done> done_;
};

}  // namespace

std::array<std::vector<Strand>, 2> lost_fronts(const std::array<Front*, 2>& fronts,
                                               const std::array<std::vector<Strand>, 2>& untrimmed, int level,
                                               LaidCurves& laid) {
  return LostFronts(fronts, untrimmed, level, laid).find();
}

void recall(Front& front, std::vector<Strand> untrimmed, const std::vector<Strand>& lost, int& next_link) {
  front.strands() = std::move(untrimmed);
  for (Strand strand : lost) {
    for (Strand& other : front.strands()) {
      if (other.parent != strand.parent) continue;
      if (other.end[1] == StrandEnd::open && strand.end[0] == StrandEnd::open &&
          std::abs(parent_last(other) - parent_first(strand)) < same_place_mm)
        Front::join(other, 1, strand, next_link++);
      if (other.end[0] == StrandEnd::open && strand.end[1] == StrandEnd::open &&
          std::abs(parent_first(other) - parent_last(strand)) < same_place_mm)
        Front::join(other, 0, strand, next_link++);
    }
    front.add_strand(std::move(strand));
  }
}

}  // namespace afptraj
