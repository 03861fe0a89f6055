#include "trajectory/parallels.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "trajectory/level_curve.h"
#include "trajectory/lost_fronts.h"
#include "trajectory/trim_front.h"

namespace afptraj {
namespace {

/// Rays at the samples of a source, not yet walked.
Strand sampled_strand(const Front& front, int source, double sample_mm) {
  const SourceCurve& curve = *front.source(source).curve;
  const double length = curve.last() - curve.first();
  const int n = std::max(2, static_cast<int>(std::ceil(length / sample_mm)));
  Strand strand;
  strand.source = source;
  for (int i = 0; i <= n; ++i)
    strand.rays.push_back(front.shoot(source, curve.first() + length * i / n, 0, nullptr));
  return strand;
}

/// Adds this level's curves to the result and to the laid curves, and notes for each strand where
/// on them its rays stand.
void lay(const GeodesicTracer& tracer, Front& front, int level, LaidCurves& laid,
         std::vector<LevelCurve>& out) {
  LevelCurve result;
  result.number = front.side() * level;
  for (ChainedCurve& chain : level_curves(tracer, front, level)) {
    const int index = laid.add(chain.curve, result.number);
    for (std::size_t i = 0; i < chain.strands.size(); ++i) {
      front.strands()[chain.strands[i]].parent = index;
      front.strands()[chain.strands[i]].parent_offset = chain.offsets[i];
    }
    result.curves.push_back(std::move(chain.curve));
  }
  if (!result.curves.empty()) out.push_back(std::move(result));
}

/// The curves of a front at a level, found by place.
LaidCurves curves_of(const GeodesicTracer& tracer, const Front& front, int level,
                     const ParallelOptions& options) {
  LaidCurves out(tracer.skin(), options.front.spacing_mm);
  for (ChainedCurve& chain : level_curves(tracer, front, level))
    out.add(std::move(chain.curve), front.side() * level);
  return out;
}

/// Whether the front at W on the other side of an extension would stand on skin that no curve is near, for W
/// or more.
bool leaves_skin_behind(const GeodesicTracer& tracer, const Front& front, const Strand& extension,
                        const LaidCurves& laid) {
  const FrontOptions& options = front.options();
  double clear_from = 0;
  bool clear = false;
  for (const Ray& ray : extension.rays) {
    const PathFrame at = frame_of(tracer.skin(), ray.state);
    GeodesicState g = tracer.start(ray.state.at, -at.tangent, ray.state.normal_sign, 1, 0, ray.state.outside);
    const bool bare =
        !ray.state.outside && tracer.advance(g, options.spacing_mm) == TraceEnd::reached && !g.outside &&
        g.y > 0 && [&] {
          const PathFrame there = frame_of(tracer.skin(), g);
          return !laid.rival(front.probe_tracer(), there.position, there.normal,
                             options.spacing_mm - options.validity_tolerance_mm, extension.parent,
                             ray.t + extension.parent_offset, 1.5 * options.sample_mm);
        }();
    if (bare && !clear) clear_from = ray.t;
    clear = bare;
    if (clear && ray.t - clear_from > options.spacing_mm) return true;
  }
  return false;
}

/// An extension sweeps its own side only: the other one belongs to the level before, which went on along it.
/// Where that has left the skin, the extension sweeps both.
void sweep_behind_extensions(const GeodesicTracer& tracer, const Front& from, Front& to, int level,
                             const LaidCurves& laid) {
  for (const Strand& extension : from.strands()) {
    if (extension.fresh_end < 0 || !leaves_skin_behind(tracer, from, extension, laid)) continue;
    Strand behind;
    behind.source = to.add_source(from.source(extension.source).curve, level);
    for (const Ray& ray : extension.rays)
      behind.rays.push_back(to.shoot(behind.source, ray.t, level, nullptr));
    to.refine(behind, level);
    behind.parent = extension.parent;
    behind.parent_offset = extension.parent_offset;
    to.add_strand(std::move(behind));
  }
}

}  // namespace

Parallels geodesic_parallels(const Skin& skin, std::shared_ptr<const SourceCurve> reference,
                             const ParallelOptions& options, const std::function<bool(int level)>& progress) {
  const GeodesicTracer tracer(skin, options.geodesic);
  Front left(tracer, 1, options.front), right(tracer, -1, options.front);
  LaidCurves laid(skin, options.front.spacing_mm);
  int next_link = 0;

  // Level 0: the reference and its extensions, the same on both sides.
  const int source = left.add_source(reference, 0);
  Strand strand = sampled_strand(left, source, options.front.sample_mm);
  if (reference->closed()) {
    strand.end[0] = strand.end[1] = StrandEnd::linked;
    strand.link[0] = strand.link[1] = next_link++;
  }
  left.add_strand(std::move(strand));
  left.refine_level_zero();
  left.extend(0, laid, curves_of(tracer, left, 0, options), next_link);
  trim_fronts({&left, nullptr}, 0, laid);
  right.mirror(left);

  std::vector<LevelCurve> left_levels, right_levels;
  lay(tracer, left, 0, laid, left_levels);
  for (std::size_t i = 0; i < left.strands().size(); ++i) {
    right.strands()[i].parent = left.strands()[i].parent;
    right.strands()[i].parent_offset = left.strands()[i].parent_offset;
  }

  Parallels out;
  for (int level = 1; !left.empty() || !right.empty(); ++level) {
    if (level > options.max_levels) {
      out.reached_max_levels = true;
      break;
    }
    if (progress && !progress(level)) break;
    const std::array<Front*, 2> both = {&left, &right};
    for (Front* front : both) front->advance(level);
    const std::array<std::vector<Strand>, 2> untrimmed = {left.strands(), right.strands()};
    trim_fronts(both, level, laid);
    const auto lost = lost_fronts(both, untrimmed, level, laid);
    if (!lost[0].empty() || !lost[1].empty()) {
      for (std::size_t f = 0; f < 2; ++f) recall(*both[f], untrimmed[f], lost[f], next_link);
      trim_fronts(both, level, laid);
    }
    for (Front* front : both)
      front->extend(level, laid, curves_of(tracer, *front, level, options), next_link);
    trim_fronts(both, level, laid);
    // Both sides are laid only now: neither may find its own level among the lower ones.
    lay(tracer, left, level, laid, left_levels);
    lay(tracer, right, level, laid, right_levels);
    sweep_behind_extensions(tracer, right, left, level, laid);
    sweep_behind_extensions(tracer, left, right, level, laid);
  }
  std::reverse(right_levels.begin(), right_levels.end());
  out.levels = std::move(right_levels);
  for (LevelCurve& level : left_levels) out.levels.push_back(std::move(level));
  return out;
}

}  // namespace afptraj
