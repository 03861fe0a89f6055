#pragma once

#include <vector>

#include "io/step/read_step.h"

namespace afptraj::step {

/// Finishes the edges of a part that was just read:
///  - both uses of a shared edge give the same point at the same parameter: where they do not, one
///    pcurve is put in the parametrisation of the other;
///  - free edges that coincide within the tolerance become one shared edge; where only a part of
///    an edge coincides, it is cut at the ends of the other. Solids are joined only with themselves,
///    shells and loose faces (body -1) with each other;
///  - faces that were joined are turned so that their normals agree, outward where they close a
///    volume, else as most of them were.
///
/// `bodies` is one number a face; `tolerance_mm` as StepReadOptions::sew_tolerance_mm. An edge
/// shorter than 20 tolerances is joined only within a twentieth of its length. Fills in the
/// fields of the model about sewing and gaps, and the tolerances of its edges.
void join_edges(StepModel& model, const std::vector<int>& bodies, double tolerance_mm);

}  // namespace afptraj::step
