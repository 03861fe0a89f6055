#include "trajectory/trim_front.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "trajectory/front_crossings.h"

namespace afptraj {
namespace {

constexpr double least_y = 0.01;           // a stretch ends this short of a focal point
constexpr double end_tolerance_mm = 1e-7;  // how closely an end between probes is located

constexpr int no_meeting = -1;  // of an end that is the strand's own
constexpr int lone_cut = -2;    // of a cut that no other branch ends at

/// Where a strand is cut, and which of the two branches goes on.
struct Cut {
  Ray ray;
  bool before = false, after = false;  ///< whether the branch on that side may be kept
  int meeting = lone_cut;              ///< number of the meeting; none at a cusp or within what was swept
};

struct Stretch {
  std::vector<Ray> rays;
  const Cut* cut[2] = {nullptr, nullptr};  ///< null: the strand's own end
};

class Trimmer {
 public:
  Trimmer(const std::array<Front*, 2>& fronts, int level, const LaidCurves& laid)
      : fronts_(fronts), level_(level), laid_(laid) {}

  void trim() {
    std::array<std::vector<std::vector<Cut>>, 2> cuts;
    for (std::size_t f = 0; f < 2; ++f)
      if (fronts_[f]) cuts[f].resize(fronts_[f]->strands().size());
    cut_at_crossings(cuts);
    for (std::size_t f = 0; f < 2; ++f) {
      if (!fronts_[f]) continue;
      std::vector<Strand> kept;
      const std::vector<Strand>& strands = fronts_[f]->strands();
      for (std::size_t s = 0; s < strands.size(); ++s) {
        if (strands[s].trimmed && cuts[f][s].empty()) {
          kept.push_back(strands[s]);
          continue;
        }
        cut_at_cusps(*fronts_[f], strands[s], cuts[f][s]);
        keep_stretches(*fronts_[f], strands[s], cuts[f][s], kept);
      }
      fronts_[f]->strands() = std::move(kept);
    }
    open_lone_corners();
    for (Front* front : fronts_) {
      if (!front) continue;
      front->settle_links();
      drop_severed_extensions(*front);
    }
  }

 private:
  void cut_at_crossings(std::array<std::vector<std::vector<Cut>>, 2>& cuts) {
    const auto crossings = front_crossings({fronts_[0], fronts_[1]}, level_);
    const std::vector<char> reached = reached_by_extensions(crossings);
    for (std::size_t c = 0; c < crossings.size(); ++c) {
      if (!reached[c]) continue;
      // The reference itself is laid as it is; only its extensions are cut.
      if (level_ == 0 && strand(crossings[c].place[0]).fresh_end < 0 &&
          strand(crossings[c].place[1]).fresh_end < 0)
        continue;
      const FrontCrossing& x = crossings[c];
      PathFrame frame[2];
      Vec3 along[2];
      for (std::size_t k = 0; k < 2; ++k) {
        const Front& front = *fronts_[static_cast<std::size_t>(x.place[k].front)];
        frame[k] = frame_of(front.skin(), x.ray[k].state);
        along[k] = front.side() * frame[k].tangent.cross(frame[k].normal);
      }
      const bool meeting = is_meeting(x);
      for (std::size_t k = 0; k < 2; ++k) {
        Cut cut;
        cut.ray = x.ray[k];
        if (level_ == 0 && strand(x.place[k]).fresh_end < 0) continue;
        if (meeting) {
          // An extension ends where it first meets another curve, from whatever side.
          const int fresh = strand(x.place[k]).fresh_end;
          const bool onward = fresh >= 0 ? fresh == 1 : along[k].dot(frame[1 - k].tangent) > 0;
          cut.after = onward;
          cut.before = !onward;
          cut.meeting = static_cast<int>(c);
        }
        cuts[static_cast<std::size_t>(x.place[k].front)][x.place[k].strand].push_back(cut);
      }
    }
  }

  const Strand& strand(const StrandPlace& place) const {
    return fronts_[static_cast<std::size_t>(place.front)]->strands()[place.strand];
  }

  bool is_meeting(const FrontCrossing& x) const {
    return x.ray[0].state.y > 0 && x.ray[1].state.y > 0 &&
           !swept(*fronts_[static_cast<std::size_t>(x.place[0].front)], x.ray[0], nullptr);
  }

  /// Which crossings there are when each extension ends at its first meeting.
  std::vector<char> reached_by_extensions(const std::vector<FrontCrossing>& crossings) const {
    struct Event {
      double way_mm;
      std::size_t crossing;
    };
    const auto way = [&](const FrontCrossing& x, std::size_t k) {
      const Strand& s = strand(x.place[k]);
      if (s.fresh_end < 0) return 0.0;
      return s.fresh_end == 0 ? x.ray[k].t - s.rays.front().t : s.rays.back().t - x.ray[k].t;
    };
    std::vector<Event> events;
    for (std::size_t c = 0; c < crossings.size(); ++c)
      events.push_back({std::max(way(crossings[c], 0), way(crossings[c], 1)), c});
    std::stable_sort(events.begin(), events.end(),
                     [](const Event& a, const Event& b) { return a.way_mm < b.way_mm; });
    std::array<std::vector<double>, 2> ends;
    for (std::size_t f = 0; f < 2; ++f)
      if (fronts_[f]) ends[f].assign(fronts_[f]->strands().size(), std::numeric_limits<double>::infinity());
    std::vector<char> reached(crossings.size(), 0);
    for (const Event& event : events) {
      const FrontCrossing& x = crossings[event.crossing];
      bool both = true;
      for (std::size_t k = 0; k < 2; ++k)
        both = both && way(x, k) <= ends[static_cast<std::size_t>(x.place[k].front)][x.place[k].strand];
      if (!both) continue;
      reached[event.crossing] = 1;
      if (!is_meeting(x)) continue;
      for (std::size_t k = 0; k < 2; ++k)
        if (strand(x.place[k]).fresh_end >= 0)
          ends[static_cast<std::size_t>(x.place[k].front)][x.place[k].strand] = way(x, k);
    }
    return reached;
  }

  /// Rays short of a focal point. A Jacobi field that comes close to zero and does not change its sign has
  /// none.
  static std::vector<char> short_of_focal(const Strand& strand) {
    const std::size_t n = strand.rays.size();
    std::vector<char> out(n);
    for (std::size_t i = 0; i < n; ++i) out[i] = strand.rays[i].state.y > least_y;
    for (std::size_t i = 0; i < n;) {
      std::size_t j = i;
      while (j < n && !out[j] && strand.rays[j].state.y > 0) ++j;
      if (j > i && (i == 0 || out[i - 1]) && (j == n || out[j]))
        std::fill(out.begin() + static_cast<std::ptrdiff_t>(i), out.begin() + static_cast<std::ptrdiff_t>(j),
                  1);
      i = std::max(j, i + 1);
      while (i < n && !out[i] && !out[i - 1]) ++i;  // the rest of a run that has a focal point
    }
    return out;
  }

  /// Whether the branch on one side of a focal point ends at a meeting before it comes there: `in` is the
  /// last ray short of it, ray `next` the first that is not. The nearer the focal point, the younger the
  /// swallowtail.
  static bool meets_first(const Strand& strand, std::size_t in, std::size_t next,
                          const std::vector<Cut>& cuts) {
    const bool forward = next > in;
    const auto& rays = strand.rays;
    std::size_t last = next;  // the first ray beyond the focal point
    while (rays[last].state.y > 0 && (forward ? last + 1 < rays.size() : last > 0)) forward ? ++last : --last;
    return std::any_of(cuts.begin(), cuts.end(), [&](const Cut& cut) {
      return cut.meeting >= 0 && (forward ? cut.before : cut.after) && (cut.ray.t > rays[in].t) == forward &&
             (cut.ray.t < rays[last].t) == forward;
    });
  }

  /// Focal points: between rays whose Jacobi field changes from good to bad.
  void cut_at_cusps(const Front& front, const Strand& strand, std::vector<Cut>& cuts) const {
    const std::vector<char> fine = short_of_focal(strand);
    for (std::size_t i = 0; i + 1 < strand.rays.size(); ++i) {
      const bool good = fine[i];
      if (good == static_cast<bool>(fine[i + 1])) continue;
      if (good ? meets_first(strand, i, i + 1, cuts) : meets_first(strand, i + 1, i, cuts)) continue;
      Ray in = good ? strand.rays[i] : strand.rays[i + 1], out = good ? strand.rays[i + 1] : strand.rays[i];
      for (int k = 0; k < 60 && std::abs(in.t - out.t) > 1e-9; ++k) {
        bool alive = false;
        const Ray mid = front.shoot(strand.source, 0.5 * (in.t + out.t), level_, &alive);
        (alive && mid.state.y > least_y ? in : out) = mid;
      }
      Cut cut;
      cut.ray = in;
      cut.before = good;
      cut.after = !good;
      cuts.push_back(cut);
    }
    std::stable_sort(cuts.begin(), cuts.end(), [](const Cut& a, const Cut& b) { return a.ray.t < b.ray.t; });
  }

  static std::vector<Stretch> stretches_of(const Strand& strand, const std::vector<Cut>& cuts) {
    std::vector<Stretch> out(1);
    std::size_t next = 0;
    for (const Ray& ray : strand.rays) {
      while (next < cuts.size() && cuts[next].ray.t <= ray.t) {
        const Cut& cut = cuts[next++];
        out.back().rays.push_back(cut.ray);
        out.back().cut[1] = &cut;
        out.emplace_back();
        out.back().rays.push_back(cut.ray);
        out.back().cut[0] = &cut;
      }
      if (out.back().rays.empty() || ray.t > out.back().rays.back().t) out.back().rays.push_back(ray);
    }
    return out;
  }

  /// Whether a curve of a lower level is nearer than W.
  bool swept(const Front& front, const Ray& ray, const Strand* strand) const {
    const PathFrame frame = frame_of(front.skin(), ray.state);
    // Far from folds the stretch that the ray left cannot be nearer by another way.
    const bool plain = strand && ray.state.y > 0.5;
    return laid_
        .rival(front.probe_tracer(), frame.position, frame.normal,
               front.options().spacing_mm - front.options().validity_tolerance_mm,
               plain ? strand->parent : -1, plain ? ray.t + strand->parent_offset : 0,
               plain ? 1.5 * front.options().sample_mm : 0)
        .has_value();
  }

  bool good(const Front& front, const Ray& ray, const Strand& strand) const {
    return ray.state.y > 0 && !swept(front, ray, &strand);
  }

  static bool is_beyond_cusp(const Stretch& stretch) {
    return stretch.rays[stretch.rays.size() / 2].state.y <= least_y;
  }

  /// Whether a stretch longer than what the rule of branches is needed for has not been swept anywhere.
  bool is_clear(const Front& front, const Strand& strand, const Stretch& stretch) const {
    constexpr std::size_t probes = 7;
    if (stretch.rays.size() < probes + 2) return false;
    // Before a cusp many rays stand within less than a sample: there the other front is no nearer than a
    // probe can tell.
    const Vec3 first = front.skin().point(stretch.rays.front().state.at);
    const bool apart = std::any_of(stretch.rays.begin(), stretch.rays.end(), [&](const Ray& ray) {
      return (front.skin().point(ray.state.at) - first).norm() > front.options().sample_mm;
    });
    if (!apart) return false;
    for (std::size_t k = 0; k < probes; ++k) {
      const Ray& ray = stretch.rays[1 + k * (stretch.rays.size() - 3) / (probes - 1)];
      if (!good(front, ray, strand)) return false;
    }
    return true;
  }

  void keep_stretches(const Front& front, const Strand& strand, const std::vector<Cut>& cuts,
                      std::vector<Strand>& kept) const {
    for (Stretch& stretch : stretches_of(strand, cuts)) {
      if (stretch.rays.size() < 2) continue;
      const bool dropped =
          (stretch.cut[0] && !stretch.cut[0]->after) || (stretch.cut[1] && !stretch.cut[1]->before);
      if (dropped && (is_beyond_cusp(stretch) || !is_clear(front, strand, stretch))) continue;
      const auto length = static_cast<std::ptrdiff_t>(stretch.rays.size());
      std::vector<char> valid(stretch.rays.size(), 1);
      tbb::parallel_for(std::ptrdiff_t{0}, length, [&](std::ptrdiff_t i) {
        // The ends at cuts have been judged with the cut; one ray alone stands for the whole.
        const bool judged = (i == 0 && stretch.cut[0]) || (i + 1 == length && stretch.cut[1]);
        if (!judged)
          valid[static_cast<std::size_t>(i)] = good(front, stretch.rays[static_cast<std::size_t>(i)], strand);
      });
      if (length == 2 && stretch.cut[0] && stretch.cut[1]) {
        bool alive = false;
        const Ray mid =
            front.shoot(strand.source, 0.5 * (stretch.rays[0].t + stretch.rays[1].t), level_, &alive);
        if (!alive || !good(front, mid, strand)) continue;
      }
      keep_runs(front, strand, stretch, valid, kept);
    }
  }

  /// Runs of valid rays. Between cuts they are all or none, but for fronts whose other branch has left the
  /// skin.
  void keep_runs(const Front& front, const Strand& strand, const Stretch& stretch,
                 const std::vector<char>& valid, std::vector<Strand>& kept) const {
    std::size_t i = 0;
    while (i < valid.size()) {
      if (!valid[i]) {
        ++i;
        continue;
      }
      std::size_t j = i;
      while (j + 1 < valid.size() && valid[j + 1]) ++j;
      Strand run = strand;
      run.trimmed = true;
      run.rays.assign(stretch.rays.begin() + static_cast<std::ptrdiff_t>(i),
                      stretch.rays.begin() + static_cast<std::ptrdiff_t>(j) + 1);
      for (int e = 0; e < 2; ++e) {
        const bool whole = e == 0 ? i == 0 : j + 1 == valid.size();
        if (whole && !stretch.cut[e]) continue;  // the strand's own end
        run.link[e] = -1;
        if (whole) {
          run.end[e] = StrandEnd::corner;
          run.meeting[e] = stretch.cut[e]->meeting;
          continue;
        }
        run.end[e] = StrandEnd::stopped;
        run.meeting[e] = lone_cut;
        const Ray last = e == 0 ? stretch.rays[i] : stretch.rays[j];
        const Ray end = last_good(front, strand, last, e == 0 ? stretch.rays[i - 1] : stretch.rays[j + 1]);
        if (e == 0 && end.t < run.rays.front().t) run.rays.insert(run.rays.begin(), end);
        if (e == 1 && end.t > run.rays.back().t) run.rays.push_back(end);
      }
      if (run.rays.size() >= 2) {
        if (run.rays.size() != strand.rays.size())
          front.refine(run, level_);  // a new end may stand close to a cusp
        kept.push_back(std::move(run));
      }
      i = j + 1;
    }
  }

  Ray last_good(const Front& front, const Strand& strand, Ray in, Ray out) const {
    const auto apart = [&] {
      return (front.skin().point(in.state.at) - front.skin().point(out.state.at)).norm();
    };
    for (int i = 0; i < 60 && apart() > end_tolerance_mm; ++i) {
      bool alive = false;
      const Ray mid = front.shoot(strand.source, 0.5 * (in.t + out.t), level_, &alive);
      if (mid.t == in.t || mid.t == out.t) break;
      (alive && good(front, mid, strand) ? in : out) = mid;
    }
    return in;
  }

  /// An extension leads on from an end: where that end has been cut off, it leads from nowhere.
  static void drop_severed_extensions(Front& front) {
    std::erase_if(front.strands(), [](const Strand& strand) {
      return strand.fresh_end >= 0 && strand.end[strand.fresh_end] != StrandEnd::linked;
    });
    front.settle_links();
  }

  static double chord(const Front& front, const Strand& strand) {
    return (front.skin().point(strand.rays.front().state.at) -
            front.skin().point(strand.rays.back().state.at))
        .norm();
  }

  /// A meeting of which only one branch is left is none. Where three fronts meet nearly in one point, a
  /// sliver of the middle one may be kept though the outer two meet: what is swept by less than the validity
  /// tolerance counts as clear. No other branch ends where it does. The same holds for what is left of a
  /// strand beyond a link whose other strand has been dropped.
  void open_lone_corners() const {
    std::vector<int> count;
    const auto each = [&](auto body) {
      for (Front* front : fronts_)
        if (front)
          for (Strand& strand : front->strands())
            for (int e = 0; e < 2; ++e)
              if (strand.meeting[e] != no_meeting) body(strand, e);
    };
    each([&](Strand& strand, int e) {
      if (strand.meeting[e] == lone_cut) return;
      const auto m = static_cast<std::size_t>(strand.meeting[e]);
      if (count.size() <= m) count.resize(m + 1, 0);
      ++count[m];
    });
    const auto lone = [&](const Strand& strand, int e) {
      return strand.meeting[e] == lone_cut ||
             (strand.meeting[e] != no_meeting && count[static_cast<std::size_t>(strand.meeting[e])] < 2);
    };
    for (Front* front : fronts_) {
      if (!front) continue;
      std::vector<char> sliver;
      for (std::size_t i = 0; i < front->strands().size(); ++i) {
        const Strand& strand = front->strands()[i];
        const auto unpaired = [&](int e) {
          return lone(strand, e) || (strand.end[e] == StrandEnd::linked && !front->has_partner(i, e));
        };
        sliver.push_back(unpaired(0) && unpaired(1) && chord(*front, strand) < front->options().sample_mm);
      }
      std::size_t next = 0;
      std::erase_if(front->strands(), [&](const Strand&) { return sliver[next++]; });
    }
    each([&](Strand& strand, int e) {
      if (strand.end[e] == StrandEnd::corner && lone(strand, e)) strand.end[e] = StrandEnd::open;
      strand.meeting[e] = no_meeting;  // numbers hold for this call only
    });
  }

  std::array<Front*, 2> fronts_;
  int level_;
  const LaidCurves& laid_;
};

}  // namespace

void trim_fronts(const std::array<Front*, 2>& fronts, int level, const LaidCurves& laid) {
  Trimmer(fronts, level, laid).trim();
}

}  // namespace afptraj
