#pragma once

// Private to io/step: OpenCASCADE geometry as plain geometry, in the same parametrisation.

#include <Geom2d_Curve.hxx>
#include <Geom_Surface.hxx>
#include <string>

#include "io/step/part_codec.h"

namespace afptraj::step {

/// A box in (u, v).
struct UvBox {
  Uv lo = Uv::Constant(1e300), hi = Uv::Constant(-1e300);
  void add(const Uv& p) {
    lo = lo.cwiseMin(p);
    hi = hi.cwiseMax(p);
  }
};

struct ConvertedSurface {
  PlainSurface surface;
  double error_mm = 0;      ///< of an interpolated kind, sampled; 0 for kinds that are kept
  double tolerance_mm = 0;  ///< what was asked of it
};

/// The surface over the (u, v) box of a face's loops. Planes, cylinders, cones, spheres, tori and
/// B-splines are kept whole; a Bezier becomes its B-spline; every other kind is interpolated over
/// the box and a margin of a twentieth, or over its period where the box needs all of it.
ConvertedSurface convert_surface(const Handle(Geom_Surface)& surface, const UvBox& box);

/// Strips trimming from a surface: the parametrisation stays.
Handle(Geom_Surface) untrimmed(Handle(Geom_Surface) surface);

/// A pcurve over [first, last] as a B-spline with that domain and the same parametrisation, to
/// 1e-12 of its extent in (u, v).
BSplineCurve2 convert_pcurve(const Handle(Geom2d_Curve)& curve, double first, double last);

}  // namespace afptraj::step
