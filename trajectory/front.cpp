#include "trajectory/front.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "geometry/curvature.h"

namespace afptraj {
namespace {

constexpr double least_t_mm = 1e-3;  // rays are not placed closer than this along their source

double chord(const Skin& skin, const Ray& a, const Ray& b) {
  return (skin.point(a.state.at) - skin.point(b.state.at)).norm();
}

template <typename Body>
void for_each_index(std::size_t count, Body body) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 16),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i < range.end(); ++i) body(i);
                    });
}

/// Whether two neighbouring nodes lie on different faces or on either side of a seam: in (u, v) half of the
/// domain or more apart.
bool seam_between(const Skin& skin, const CurveNode& a, const CurveNode& b) {
  if (a.at.face != b.at.face) return true;
  const Surface& surface = skin.face(a.at.face).surface;
  const Uv step = b.at.uv - a.at.uv;
  return std::abs(step.x()) >= 0.5 * surface.domain_u().length() ||
         std::abs(step.y()) >= 0.5 * surface.domain_v().length();
}

/// Splits rays into the runs whose flag is set; `trim(first, last, run)` finishes each.
template <typename Finish>
void split(const std::vector<char>& keep, Finish finish) {
  std::size_t i = 0;
  while (i < keep.size()) {
    if (!keep[i]) {
      ++i;
      continue;
    }
    std::size_t j = i;
    while (j + 1 < keep.size() && keep[j + 1]) ++j;
    finish(i, j);
    i = j + 1;
  }
}

}  // namespace

namespace {

GeodesicOptions for_extensions(GeodesicOptions options, double margin_mm) {
  options.margin_mm = margin_mm;
  // Short of the far side, where extensions of both ends of a path round a dome would overlap.
  options.outside_limit_mm *= 0.25;
  return options;
}

GeodesicOptions for_lost_fronts(GeodesicOptions options, double spacing_mm) {
  // Out by two bands, from where no ray of one band comes back, and half a band to spare.
  options.margin_mm = std::max(options.margin_mm, 2.5 * spacing_mm);
  return options;
}

GeodesicOptions for_probes(GeodesicOptions options, double validity_tolerance_mm) {
  // The global error over a band was up to ten times the local one.
  options.tolerance_mm = std::max(options.tolerance_mm, validity_tolerance_mm / 100);
  return options;
}

}  // namespace

CurveNode level_node(const Skin& skin, const SourceCurve& source, const Ray& ray, int side) {
  CurveNode node;
  node.t = ray.t;
  node.at = ray.state.at;
  node.normal_sign = ray.state.normal_sign;
  const SurfaceDerivatives d = skin.derivatives(node.at);
  const PathFrame frame = frame_of(skin, ray.state);
  // The ray points along side * b, so the level curve runs along side * (ray x n).
  const Vec3 tangent = side * frame.tangent.cross(frame.normal);
  node.duv = ray.state.y * source.at(ray.t).speed * tangent_to_uv(d, tangent);
  node.kg_per_mm = ray.state.y != 0 ? -side * ray.state.dy / ray.state.y : 0;
  return node;
}

bool same_chart(const Skin& skin, const CurveNode& a, const CurveNode& b) {
  if (a.at.face != b.at.face || a.normal_sign != b.normal_sign) return false;
  if (crease_between(skin.face(a.at.face).surface, a.at.uv, b.at.uv)) return false;
  const Uv miss = b.at.uv - a.at.uv - 0.5 * (b.t - a.t) * (a.duv + b.duv);
  const SurfaceDerivatives d = skin.derivatives(a.at);
  const SurfaceDerivatives e = skin.derivatives(b.at);
  const double off = std::min(uv_to_tangent(d, miss).norm(), uv_to_tangent(e, miss).norm());
  return off <= 0.25 * (d.S - e.S).norm() + 1e-9;
}

Front::Front(const GeodesicTracer& tracer, int side, const FrontOptions& options)
    : tracer_(&tracer),
      extension_tracer_(tracer.skin(), for_extensions(tracer.options(), options.extension_margin_mm)),
      wide_tracer_(tracer.skin(), for_lost_fronts(tracer.options(), options.spacing_mm)),
      probe_tracer_(tracer.skin(), for_probes(tracer.options(), options.validity_tolerance_mm)),
      side_(side),
      options_(options) {}

int Front::add_source(std::shared_ptr<const SourceCurve> curve, int birth, bool wide) {
  sources_.push_back({std::move(curve), birth, wide});
  return static_cast<int>(sources_.size()) - 1;
}

Ray Front::shoot(int source, double t, int level, bool* alive) const {
  const FrontSource& from = sources_[static_cast<std::size_t>(source)];
  const SourceCurve::Frame frame = from.curve->at(t);
  Ray ray;
  ray.t = t;
  const GeodesicTracer& tracer = tracer_of(source);
  ray.state = tracer.start(frame.at, side_ * frame.frame.left(), frame.normal_sign, 1,
                           -side_ * frame.kg_per_mm, frame.outside);
  ray.state.in_hole = frame.in_hole;
  const double length = (level - from.birth) * options_.spacing_mm;
  const bool reached = length <= 0 || tracer.advance(ray.state, length) == TraceEnd::reached;
  if (alive) *alive = reached;
  return ray;
}

void Front::refine_level_zero() {
  for (Strand& strand : strands_) refine(strand, 0);
}

void Front::mirror(const Front& other) {
  sources_ = other.sources_;
  strands_ = other.strands_;
  for (Strand& strand : strands_)
    for (Ray& ray : strand.rays) ray = shoot(strand.source, ray.t, 0, nullptr);
}

void Front::advance(int level) {
  std::vector<Strand> next;
  for (Strand& strand : strands_) {
    std::vector<char> alive(strand.rays.size());
    for_each_index(strand.rays.size(), [&](std::size_t i) {
      alive[i] =
          tracer_of(strand.source).advance(strand.rays[i].state, options_.spacing_mm) == TraceEnd::reached;
    });
    for (Strand& run : alive_runs(strand, alive, level)) {
      refine(run, level);
      run.trimmed = false;
      run.fresh_end = -1;
      split_where_rays_part(std::move(run), next);
    }
  }
  strands_ = std::move(next);
  settle_links();
}

/// Where no ray leads between two neighbours however close (a vertex, or an edge whose curvature is
/// negative: shortest paths run along it and leave it on either side), the front has two ends.
void Front::split_where_rays_part(Strand strand, std::vector<Strand>& out) const {
  std::size_t first = 0;
  for (std::size_t i = 0; i + 1 < strand.rays.size(); ++i) {
    if (strand.rays[i + 1].t - strand.rays[i].t > 4 * least_t_mm ||
        chord(skin(), strand.rays[i], strand.rays[i + 1]) < 2 * options_.sample_mm)
      continue;
    if (i > first) {
      Strand before = strand;
      before.rays.assign(strand.rays.begin() + static_cast<std::ptrdiff_t>(first),
                         strand.rays.begin() + static_cast<std::ptrdiff_t>(i) + 1);
      before.end[1] = StrandEnd::open;
      before.link[1] = -1;
      out.push_back(std::move(before));
    }
    first = i + 1;
    strand.end[0] = StrandEnd::open;
    strand.link[0] = -1;
  }
  strand.rays.erase(strand.rays.begin(), strand.rays.begin() + static_cast<std::ptrdiff_t>(first));
  if (strand.rays.size() >= 2) out.push_back(std::move(strand));
}

/// Runs of rays still on the skin; each new end is moved to the last ray that is.
std::vector<Strand> Front::alive_runs(const Strand& strand, const std::vector<char>& alive, int level) const {
  std::vector<Strand> out;
  split(alive, [&](std::size_t first, std::size_t last) {
    Strand run = strand;
    run.rays.assign(strand.rays.begin() + static_cast<std::ptrdiff_t>(first),
                    strand.rays.begin() + static_cast<std::ptrdiff_t>(last) + 1);
    const auto find_end = [&](const Ray& in, double out_t) {
      double a = in.t, b = out_t;
      Ray best = in;
      for (int i = 0; i < 40 && std::abs(b - a) > 1e-4; ++i) {
        bool ok = false;
        const Ray mid = shoot(strand.source, 0.5 * (a + b), level, &ok);
        if (ok) {
          best = mid;
          a = mid.t;
        } else {
          b = 0.5 * (a + b);
        }
      }
      return best;
    };
    if (first > 0) {
      run.end[0] = StrandEnd::open;
      run.link[0] = -1;
      const Ray end = find_end(strand.rays[first], strand.rays[first - 1].t);
      if (end.t < run.rays.front().t) run.rays.insert(run.rays.begin(), end);
    }
    if (last + 1 < strand.rays.size()) {
      run.end[1] = StrandEnd::open;
      run.link[1] = -1;
      const Ray end = find_end(strand.rays[last], strand.rays[last + 1].t);
      if (end.t > run.rays.back().t) run.rays.push_back(end);
    }
    if (run.rays.size() >= 2) out.push_back(std::move(run));
  });
  return out;
}

void Front::refine(Strand& strand, int level) const {
  const Skin& skin = tracer_->skin();
  const SourceCurve& source = *sources_[static_cast<std::size_t>(strand.source)].curve;
  {
    std::vector<Ray> thinned;
    for (std::size_t i = 0; i < strand.rays.size(); ++i) {
      const bool end = i == 0 || i + 1 == strand.rays.size();
      // Half the spacing on either side keeps the sum below the greatest spacing.
      if (!end && chord(skin, thinned.back(), strand.rays[i]) < 0.25 * options_.sample_mm &&
          chord(skin, thinned.back(), strand.rays[i + 1]) < 0.5 * options_.sample_mm)
        continue;
      thinned.push_back(strand.rays[i]);
    }
    strand.rays = std::move(thinned);
  }
  for (int round = 0; round < 20; ++round) {
    const std::size_t n = strand.rays.size();
    std::vector<CurveNode> nodes(n);
    std::vector<Vec3> along(n);
    for_each_index(n, [&](std::size_t i) {
      nodes[i] = level_node(skin, source, strand.rays[i], side_);
      const PathFrame frame = frame_of(skin, strand.rays[i].state);
      along[i] = frame.tangent.cross(frame.normal);
    });
    std::vector<char> halve(n, 0);  // the gap after ray i
    std::vector<char> joined(n, 0);
    for (std::size_t i = 0; i + 1 < n; ++i) {
      joined[i] = same_chart(skin, nodes[i], nodes[i + 1]);
      const double length = chord(skin, strand.rays[i], strand.rays[i + 1]);
      if (length > 1.5 * options_.sample_mm) halve[i] = 1;
      // At a cusp (a focal point), or where the parametrisation changes its speed, neighbours on one chart do
      // not join smoothly until they are close.
      if (!joined[i] && !seam_between(skin, nodes[i], nodes[i + 1])) halve[i] = 1;
    }
    for (std::size_t i = 1; i + 1 < n; ++i) {
      if (!joined[i - 1] || !joined[i]) continue;
      const double h1 = nodes[i].t - nodes[i - 1].t, h2 = nodes[i + 1].t - nodes[i].t;
      if (!(h1 > 1e-9 && h2 > 1e-9)) continue;
      const std::vector<CurveNode> wide = {nodes[i - 1], nodes[i + 1]};
      const Uv miss = cubic(wide, 0).point(h1 / (h1 + h2)) - nodes[i].at.uv;
      const double error = uv_to_tangent(skin.derivatives(nodes[i].at), miss).norm();
      // The cubic's error at x is f'''' x^2 (h - x)^2 / 24; in the middle of a gap h^4 / 384. Between
      // gaps of very different length the estimate would only magnify round-off.
      const double ratio = std::min(4.0, std::max(h1, h2) / std::min(h1, h2));
      const double wider = error * ratio * ratio / 16, narrower = error / (16 * ratio * ratio);
      if ((h1 > h2 ? wider : narrower) > options_.hermite_tolerance_mm) halve[i - 1] = 1;
      if ((h2 > h1 ? wider : narrower) > options_.hermite_tolerance_mm) halve[i] = 1;
    }
    std::vector<std::size_t> gaps;
    for (std::size_t i = 0; i + 1 < n; ++i) {
      if (!halve[i] || strand.rays[i + 1].t - strand.rays[i].t < least_t_mm) continue;
      // Near a focal point rays crowd together in space but not in t: only t bounds the halving there.
      const bool focal =
          std::min(std::abs(strand.rays[i].state.y), std::abs(strand.rays[i + 1].state.y)) < 0.1;
      const double length = chord(skin, strand.rays[i], strand.rays[i + 1]);
      // A curve from one tangent to another is off their chord by a quarter of length times angle at most:
      // round a sharp edge short gaps miss too.
      const bool turns = 0.25 * length * (along[i + 1] - along[i]).norm() > options_.hermite_tolerance_mm;
      if (focal || !joined[i] || turns || length > 0.02 * options_.sample_mm) gaps.push_back(i);
    }
    if (gaps.empty()) break;
    std::vector<Ray> mids(gaps.size());
    std::vector<char> ok(gaps.size());
    for_each_index(gaps.size(), [&](std::size_t g) {
      bool alive = false;
      mids[g] =
          shoot(strand.source, 0.5 * (strand.rays[gaps[g]].t + strand.rays[gaps[g] + 1].t), level, &alive);
      ok[g] = alive;
    });
    std::vector<Ray> merged;
    merged.reserve(n + gaps.size());
    std::size_t g = 0;
    for (std::size_t i = 0; i < n; ++i) {
      merged.push_back(strand.rays[i]);
      if (g < gaps.size() && gaps[g] == i) {
        if (ok[g]) merged.push_back(mids[g]);
        ++g;
      }
    }
    if (merged.size() == n) break;
    strand.rays = std::move(merged);
  }
}

bool Front::has_partner(std::size_t strand, int end) const {
  for (std::size_t j = 0; j < strands_.size(); ++j)
    for (int f = 0; f < 2; ++f)
      if ((j != strand || f != end) && strands_[j].end[f] == StrandEnd::linked &&
          strands_[j].link[f] == strands_[strand].link[end])
        return true;
  return false;
}

void Front::settle_links() {
  for (std::size_t i = 0; i < strands_.size(); ++i)
    for (int e = 0; e < 2; ++e)
      if (strands_[i].end[e] == StrandEnd::linked && !has_partner(i, e)) strands_[i].end[e] = StrandEnd::open;
}

/// Whether a curve of a lower level lies nearer than W.
bool Front::too_near(const PathFrame& at, const LaidCurves& laid) const {
  return laid
      .rival(probe_tracer_, at.position, at.normal, options_.spacing_mm - options_.validity_tolerance_mm, -1,
             0, 0)
      .has_value();
}

namespace {

constexpr double least_part_mm = 1e-8;  // ends stand on the boundary within 1e-6 mm

/// Whether a state of `states`, up to arc length `until_mm`, lies beside `at` within `near_mm`.

bool passes(const Skin& skin, const std::vector<GeodesicState>& states, double until_mm, const PathFrame& at,
            double near_mm) {
  for (const GeodesicState& old : states) {
    if (old.s_mm > until_mm) break;
    const Vec3 r = skin.point(old.at) - at.position;
    if (r.norm() < near_mm && std::abs(r.dot(at.tangent)) < 0.25 * near_mm) return true;
  }
  return false;
}

}  // namespace

void Front::extend(int level, const LaidCurves& laid, const LaidCurves& current, int& next_link) {
  const std::size_t count = strands_.size();
  std::vector<std::vector<GeodesicState>> made;
  for (std::size_t i = 0; i < count; ++i)
    for (int e = 0; e < 2; ++e) {
      // What stopped a front at the level before may lie behind it now.
      if (strands_[i].end[e] != StrandEnd::open && strands_[i].end[e] != StrandEnd::stopped) continue;
      const Ray end = e == 0 ? strands_[i].rays.front() : strands_[i].rays.back();
      // The reference ends on the boundary, give or take what it was faired by.
      if (end.state.outside && level > 0) continue;
      bool stopped = false;
      const std::vector<GeodesicState> states = extension(end, e == 0, level, laid, current, made, &stopped);
      if (states.size() < 2) continue;
      if (level == 0) made.push_back(states);
      Strand extension = extension_strand(states, e == 0, level);
      if (stopped) extension.end[e] = StrandEnd::stopped;
      extension.fresh_end = 1 - e;
      strands_.push_back(std::move(extension));
      join(strands_[i], e, strands_.back(), next_link++);
    }
}

/// The rays of a geodesic that goes on from the end of a strand, back from its first point or forward.
Strand Front::extension_strand(const std::vector<GeodesicState>& states, bool backward, int level) {
  Strand out;
  out.source = add_source(std::make_shared<GeodesicPath>(*tracer_, states, backward), level);
  for (const GeodesicState& s : states)
    out.rays.push_back(shoot(out.source, backward ? -s.s_mm : s.s_mm, level, nullptr));
  if (backward) std::reverse(out.rays.begin(), out.rays.end());
  refine(out, level);
  return out;
}

/// Links end `e` of a strand with the other end of the strand that goes on there.
void Front::join(Strand& strand, int e, Strand& next, int link) {
  strand.end[e] = next.end[1 - e] = StrandEnd::linked;
  strand.link[e] = next.link[1 - e] = link;
}

/// Whether a curve of this level on this side passes behind, nearer than W.
bool Front::runs_ahead(const PathFrame& at, const LaidCurves& current) const {
  const auto rival = current.rival(probe_tracer_, at.position, at.normal, options_.spacing_mm, -1, 0, 0);
  return rival && side_ * rival->foot.distance_mm > 1e-3;
}

GeodesicState Front::onward(const Ray& end, bool backward) const {
  const PathFrame frame = frame_of(skin(), end.state);
  const Vec3 level_tangent = side_ * frame.tangent.cross(frame.normal);
  GeodesicState g = extension_tracer_.start(end.state.at, backward ? Vec3(-level_tangent) : level_tangent,
                                            end.state.normal_sign, 1, 0, end.state.outside);
  g.in_hole = end.state.in_hole;
  return g;
}

/// The geodesic on from an end of a strand, in states a step apart.
std::vector<GeodesicState> Front::extension(const Ray& end, bool backward, int level, const LaidCurves& laid,
                                            const LaidCurves& current,
                                            const std::vector<std::vector<GeodesicState>>& made,
                                            bool* stopped) const {
  GeodesicState g = onward(end, backward);
  std::vector<GeodesicState> states = {g};
  const double step = std::min(options_.extension_step_mm, options_.sample_mm);
  int too_near_steps = 0;
  std::size_t clear = 1;  // states that do not run ahead of another curve of this level
  bool ran_out = false;
  while (g.s_mm < options_.max_extension_mm) {
    if (extension_tracer_.advance(g, step) != TraceEnd::reached) {
      ran_out = true;
      break;
    }
    const PathFrame at = frame_of(skin(), g);
    // A few steps into what has been swept, so that the crossing with the front that swept it is seen.
    too_near_steps = level > 0 && too_near(at, laid) ? too_near_steps + 1 : 0;
    const double near = 0.9 * options_.spacing_mm;
    bool met = passes(skin(), states, g.s_mm - 3 * near, at, near) || too_near_steps > 3;
    // Level 0 keeps clear of itself: nothing has been swept yet.
    if (level == 0)
      met = met || current.abreast(at.position, at.normal, at.tangent, near, 1.5 * options_.sample_mm);
    for (const auto& other : made) met = met || passes(skin(), other, other.back().s_mm, at, near);
    if (met) {
      *stopped = true;
      break;
    }
    states.push_back(g);
    if (level == 0 || !runs_ahead(at, current)) {
      clear = states.size();
    } else if (g.s_mm - states[clear - 1].s_mm > 10 * options_.spacing_mm) {
      // It does not cross that curve soon: that curve's next level covers the place.
      states.resize(clear);
      *stopped = true;
      break;
    }
    if (g.outside && !g.in_hole && g.outside_mm > 2 * step && skin().faces().size() > 1) break;
  }
  // The surface may end with its boundary: the rest of the last step, by halves.
  for (double part = 0.5 * step; part > least_part_mm && ran_out; part *= 0.5) {
    GeodesicState h = states.back();
    if (extension_tracer_.advance(h, part) == TraceEnd::reached) states.push_back(h);
  }
  return states;
}

}  // namespace afptraj
