#pragma once

// Private to io/step: curves on surfaces that should be the same curve of space. No OpenCASCADE here.

#include <functional>
#include <utility>
#include <vector>

#include "geometry/bspline_curve.h"
#include "geometry/surface.h"

namespace afptraj::step {

/// A pcurve with its surface: a curve of space.
struct SpaceCurve {
  const Surface* surface = nullptr;
  const BSplineCurve2* pcurve = nullptr;

  double first() const { return pcurve->first(); }
  double last() const { return pcurve->last(); }
  Vec3 point(double t) const { return surface->point(pcurve->point(t)); }
  struct Tangent {
    Vec3 point, derivative;
  };
  Tangent tangent(double t) const;
};

/// Samples of a space curve at equal steps of its parameter, with the length of the chords.
struct SampledCurve {
  std::vector<double> t;
  std::vector<Vec3> points;
  std::vector<double> s;  ///< chord length from the first point
  Vec3 lo, hi;            ///< box of the points
  double length() const { return s.back(); }
};
SampledCurve sample_curve(const SpaceCurve& curve, int pieces = 32);

/// The parameter of the point of `curve` nearest to `p`: Gauss-Newton from the nearest sample. The
/// result may lie beyond the ends by a little.
double nearest_parameter(const SpaceCurve& curve, const SampledCurve& samples, const Vec3& p);

/// Greatest |a(t) - b(t)| over 8 points a knot span of both pcurves, in mm, and a t where it is
/// reached; their domains must agree.
struct Gap {
  double distance = 0, t = 0;
};
Gap greatest_gap(const SpaceCurve& a, const SpaceCurve& b);

/// The pcurve of `b` in the parametrisation of `a`: at every t it gives the point of b nearest to
/// a(t); ends go to ends (start to end when `opposite`). In this order, the next one only where
/// samples promise that it brings a and b closer together:
///   1. an affine change of parameter;
///   2. the nearest point of b's own trace, interpolated to 1e-9 mm;
///   3. the feet of a(t) on b's surface: b's pcurve was a poor image of the common edge.
BSplineCurve2 in_parameters_of(const SpaceCurve& a, const SpaceCurve& b, bool opposite);

/// The pcurve through the feet of the points `curve`(t) on the surface of `seed`, a pcurve near to
/// it with the same domain whose ends it keeps. `breaks`: where `curve` is not smooth.
BSplineCurve2 pcurve_of_feet(const std::function<Vec3(double)>& curve, const std::vector<double>& breaks,
                             const SpaceCurve& seed);

/// Distance of a point from the surface, by its foot near `start`.
double foot_distance(const Surface& surface, const Vec3& point, const Uv& start);

/// Both parts of a curve cut at `t` inside its domain, by knot insertion.
std::pair<BSplineCurve2, BSplineCurve2> split_curve(const BSplineCurve2& curve, double t);

}  // namespace afptraj::step
