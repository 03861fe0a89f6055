#pragma once

#include <vector>

#include "boundary/ply.h"
#include "geometry/skin.h"
#include "io/step/write_step.h"

namespace afptraj {

struct PathFitOptions {
  double sample_mm = 2e-5;   ///< greatest distance of a sample from the curve
  double surface_mm = 5e-5;  ///< greatest distance of the curve from the skin, checked between samples
};

/// The centre line of a segment as B-splines: cubic, C1, parametrised by arc length, with as few
/// pieces as hold both tolerances. Pieces are cubic Hermite between samples; where samples are too
/// far apart, points between them are projected to the skin. One curve, or several joined end to
/// end where the path has a kink.
/// Source: Piegl & Tiller, The NURBS Book, ch. 9.3.4 (C1 cubic interpolation).
std::vector<BSplineCurve3> fit_segment(const Skin& skin, const CourseSegment& segment,
                                       const PathFitOptions& options = {});

/// All course segments as named wires, grouped by ply: "ply P1 course +3 segment 1". Every ply has
/// its colour; courses to the right are darker, the reference course is black.
std::vector<StepWire> path_wires(const Skin& skin, const std::vector<Ply>& plies,
                                 const PathFitOptions& options = {});

}  // namespace afptraj
