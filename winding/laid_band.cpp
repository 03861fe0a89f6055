#include "winding/laid_band.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "winding/frustum.h"
#include "winding/pattern.h"

namespace afptraj {
namespace {

// The interval of t in which p + t q lies in [-limit, limit], cut to [lo, hi]; empty: lo > hi.
void clip(double p, double q, double lower, double upper, double& lo, double& hi) {
  if (q == 0) {
    if (p < lower || p > upper) lo = 1, hi = 0;
    return;
  }
  const double a = (lower - p) / q, b = (upper - p) / q;
  lo = std::max(lo, std::min(a, b));
  hi = std::min(hi, std::max(a, b));
}

}  // namespace

LaidBand::LaidBand(const WindMandrel& mandrel, double tow_width_mm, int sections)
    : mandrel_(mandrel),
      half_width_mm_(tow_width_mm / 2),
      step_mm_(mandrel.length_mm / sections),
      slant_(std::hypot(1, (mandrel.end_diameter_mm.value_or(mandrel.diameter_mm) - mandrel.diameter_mm) / 2 /
                               mandrel.length_mm)),
      arcs_(static_cast<std::size_t>(sections)) {}

double LaidBand::radius(double z_mm) const {
  const double end = mandrel_.end_diameter_mm.value_or(mandrel_.diameter_mm);
  return (mandrel_.diameter_mm + (end - mandrel_.diameter_mm) * (z_mm / mandrel_.length_mm)) / 2;
}

void LaidBand::lay(double z0_mm, double angle0_deg, double z1_mm, double angle1_deg) {
  // Unrolled: s along the mandrel's surface, t round it, both in mm from the piece's beginning.
  const double r = radius((z0_mm + z1_mm) / 2);
  const double ds = (z1_mm - z0_mm) * slant_, dt = radians(angle1_deg - angle0_deg) * r;
  const double length = std::hypot(ds, dt);
  if (!(length > 0)) return;
  ++piece_;
  const double us = ds / length, ut = dt / length;
  const double reach = half_width_mm_ * std::abs(ut) / slant_;
  const double low = std::min(z0_mm, z1_mm) - reach, high = std::max(z0_mm, z1_mm) + reach;
  const auto last = static_cast<double>(arcs_.size()) - 1;
  const double first_section = std::max(0.0, std::ceil(low / step_mm_ - 0.5));
  const double last_section = std::min(last, std::floor(high / step_mm_ - 0.5));
  for (double i = first_section; i <= last_section; ++i) {
    const double s = ((i + 0.5) * step_mm_ - z0_mm) * slant_;
    // Points (s, t): 0 <= along <= length, |across| <= half the width.
    double lo = -1e300, hi = 1e300;
    clip(s * us, ut, 0, length, lo, hi);
    clip(-s * ut, us, -half_width_mm_, half_width_mm_, lo, hi);
    if (lo <= hi)
      cover(static_cast<std::size_t>(i),
            {angle0_deg + degrees(lo / r), angle0_deg + degrees(hi / r), piece_});
  }
}

// Where the path bends, two rectangles leave a wedge on the outer side, which the tow spans: the arcs of a
// piece and the next on one circle are one.
void LaidBand::cover(std::size_t section, Arc arc) {
  std::vector<Arc>& arcs = arcs_[section];
  if (!arcs.empty() && arcs.back().piece + 1 >= arc.piece) {
    arcs.back() = {std::min(arc.from, arcs.back().from), std::max(arc.to, arcs.back().to), arc.piece};
  } else {
    arcs.push_back(arc);
  }
}

// The union of arcs round one circle, and what is bare between them.
LaidBand::Circle LaidBand::united(const std::vector<Arc>& laid) {
  Circle circle;
  std::vector<Arc> arcs;
  double farthest = 0;
  for (const Arc& arc : laid) {
    const double width = arc.to - arc.from;
    circle.laid_deg += width;
    if (width >= 360) circle.bare_deg = 0;
    const double from = modulo(arc.from, 360);
    arcs.push_back({from, from + width, arc.piece});
    farthest = std::max(farthest, from + width);
  }
  if (arcs.empty()) return {0, 360, 360, 180};
  if (circle.bare_deg == 0) return circle;
  std::sort(arcs.begin(), arcs.end(), [](const Arc& a, const Arc& b) { return a.from < b.from; });
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
  double reached = std::max(arcs.front().from, farthest - 360);
  for (const Arc& arc : arcs) {
    leave_bare(reached, arc.from);
    reached = std::max(reached, arc.to);
  }
  leave_bare(reached, arcs.front().from + 360);
  return circle;
}

BandCoverage LaidBand::coverage() const {
  BandCoverage out;
  double surface = 0, covered = 0, laid = 0;
  for (std::size_t i = 0; i < arcs_.size(); ++i) {
    const double z = (static_cast<double>(i) + 0.5) * step_mm_;
    const double mm_per_deg = radians(radius(z));
    const Circle circle = united(arcs_[i]);
    surface += 360 * mm_per_deg;
    covered += (360 - circle.bare_deg) * mm_per_deg;
    laid += circle.laid_deg * mm_per_deg;
    if (circle.widest_deg * mm_per_deg > out.widest_gap_mm) {
      out.widest_gap_mm = circle.widest_deg * mm_per_deg;
      out.gap_z_mm = z;
      out.gap_deg = circle.widest_at_deg;
    }
  }
  out.covered_share = covered / surface;
  out.overlap_share = covered > 0 ? (laid - covered) / covered : 0;
  return out;
}

}  // namespace afptraj
