#pragma once

#include <vector>

#include "trajectory/reference_path.h"
#include "trajectory/source_curve.h"

namespace afptraj {

/// A stretch of a path in one chart, with what its curve must hold at the ends.
struct Run {
  PathChart chart;
  std::vector<double> t;                           ///< length along the path's chords
  std::vector<Uv> at;                              ///< places in the chart
  bool fixed[2] = {false, false};                  ///< the curve begins, ends exactly there ...
  Vec3 tangent[2] = {Vec3::Zero(), Vec3::Zero()};  ///< ... along this direction, unless it is zero
};

/// Splits a path into runs that follow each other without a gap; all ends but the path's own are fixed.
///
/// In (u, v) as a rule, with a new run where the path goes over to another face, crosses a seam or a crease.
/// Where the coordinate lines turn within a few knot spacings - about a pole, or a side that is nearly one -
/// a curve smooth in the skin is none in (u, v): there, and where (u, v) of one point do not lead to the
/// next, the chart is one about a geodesic. `knot_spacing_mm`: of the splines that are to be fitted to the
/// runs. `margin_mm`: how far the geodesic of a chart may lie beside the skin.
std::vector<Run> split_runs(const Skin& skin, const SteppedPath& path, double knot_spacing_mm,
                            double margin_mm);

}  // namespace afptraj
