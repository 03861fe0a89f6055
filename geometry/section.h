#pragma once

#include <vector>

#include "geometry/skin.h"

namespace afptraj {

/// The plane through `origin` with unit `normal`.
struct Plane {
  Vec3 origin = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();
};

/// One connected branch of a section: samples in order, with arc length from the first. Where it
/// passes from face to face, or over a seam, the place appears twice, with the parameters of each
/// side; a closed branch ends with its first point.
struct SectionCurve {
  std::vector<SurfacePoint> points;
  std::vector<double> s_mm;
  bool closed = false;
  double length_mm() const { return s_mm.empty() ? 0 : s_mm.back(); }
};

struct SectionOptions {
  /// Greatest distance between samples; they get closer where the curve bends, so that the arc
  /// length is right to `tolerance_mm` per metre (Hermite quadrature, error O(step^4)).
  double step_mm = 5;
  double tolerance_mm = 5e-7;
};

/// The branch of plane ∩ skin through `start` (a point of the skin on the plane, to 1e-6 mm),
/// followed from there in the direction `heading` (its part along the section counts) until it
/// leaves the skin, meets a pole, or returns to the start. Crosses shared edges and seams.
/// Marches in (u, v) with a Newton correction on the plane's equation.
SectionCurve trace_section(const Skin& skin, const Plane& plane, const SurfacePoint& start,
                           const Vec3& heading, const SectionOptions& options = {});

/// All branches of plane ∩ skin: seeds from the loops and, for closed branches inside, from sign
/// changes over pieces of the surface, subdivided.
std::vector<SectionCurve> section(const Skin& skin, const Plane& plane, const SectionOptions& options = {});

}  // namespace afptraj
