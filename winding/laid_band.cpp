#include "winding/laid_band.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "winding/frustum.h"

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
      cover(arcs_[static_cast<std::size_t>(i)],
            {angle0_deg + degrees(lo / r), angle0_deg + degrees(hi / r), piece_});
  }
}

BandCoverage LaidBand::coverage() const {
  CoverageSum sum;
  for (std::size_t i = 0; i < arcs_.size(); ++i) {
    const double z = (static_cast<double>(i) + 0.5) * step_mm_;
    sum.add(z, radius(z), 1, arcs_[i]);
  }
  return sum.coverage();
}

}  // namespace afptraj
