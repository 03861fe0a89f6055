#include "analysis/course_ends.h"

#include <cmath>

#include <tbb/parallel_for.h>

#include "geometry/curvature.h"

namespace afptraj {
namespace {

constexpr double reach_mm = 1e-3;  // of an end to what it ends at

/// The nearest edge of the face is free (or a pole) and in reach.
bool near_free_edge(const Skin& skin, const SurfacePoint& at) {
  const SurfaceDerivatives d = skin.derivatives(at);
  const LoopCrossing nearest = skin.trim(at.face).nearest(at.uv, first_form(d).matrix());
  if (nearest.loop < 0 || (skin.point({at.face, nearest.uv}) - d.S).norm() > reach_mm) return false;
  const EdgeUse use{at.face, nearest.loop, nearest.coedge};
  return skin.edge(use).degenerate || !skin.mate(use);
}

/// Straight on it leaves the skin at once: for ends in a corner of faces, where another edge is as near.
bool leaves_ahead(const GeodesicTracer& tracer, const CourseLine& line, bool last) {
  const double length = line.t.back() - line.t.front();
  const double back = std::min(reach_mm, 0.1 * length);
  const CurveFrame inside = frame_at(tracer.skin(), line.curve, last ? line.t.back() - back : line.t.front() + back);
  GeodesicState g = tracer.start(inside.at, last ? inside.frame.tangent : Vec3(-inside.frame.tangent), inside.normal_sign);
  return tracer.advance(g, back + reach_mm) != TraceEnd::reached || g.outside;
}

}  // namespace

std::vector<std::array<LineEnd, 2>> line_ends(const GeodesicTracer& tracer, const std::vector<CourseLine>& lines) {
  std::vector<std::array<LineEnd, 2>> ends(lines.size(), {LineEnd::none, LineEnd::none});
  const auto meets = [&](std::size_t own, bool own_last) {
    const Vec3& p = own_last ? lines[own].points.back() : lines[own].points.front();
    for (std::size_t l = 0; l < lines.size(); ++l) {
      if (lines[l].off_skin || lines[l].closed() || std::abs(lines[l].course) != std::abs(lines[own].course)) continue;
      for (const bool last : {false, true})
        if ((l != own || last != own_last) &&
            ((last ? lines[l].points.back() : lines[l].points.front()) - p).norm() < reach_mm)
          return true;
    }
    return false;
  };
  tbb::parallel_for(std::size_t{0}, lines.size(), [&](std::size_t l) {
    const CourseLine& line = lines[l];
    if (line.off_skin || line.closed()) return;
    for (const bool last : {false, true}) {
      const auto& chord = last ? line.chords.back() : line.chords.front();
      const SurfacePoint at = line.curve.pieces[chord.piece][chord.node + (last ? 1 : 0)].at;
      const bool free = near_free_edge(tracer.skin(), at) || leaves_ahead(tracer, line, last);
      ends[l][last ? 1 : 0] = free ? LineEnd::boundary : meets(l, last) ? LineEnd::meeting : LineEnd::loose;
    }
  });
  return ends;
}

}  // namespace afptraj
