#include "winding/band_arcs.h"

#include <algorithm>

#include "winding/frustum.h"
#include "winding/pattern.h"

namespace afptraj {
namespace {

struct Circle {
  double laid_deg = 0, bare_deg = 360;
  double widest_deg = 0, widest_at_deg = 0;  // the widest bare arc, and its middle
};

// The union of arcs round one circle, and what is bare between them.
Circle united(const std::vector<BandArc>& laid) {
  Circle circle;
  std::vector<BandArc> arcs;
  double farthest = 0;
  for (const BandArc& arc : laid) {
    const double width = arc.to_deg - arc.from_deg;
    circle.laid_deg += width;
    if (width >= 360) circle.bare_deg = 0;
    const double from = modulo(arc.from_deg, 360);
    arcs.push_back({from, from + width, arc.piece});
    farthest = std::max(farthest, from + width);
  }
  if (arcs.empty()) return {0, 360, 360, 180};
  if (circle.bare_deg == 0) return circle;
  std::sort(arcs.begin(), arcs.end(),
            [](const BandArc& a, const BandArc& b) { return a.from_deg < b.from_deg; });
  circle.bare_deg = 0;
  const auto leave_bare = [&](double from, double to) {
    if (to <= from) return;
    circle.bare_deg += to - from;
    if (to - from > circle.widest_deg) {
      circle.widest_deg = to - from;
      circle.widest_at_deg = modulo((from + to) / 2, 360);
    }
  };
  // Once round from the first arc; one that reaches over 360 covers what follows the first.
  double reached = std::max(arcs.front().from_deg, farthest - 360);
  for (const BandArc& arc : arcs) {
    leave_bare(reached, arc.from_deg);
    reached = std::max(reached, arc.to_deg);
  }
  leave_bare(reached, arcs.front().from_deg + 360);
  return circle;
}

}  // namespace

void cover(std::vector<BandArc>& arcs, const BandArc& arc) {
  if (!arcs.empty() && arcs.back().piece + 1 >= arc.piece) {
    arcs.back() = {std::min(arc.from_deg, arcs.back().from_deg), std::max(arc.to_deg, arcs.back().to_deg),
                   arc.piece};
  } else {
    arcs.push_back(arc);
  }
}

void CoverageSum::add(double z_mm, double r_mm, double strip_mm, const std::vector<BandArc>& arcs) {
  const double mm_per_deg = radians(r_mm);
  const Circle circle = united(arcs);
  surface_ += strip_mm * 360 * mm_per_deg;
  covered_ += strip_mm * (360 - circle.bare_deg) * mm_per_deg;
  laid_ += strip_mm * circle.laid_deg * mm_per_deg;
  if (circle.widest_deg * mm_per_deg > out_.widest_gap_mm) {
    out_.widest_gap_mm = circle.widest_deg * mm_per_deg;
    out_.gap_z_mm = z_mm;
    out_.gap_deg = circle.widest_at_deg;
  }
}

BandCoverage CoverageSum::coverage() const {
  BandCoverage out = out_;
  out.covered_share = surface_ > 0 ? covered_ / surface_ : 0;
  out.overlap_share = covered_ > 0 ? (laid_ - covered_) / covered_ : 0;
  return out;
}

}  // namespace afptraj
