#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <tuple>
#include <utility>

#include <tbb/parallel_for.h>

#include "analysis/geodesic_way.h"
#include "analysis/judge_lines.h"

namespace afptraj {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::size_t worst_kept = 20;       // probes that are looked around
constexpr std::size_t screened_kept = 200;   // probes taken because their chords look wrong
constexpr double noticed_mm = 1e-5;          // below this it does not matter which way a geodesic ran

/// A point of a course, between two samples.
struct Probe {
  int line = 0;
  std::size_t chord = 0;
  double x = 0.5;
  auto key() const { return std::make_tuple(line, chord, x); }
};

enum class Outcome { measured, off_skin, beyond_end, unresolved };

struct Measured {
  Outcome outcome = Outcome::unresolved;
  double error_mm = 0;
  Vec3 where = Vec3::Zero();
};

/// What has been found on the way to one probe.
struct Nearest {
  double distance_mm = infinity;
  int line = -1;  ///< whose way it is; -1: that of an end
  Way way;
  bool end_off_skin = false;      ///< the way from the end runs over places without material
  double free_end_mm = infinity;  ///< nearest end on the boundary past which a foot would lie
  bool unsolved = false;
};

/// Chooses the level before that of `own`, of either side.
auto before(const CourseLine& own) {
  return [level = std::abs(own.course) - 1](const CourseLine& other) { return std::abs(other.course) == level; };
}

class SpacingJudge {
 public:
  SpacingJudge(const GeodesicTracer& tracer, const std::vector<CourseLine>& lines, const ChordIndex& index,
               const LineEnds& ends, double band_width_mm)
      : tracer_(tracer), lines_(lines), index_(index), ends_(ends), W_(band_width_mm) {}

  Measured measure(const Probe& probe) const {
    const CourseLine& own = line(probe.line);
    const CurveFrame at = own.frame(tracer_.skin(), probe.chord, probe.x);
    const Vec3& p = at.frame.position;
    // A geodesic is not shorter than its chord: what lies within 1.02 W is found by the first look.
    Nearest nearest = look(own, at, 1.02 * W_);
    if (!(nearest.distance_mm <= 1.02 * W_)) nearest = look(own, at, 2 * W_);
    Measured out;
    out.where = p;
    const bool past_end = nearest.distance_mm > W_ + noticed_mm && nearest.free_end_mm < nearest.distance_mm;
    // A course is the parallel on one side of the level before: left of it with a positive number. An extension that has
    // come round to the other side is nobody's parallel there, and must only not be nearer than W.
    const bool other_side = nearest.line >= 0 && own.course * nearest.way.side < 0 && nearest.distance_mm > W_;
    if (past_end || other_side || nearest.distance_mm == infinity) {
      out.outcome = nearest.unsolved && !past_end && !other_side ? Outcome::unresolved : Outcome::beyond_end;
      return out;
    }
    out.outcome = Outcome::measured;
    out.error_mm = std::abs(nearest.distance_mm - W_);
    if (out.error_mm > noticed_mm &&
        (nearest.line >= 0 ? leaves_skin(tracer_, line(nearest.line), nearest.way) : nearest.end_off_skin))
      out.outcome = Outcome::off_skin;
    return out;
  }

  /// The error as chords show it, corrected for the turn of the normal.
  double guess(const Probe& probe) const {
    const CourseLine& own = line(probe.line);
    const CurveFrame at = own.frame(tracer_.skin(), probe.chord, probe.x);
    double least = infinity;
    index_.visit_near(at.frame.position, 1.02 * W_, before(own), [&](const ChordIndex::Hit& hit) {
      const double cosine = line(hit.line).normals[hit.chord].dot(at.frame.normal);
      if (cosine > 0) least = std::min(least, arc_of(hit.distance_mm, cosine));
    });
    return std::min(W_, std::abs(least - W_));
  }

 private:
  const CourseLine& line(int i) const { return lines_[static_cast<std::size_t>(i)]; }

  Nearest look(const CourseLine& own, const CurveFrame& at, double reach_mm) const {
    thread_local std::vector<ChordIndex::Hit> hits;
    index_.minima(at.frame.position, reach_mm, before(own), hits);
    Nearest nearest;
    std::vector<const ChordIndex::Hit*> solved;
    for (const ChordIndex::Hit& hit : hits) {
      if (hit.distance_mm >= nearest.distance_mm) break;
      // Where a line runs round the probe, chords beside each other all have a minimum.
      const bool known = std::any_of(solved.begin(), solved.end(), [&](const ChordIndex::Hit* other) {
        return other->line == hit.line && std::max(other->chord, hit.chord) - std::min(other->chord, hit.chord) <= 2;
      });
      if (!known && solve(hit, at, nearest)) solved.push_back(&hit);
    }
    return nearest;
  }

  /// Takes the way from one candidate into `nearest`; whether it has a foot.
  bool solve(const ChordIndex::Hit& hit, const CurveFrame& at, Nearest& nearest) const {
    const CourseLine& from = line(hit.line);
    const Vec3& p = at.frame.position;
    const double t = from.t_at(hit.chord, hit.x);
    const double cosine = from.normals[hit.chord].dot(at.frame.normal);
    const bool facing = cosine > 0.3;
    // An end is believed only from where the chords say so: from elsewhere the search was led astray.
    const bool at_first = !from.closed() && (t <= from.t[1] || t - from.t.front() < 0.25 * W_);
    const bool at_last = !from.closed() && (t >= from.t[from.t.size() - 2] || from.t.back() - t < 0.25 * W_);
    const auto believed = [&](const Way& way) {
      return way.end == Way::End::foot || (at_first && way.t <= from.t.front()) || (at_last && way.t >= from.t.back());
    };
    Way best;
    const auto attempt = [&](const WaySeed& seed) {
      const Way way = way_from_line(tracer_, from, seed, p);
      const bool better = way.end == Way::End::foot ? best.end != Way::End::foot || way.distance_mm < best.distance_mm
                                                    : best.end == Way::End::failed;
      if (better && believed(way)) best = way;
    };
    if (facing) {
      const CurveFrame foot = frame_at(tracer_.skin(), from.curve, t);
      const double side = (p - foot.frame.position).dot(foot.frame.left()) >= 0 ? 1 : -1;
      attempt({t, arc_of(hit.distance_mm, cosine), side});
      if (best.end == Way::End::failed) attempt({t, W_, side});
      if (best.end == Way::End::failed)
        for (const double shift : {-0.5, 0.5}) attempt({t + shift * W_, W_, side});
      if (best.end == Way::End::failed) attempt({t, W_, -side});
      const double arc = arc_of(hit.distance_mm, cosine);
      if (best.end == Way::End::failed || best.distance_mm > arc + 0.01 * W_) {
        const Way way = way_by_search(tracer_, from, t, 0.25 * W_, p, arc);
        if (way.end == Way::End::foot && (best.end != Way::End::foot || way.distance_mm < best.distance_mm)) best = way;
      }
    } else {
      // The way leads round an edge; its chord says nothing.
      for (const double side : {1.0, -1.0}) attempt({t, W_, side});
    }
    if (best.end == Way::End::foot) {
      if (best.distance_mm < nearest.distance_mm) {
        nearest.distance_mm = best.distance_mm;
        nearest.line = hit.line;
        nearest.way = best;
      }
      return true;
    }
    if (best.end == Way::End::beyond_end)
      take_end(hit, best.t >= from.t.back(), at, facing, nearest);
    else if (at_first || at_last)
      take_end(hit, !at_first, at, facing, nearest);  // no way from the end: as far as its chord
    else
      nearest.unsolved = nearest.unsolved || facing;
    return false;
  }

  /// The foot would lie past an end. An end inside the skin is the nearest point of its line; one on the
  /// boundary is nearest only until the line's continuation is, and too near in any case below W.
  void take_end(const ChordIndex::Hit& hit, bool last, const CurveFrame& at, bool facing, Nearest& nearest) const {
    const CourseLine& from = line(hit.line);
    const LineEnd end = ends_[static_cast<std::size_t>(hit.line)][last ? 1 : 0];
    const bool free = from.off_skin || end == LineEnd::boundary;
    if (free) nearest.free_end_mm = std::min(nearest.free_end_mm, hit.distance_mm);
    if (!facing || (free && hit.distance_mm >= W_)) return;
    const CurveFrame corner = frame_at(tracer_.skin(), from.curve, last ? from.t.back() : from.t.front());
    const auto way = way_from_point(tracer_, corner, at.frame.position, std::max(hit.distance_mm, 1e-6));
    nearest.unsolved = nearest.unsolved || (!way && !free);
    if (!way || way->distance_mm >= nearest.distance_mm || (free && way->distance_mm >= W_)) return;
    nearest.distance_mm = way->distance_mm;
    nearest.line = -1;
    nearest.end_off_skin = from.off_skin || way->leaves_skin;
  }

  const GeodesicTracer& tracer_;
  const std::vector<CourseLine>& lines_;
  const ChordIndex& index_;
  const LineEnds& ends_;
  double W_;
};

/// Every chord of the courses beside the reference, at its middle.
std::vector<Probe> all_probes(const std::vector<CourseLine>& lines) {
  std::vector<Probe> out;
  for (std::size_t l = 0; l < lines.size(); ++l) {
    if (lines[l].off_skin || lines[l].course == 0) continue;
    for (std::size_t c = 0; c < lines[l].chord_count(); ++c) out.push_back({static_cast<int>(l), c});
  }
  return out;
}

/// The probes measured so far, none twice.
class Survey {
 public:
  Survey(const SpacingJudge& judge, const std::vector<CourseLine>& lines) : judge_(judge), lines_(lines) {}

  void measure(const std::vector<Probe>& wanted) {
    std::vector<Probe> fresh;
    for (const Probe& probe : wanted)
      if (known_.insert(probe.key()).second) fresh.push_back(probe);
    const std::size_t done = results_.size();
    probes_.insert(probes_.end(), fresh.begin(), fresh.end());
    results_.resize(done + fresh.size());
    tbb::parallel_for(std::size_t{0}, fresh.size(), [&](std::size_t i) { results_[done + i] = judge_.measure(fresh[i]); });
  }

  /// Measures the worst again, by a judge that is more exact.
  void confirm(const SpacingJudge& exact, std::size_t count) {
    const std::vector<std::size_t> order = worst_indices(count);
    tbb::parallel_for(std::size_t{0}, order.size(),
                      [&](std::size_t i) { results_[order[i]] = exact.measure(probes_[order[i]]); });
  }

  /// The probes with the greatest errors.
  std::vector<Probe> worst(std::size_t count) const {
    std::vector<Probe> out;
    for (const std::size_t i : worst_indices(count)) out.push_back(probes_[i]);
    return out;
  }

  SpacingError summary() const {
    SpacingError out;
    for (std::size_t i = 0; i < results_.size(); ++i) {
      const Measured& m = results_[i];
      if (m.outcome == Outcome::beyond_end) ++out.beyond_end;
      if (m.outcome == Outcome::off_skin) {
        ++out.off_skin;
        out.off_skin_worst_mm = std::max(out.off_skin_worst_mm, m.error_mm);
      }
      if (m.outcome == Outcome::unresolved && out.unresolved++ == 0) out.first_unresolved = m.where;
      if (m.outcome != Outcome::measured) continue;
      ++out.measured;
      if (m.error_mm <= out.worst_mm) continue;
      out.worst_mm = m.error_mm;
      out.worst_course = lines_[static_cast<std::size_t>(probes_[i].line)].course;
      out.where = m.where;
    }
    return out;
  }

 private:
  std::vector<std::size_t> worst_indices(std::size_t count) const {
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < results_.size(); ++i)
      if (results_[i].outcome == Outcome::measured) order.push_back(i);
    count = std::min(count, order.size());
    std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end(),
                      [&](std::size_t a, std::size_t b) {
                        return std::make_pair(-results_[a].error_mm, a) < std::make_pair(-results_[b].error_mm, b);
                      });
    order.resize(count);
    return order;
  }

  const SpacingJudge& judge_;
  const std::vector<CourseLine>& lines_;
  std::set<std::tuple<int, std::size_t, double>> known_;
  std::vector<Probe> probes_;
  std::vector<Measured> results_;
};

/// The first and last chord of each line, and others evenly spread.
std::vector<Probe> spread(const std::vector<Probe>& all, const std::vector<CourseLine>& lines, std::size_t stride) {
  std::vector<Probe> out;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Probe& probe = all[i];
    const bool at_end = probe.chord == 0 || probe.chord + 1 == lines[static_cast<std::size_t>(probe.line)].chord_count();
    if (at_end || i % stride == stride / 2) out.push_back(probe);
  }
  return out;
}

/// Those whose chords look farthest from W.
std::vector<Probe> suspects(const SpacingJudge& judge, const std::vector<Probe>& all) {
  std::vector<std::pair<double, std::size_t>> guesses(all.size());
  tbb::parallel_for(std::size_t{0}, all.size(), [&](std::size_t i) { guesses[i] = {-judge.guess(all[i]), i}; });
  const std::size_t count = std::min(screened_kept, guesses.size());
  std::partial_sort(guesses.begin(), guesses.begin() + static_cast<std::ptrdiff_t>(count), guesses.end());
  std::vector<Probe> out;
  for (std::size_t i = 0; i < count; ++i) out.push_back(all[guesses[i].second]);
  return out;
}

std::vector<Probe> around(const std::vector<Probe>& probes, const std::vector<CourseLine>& lines, std::size_t reach) {
  std::vector<Probe> out;
  for (const Probe& probe : probes) {
    const std::size_t count = lines[static_cast<std::size_t>(probe.line)].chord_count();
    const std::size_t begin = probe.chord > reach ? probe.chord - reach : 0;
    for (std::size_t c = begin; c < std::min(probe.chord + reach + 1, count); ++c) out.push_back({probe.line, c});
  }
  return out;
}

}  // namespace

SpacingError measure_spacing(const GeodesicTracer& tracer, const std::vector<CourseLine>& lines,
                             const ChordIndex& index, const LineEnds& ends, const JudgeOptions& options) {
  const SpacingJudge judge(tracer, lines, index, ends, options.band_width_mm);
  const std::vector<Probe> all = all_probes(lines);
  const auto budget = static_cast<std::size_t>(std::max(1, options.spacing_samples));
  const std::size_t stride = (all.size() + budget - 1) / budget;
  Survey survey(judge, lines);
  survey.measure(stride > 1 ? spread(all, lines, stride) : all);
  if (stride > 1) {
    survey.measure(suspects(judge, all));
    survey.measure(around(survey.worst(worst_kept), lines, std::clamp<std::size_t>(stride, 4, 64)));
    survey.measure(around(survey.worst(worst_kept), lines, 4));
  }
  std::vector<Probe> within;
  for (const Probe& probe : survey.worst(worst_kept))
    for (const double x : {0.1, 0.3, 0.7, 0.9}) within.push_back({probe.line, probe.chord, x});
  survey.measure(within);
  // A walk is too short or too long by about ten times its tolerance: what is reported is measured again.
  const GeodesicTracer fine(tracer.skin(), judge_geodesics(tracer.skin(), options.band_width_mm, 1e-3 * options.tolerance_mm));
  survey.confirm(SpacingJudge(fine, lines, index, ends, options.band_width_mm), 2 * worst_kept);
  return survey.summary();
}

}  // namespace afptraj
