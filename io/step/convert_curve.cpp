#include <Geom2dAdaptor_Curve.hxx>
#include <Geom2dConvert.hxx>
#include <Geom2d_BSplineCurve.hxx>
#include <Geom2d_BezierCurve.hxx>
#include <Geom2d_Line.hxx>
#include <Geom2d_TrimmedCurve.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <algorithm>
#include <cmath>

#include "io/step/convert.h"
#include "io/step/interpolate.h"
#include "io/step/occt.h"

namespace afptraj::step {
namespace {

Handle(Geom2d_Curve) untrimmed(Handle(Geom2d_Curve) curve) {
  while (true) {
    const auto trimmed = Handle(Geom2d_TrimmedCurve)::DownCast(curve);
    if (trimmed.IsNull()) return curve;
    curve = trimmed->BasisCurve();
  }
}

BSplineCurve2 from_occt(const Handle(Geom2d_BSplineCurve)& spline) {
  BSplineCurve2 curve;
  curve.degree = spline->Degree();
  for (int k = 1; k <= spline->NbKnots(); ++k) {
    curve.knots.insert(curve.knots.end(), static_cast<std::size_t>(spline->Multiplicity(k)), spline->Knot(k));
  }
  for (int i = 1; i <= spline->NbPoles(); ++i) {
    curve.poles.push_back(to_uv(spline->Pole(i)));
    if (spline->IsRational()) curve.weights.push_back(spline->Weight(i));
  }
  return curve;
}

/// Knot insertion snaps to knots near the ends: puts the domain back to [first, last], a change of
/// parameter of the order of 1e-9 of the domain.
void stretch_knots(BSplineCurve2& curve, double first, double last) {
  const double a = curve.first(), b = curve.last();
  if (a == first && b == last) return;
  for (double& knot : curve.knots) {
    knot = knot == a ? first : knot == b ? last : first + (knot - a) * (last - first) / (b - a);
  }
}

/// The B-spline over [first, last] by knot insertion, or nothing where it does not reach so far.
bool cut_spline(Handle(Geom2d_BSplineCurve) spline, double first, double last, BSplineCurve2& result) {
  const double slack = 1e-9 * (last - first);
  if (first < spline->FirstParameter() - slack || last > spline->LastParameter() + slack) return false;
  spline = Handle(Geom2d_BSplineCurve)::DownCast(spline->Copy());
  if (spline->IsPeriodic()) spline->SetNotPeriodic();
  const double a = std::max(first, spline->FirstParameter()), b = std::min(last, spline->LastParameter());
  const bool whole = a == spline->FirstParameter() && b == spline->LastParameter() &&
                     spline->Multiplicity(1) == spline->Degree() + 1 &&
                     spline->Multiplicity(spline->NbKnots()) == spline->Degree() + 1;
  if (!whole) spline->Segment(a, b);
  result = from_occt(spline);
  if (std::abs(result.first() - first) > 2 * slack || std::abs(result.last() - last) > 2 * slack)
    return false;
  stretch_knots(result, first, last);
  return true;
}

std::vector<double> smooth_intervals(const Handle(Geom2d_Curve)& curve, double first, double last) {
  const Geom2dAdaptor_Curve adaptor(curve, first, last);
  TColStd_Array1OfReal ends(1, adaptor.NbIntervals(GeomAbs_CN) + 1);
  adaptor.Intervals(ends, GeomAbs_CN);
  std::vector<double> breaks = {first};
  const double least = 1e-9 * (last - first);
  for (const double t : ends) {
    if (t > breaks.back() + least && t < last - least) breaks.push_back(t);
  }
  breaks.push_back(last);
  return breaks;
}

}  // namespace

BSplineCurve2 convert_pcurve(const Handle(Geom2d_Curve)& given, double first, double last) {
  const Handle(Geom2d_Curve) curve = untrimmed(given);
  if (curve->IsKind(STANDARD_TYPE(Geom2d_Line))) {
    return line_segment(to_uv(curve->Value(first)), to_uv(curve->Value(last)), first, last);
  }
  Handle(Geom2d_BSplineCurve) spline = Handle(Geom2d_BSplineCurve)::DownCast(curve);
  if (curve->IsKind(STANDARD_TYPE(Geom2d_BezierCurve))) spline = Geom2dConvert::CurveToBSplineCurve(curve);
  BSplineCurve2 result;
  if (!spline.IsNull() && cut_spline(spline, first, last, result)) return result;
  UvBox box;
  for (int k = 0; k <= 16; ++k) box.add(to_uv(curve->Value(first + (last - first) * k / 16)));
  const double size = std::max(box.lo.cwiseAbs().maxCoeff(), box.hi.cwiseAbs().maxCoeff());
  const double tolerance = std::max(1e-12 * (box.hi - box.lo).maxCoeff(), 2e-14 * size);
  return interpolate_curve([&](double t) { return to_uv(curve->Value(t)); },
                           smooth_intervals(curve, first, last), [&](double, double) { return tolerance; })
      .curve;
}

}  // namespace afptraj::step
