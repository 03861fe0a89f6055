#pragma once

#include <vector>

#include "boundary/ply.h"
#include "geometry/surface_curve.h"
#include "trajectory/direction_field.h"

namespace afptraj {

/// The stretches of a curve inside the trim loops of the skin: all loops count, outer ones and
/// holes. The crossings path(s) = loop(t) are solved in (u, v) by Newton-Raphson with bisection as
/// the fall-back, to 1e-12 of the loops' size; the ends lie on the loop's pcurve exactly.
/// Stretches shorter than `least_mm` are dropped. Clipping twice changes nothing.
std::vector<SurfaceCurve> clip_to_skin(const Skin& skin, const SurfaceCurve& curve, double least_mm = 1e-3);

/// The other stretches: where the curve runs on the continuation of the skin. A band whose centre
/// line is off the skin may still reach onto it.
std::vector<SurfaceCurve> off_skin(const Skin& skin, const SurfaceCurve& curve, double least_mm = 1e-3);

/// Samples of a curve: its nodes, with arc length, Darboux frame, curvatures and the deviation from
/// the field.
CourseSegment sample_segment(const Skin& skin, const SurfaceCurve& curve, const DirectionField& field);

/// The curve through the samples of a segment: what sample_segment() made it from.
SurfaceCurve curve_of(const Skin& skin, const CourseSegment& segment);

/// Signed angle from the axis `asked` to `tangent` about `normal`, folded into (-pi/2, pi/2].
double axis_deviation(const Vec3& asked, const Vec3& tangent, const Vec3& normal);

}  // namespace afptraj
