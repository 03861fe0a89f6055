#pragma once

// Private to io/step: the loops of one OpenCASCADE face as closed chains in (u, v).

#include <Geom_Surface.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <string>
#include <vector>

#include "io/step/convert.h"

namespace afptraj::step {

/// A coedge before its edge has a number.
struct RawCoedge {
  BSplineCurve2 pcurve;
  bool reversed = false;
  bool degenerate = false;
  double tolerance_mm = 0;
  TopoDS_Edge edge;  ///< null for one that was inserted to close a loop
};
using RawLoop = std::vector<RawCoedge>;

/// Something that had to be mended, with its size in mm where it has one.
struct Repair {
  std::string what;
  double mm = 0;
};

struct RawLoops {
  std::vector<RawLoop> loops;  ///< outer first; material on the left
  UvBox box;                   ///< of the poles of all pcurves
  std::vector<Repair> repairs;
};

/// Collects the wires of `face` (natural bounds where it has none). Consecutive coedges meet
/// exactly in (u, v): whole periods are taken off, ends within tolerance are moved together, a pole
/// without an edge gets a degenerate one. Throws Standard_Failure where OpenCASCADE does, and
/// Error(bad_input) for a face whose wires cannot be used.
RawLoops build_loops(const TopoDS_Face& face);

/// Twice the signed area of a loop in (u, v), positive when it runs anticlockwise.
double signed_area(const RawLoop& loop);

}  // namespace afptraj::step
