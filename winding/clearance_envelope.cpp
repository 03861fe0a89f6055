#include "winding/clearance_envelope.h"

#include <algorithm>
#include <cmath>

namespace afptraj {
namespace {

MeridianRow row_at(const Meridian& meridian, double t) {
  const MeridianPoint at = meridian.at(t);
  return {at.z_mm, at.r_mm};
}

double off_chord(const MeridianRow& a, const MeridianRow& b, const MeridianRow& p) {
  const double dz = b.z_mm - a.z_mm, dr = b.r_mm - a.r_mm, length = std::hypot(dz, dr);
  if (length == 0) return 0;
  return std::abs((p.z_mm - a.z_mm) * dr - (p.r_mm - a.r_mm) * dz) / length;
}

// Halves until the curve at the quarters is on the chord.
void add_outline(const Meridian& meridian, double t0, double t1, int depth, std::vector<MeridianRow>& out) {
  constexpr int deepest = 12;
  const MeridianRow a = out.back(), b = row_at(meridian, t1);
  double worst = 0;
  for (const double share : {0.25, 0.5, 0.75})
    worst = std::max(worst, off_chord(a, b, row_at(meridian, t0 + share * (t1 - t0))));
  if (worst <= outline_sagitta_mm || depth >= deepest) {
    out.push_back(b);
    return;
  }
  const double middle = (t0 + t1) / 2;
  add_outline(meridian, t0, middle, depth + 1, out);
  add_outline(meridian, middle, t1, depth + 1, out);
}

// The upper hull of rows of growing z (Andrew's monotone chain).
std::vector<MeridianRow> upper_hull(const std::vector<MeridianRow>& rows) {
  std::vector<MeridianRow> hull;
  const auto bends_up = [](const MeridianRow& a, const MeridianRow& b, const MeridianRow& c) {
    return (b.z_mm - a.z_mm) * (c.r_mm - a.r_mm) - (b.r_mm - a.r_mm) * (c.z_mm - a.z_mm) >= 0;
  };
  for (const MeridianRow& row : rows) {
    while (hull.size() > 1 && bends_up(hull[hull.size() - 2], hull.back(), row)) hull.pop_back();
    hull.push_back(row);
  }
  return hull;
}

}  // namespace

ClearanceEnvelope::ClearanceEnvelope(const Meridian& meridian, double clearance_mm)
    : clearance_mm_(clearance_mm), widest_mm_(meridian.at(meridian.widest()).r_mm) {
  const std::vector<double>& breaks = meridian.breaks();
  outline_.push_back(row_at(meridian, breaks.front()));
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i)
    add_outline(meridian, breaks[i], breaks[i + 1], 0, outline_);
  std::vector<MeridianRow> closed{{outline_.front().z_mm, 0}};
  closed.insert(closed.end(), outline_.begin(), outline_.end());
  closed.push_back({outline_.back().z_mm, 0});
  hull_ = upper_hull(closed);
}

ClearanceEnvelope::Distance ClearanceEnvelope::distance(double z_mm, double radius_mm) const {
  double least = 1e300, by_z = 0, by_radius = 0;  // squared; the way from the nearest place of the hull
  bool inside = z_mm >= hull_.front().z_mm && z_mm <= hull_.back().z_mm;
  const auto compare = [&](std::size_t i) {
    const MeridianRow &a = hull_[i], &b = hull_[i + 1];
    const double ez = b.z_mm - a.z_mm, er = b.r_mm - a.r_mm, square = ez * ez + er * er;
    if (square == 0) return;
    const double pz = z_mm - a.z_mm, pr = radius_mm - a.r_mm;
    if (z_mm >= a.z_mm && z_mm <= b.z_mm && pr * ez - pz * er > 0) inside = false;
    const double share = std::clamp((pz * ez + pr * er) / square, 0.0, 1.0);
    const double qz = pz - share * ez, qr = pr - share * er, far = qz * qz + qr * qr;
    if (far >= least) return;
    least = far;
    by_z = qz;
    by_radius = qr;
  };
  // z grows along the hull: from the place beside outwards, as long as nearer edges can come.
  const auto beside = std::lower_bound(hull_.begin(), hull_.end(), z_mm,
                                       [](const MeridianRow& row, double z) { return row.z_mm < z; });
  const auto middle = static_cast<std::size_t>(beside - hull_.begin());
  const auto reaches = [&](double z) { return (z - z_mm) * (z - z_mm) <= least; };
  for (std::size_t i = middle; i + 1 < hull_.size() && reaches(hull_[i].z_mm); ++i) compare(i);
  for (std::size_t i = std::min(middle, hull_.size() - 1); i-- > 0 && reaches(hull_[i + 1].z_mm);) compare(i);
  const double mm = std::hypot(by_z, by_radius);
  return inside || mm == 0 ? Distance{} : Distance{mm, by_z / mm, by_radius / mm};
}

double ClearanceEnvelope::depth_mm(double z_mm, double radius_mm) const {
  if (z_mm < outline_.front().z_mm || z_mm > outline_.back().z_mm) return -radius_mm;
  auto after = std::upper_bound(outline_.begin(), outline_.end(), z_mm,
                                [](double z, const MeridianRow& row) { return z < row.z_mm; });
  if (after == outline_.end()) --after;
  if (after == outline_.begin()) ++after;
  const MeridianRow &a = *(after - 1), &b = *after;
  const double share = b.z_mm > a.z_mm ? (z_mm - a.z_mm) / (b.z_mm - a.z_mm) : 1;
  return a.r_mm + share * (b.r_mm - a.r_mm) - radius_mm;
}

}  // namespace afptraj
