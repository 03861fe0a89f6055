#include <GeomAdaptor_Surface.hxx>
#include <GeomConvert.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_BezierSurface.hxx>
#include <Geom_ConicalSurface.hxx>
#include <Geom_CylindricalSurface.hxx>
#include <Geom_Plane.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <Geom_SphericalSurface.hxx>
#include <Geom_ToroidalSurface.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <algorithm>
#include <cmath>

#include "io/step/convert.h"
#include "io/step/interpolate.h"
#include "io/step/occt.h"

namespace afptraj::step {
namespace {

Frame to_frame(const gp_Ax3& axes) {
  return {to_vec3(axes.Location()), to_vec3(axes.XDirection()), to_vec3(axes.YDirection()),
          to_vec3(axes.Direction())};
}

/// The kinds that both sides have, with the same formulas.
bool convert_analytic(const Handle(Geom_Surface)& surface, PlainSurface& plain) {
  if (const auto s = Handle(Geom_Plane)::DownCast(surface)) {
    plain = {SurfaceKind::plane, to_frame(s->Position()), 0, 0, {}};
  } else if (const auto c = Handle(Geom_CylindricalSurface)::DownCast(surface)) {
    plain = {SurfaceKind::cylinder, to_frame(c->Position()), c->Radius(), 0, {}};
  } else if (const auto k = Handle(Geom_ConicalSurface)::DownCast(surface)) {
    plain = {SurfaceKind::cone, to_frame(k->Position()), k->RefRadius(), k->SemiAngle(), {}};
  } else if (const auto b = Handle(Geom_SphericalSurface)::DownCast(surface)) {
    plain = {SurfaceKind::sphere, to_frame(b->Position()), b->Radius(), 0, {}};
  } else if (const auto t = Handle(Geom_ToroidalSurface)::DownCast(surface)) {
    plain = {SurfaceKind::torus, to_frame(t->Position()), t->MajorRadius(), t->MinorRadius(), {}};
  } else {
    return false;
  }
  return true;
}

bool is_clamped(const Handle(Geom_BSplineSurface)& s) {
  return s->UMultiplicity(1) == s->UDegree() + 1 && s->UMultiplicity(s->NbUKnots()) == s->UDegree() + 1 &&
         s->VMultiplicity(1) == s->VDegree() + 1 && s->VMultiplicity(s->NbVKnots()) == s->VDegree() + 1;
}

BSplineSurface from_occt(const Handle(Geom_BSplineSurface)& given) {
  BSplineSurface spline;
  spline.periodic_u = given->IsUPeriodic();
  spline.periodic_v = given->IsVPeriodic();
  Handle(Geom_BSplineSurface) s = given;
  if (spline.periodic_u || spline.periodic_v || !is_clamped(given)) {
    s = Handle(Geom_BSplineSurface)::DownCast(given->Copy());
    if (spline.periodic_u) s->SetUNotPeriodic();
    if (spline.periodic_v) s->SetVNotPeriodic();
    if (!is_clamped(s)) {
      double u0, u1, v0, v1;
      s->Bounds(u0, u1, v0, v1);
      s->Segment(u0, u1, v0, v1);
    }
  }
  spline.degree_u = s->UDegree(), spline.degree_v = s->VDegree();
  for (int k = 1; k <= s->NbUKnots(); ++k) {
    spline.knots_u.insert(spline.knots_u.end(), static_cast<std::size_t>(s->UMultiplicity(k)), s->UKnot(k));
  }
  for (int k = 1; k <= s->NbVKnots(); ++k) {
    spline.knots_v.insert(spline.knots_v.end(), static_cast<std::size_t>(s->VMultiplicity(k)), s->VKnot(k));
  }
  const bool rational = s->IsURational() || s->IsVRational();
  for (int i = 1; i <= s->NbUPoles(); ++i) {
    for (int j = 1; j <= s->NbVPoles(); ++j) {
      spline.poles.push_back(to_vec3(s->Pole(i, j)));
      if (rational) spline.weights.push_back(s->Weight(i, j));
    }
  }
  return spline;
}

/// The interval of one parameter to interpolate over: the box and a margin, inside of the natural
/// bounds; the whole period where box and margin come near to it.
struct Window {
  double lo, hi;
  bool periodic;
};
Window window(double lo, double hi, double natural_lo, double natural_hi, double period) {
  const double margin = 0.05 * (hi - lo);
  if (period > 0) {
    if (hi - lo + 2 * margin >= period) return {lo, lo + period, true};
    return {lo - margin, hi + margin, false};
  }
  return {std::max(lo - margin, natural_lo), std::min(hi + margin, natural_hi), false};
}

std::vector<double> breaks_within(const TColStd_Array1OfReal& ends, double lo, double hi) {
  std::vector<double> breaks = {lo};
  const double least = 1e-9 * (hi - lo);
  for (const double t : ends) {
    if (t > breaks.back() + least && t < hi - least) breaks.push_back(t);
  }
  breaks.push_back(hi);
  return breaks;
}

ConvertedSurface interpolate(const Handle(Geom_Surface)& surface, const UvBox& box) {
  double u0, u1, v0, v1;
  surface->Bounds(u0, u1, v0, v1);
  const Window u = window(box.lo.x(), box.hi.x(), u0, u1, surface->IsUPeriodic() ? surface->UPeriod() : 0);
  const Window v = window(box.lo.y(), box.hi.y(), v0, v1, surface->IsVPeriodic() ? surface->VPeriod() : 0);
  const GeomAdaptor_Surface adaptor(surface, u.lo, u.hi, v.lo, v.hi);
  TColStd_Array1OfReal ends_u(1, adaptor.NbUIntervals(GeomAbs_CN) + 1),
      ends_v(1, adaptor.NbVIntervals(GeomAbs_CN) + 1);
  adaptor.UIntervals(ends_u, GeomAbs_CN);
  adaptor.VIntervals(ends_v, GeomAbs_CN);

  Vec3 lo = Vec3::Constant(1e300), hi = Vec3::Constant(-1e300);
  double far = 0;
  for (int i = 0; i <= 8; ++i) {
    for (int j = 0; j <= 8; ++j) {
      const Vec3 p = to_vec3(surface->Value(u.lo + (u.hi - u.lo) * i / 8, v.lo + (v.hi - v.lo) * j / 8));
      lo = lo.cwiseMin(p), hi = hi.cwiseMax(p);
      far = std::max(far, p.cwiseAbs().maxCoeff());
    }
  }
  ConvertedSurface result;
  result.tolerance_mm = std::max(std::min(1e-10 * std::max(1.0, (hi - lo).norm()), 1e-9), 2e-13 * far);
  SurfaceInterpolation made =
      interpolate_surface([&](double x, double y) { return to_vec3(surface->Value(x, y)); },
                          breaks_within(ends_u, u.lo, u.hi), breaks_within(ends_v, v.lo, v.hi),
                          0.5 * result.tolerance_mm);  // between the probes it errs a little more
  made.spline.periodic_u = u.periodic;
  made.spline.periodic_v = v.periodic;
  result.surface.kind = SurfaceKind::bspline;
  result.surface.spline = std::move(made.spline);
  result.error_mm = made.error;
  return result;
}

}  // namespace

Handle(Geom_Surface) untrimmed(Handle(Geom_Surface) surface) {
  while (true) {
    const auto trimmed = Handle(Geom_RectangularTrimmedSurface)::DownCast(surface);
    if (trimmed.IsNull()) return surface;
    surface = trimmed->BasisSurface();
  }
}

ConvertedSurface convert_surface(const Handle(Geom_Surface)& given, const UvBox& box) {
  const Handle(Geom_Surface) surface = untrimmed(given);
  ConvertedSurface result;
  if (convert_analytic(surface, result.surface)) return result;
  Handle(Geom_BSplineSurface) spline = Handle(Geom_BSplineSurface)::DownCast(surface);
  if (surface->IsKind(STANDARD_TYPE(Geom_BezierSurface)))
    spline = GeomConvert::SurfaceToBSplineSurface(surface);
  if (!spline.IsNull()) {
    result.surface.kind = SurfaceKind::bspline;
    result.surface.spline = from_occt(spline);
    return result;
  }
  return interpolate(surface, box);
}

}  // namespace afptraj::step
