#pragma once

#include <memory>
#include <string>
#include <vector>

#include "geometry/bspline_curve.h"
#include "geometry/surface.h"

namespace afptraj {

/// One use of an edge by a trim loop. The loop runs along `pcurve` from first to last, or the
/// other way when `reversed`; both uses of an edge give the same point at the same parameter, to
/// the edge's tolerance.
struct Coedge {
  BSplineCurve2 pcurve;
  bool reversed = false;
  int edge = -1;
};

/// A closed chain of coedges in (u, v). Material lies on the left: outer loops run anticlockwise,
/// holes clockwise, whatever the orientation of the face.
struct Loop {
  std::vector<Coedge> coedges;
};

/// A trimmed surface. The unit normal is S_u x S_v, turned when `reversed`.
struct Face {
  Surface surface;
  bool reversed = false;
  std::vector<Loop> loops;
  std::string name;      ///< from the file, may be empty
  std::string instance;  ///< path of product instances in an assembly, may be empty
  int step_id = 0;       ///< entity number in the file, 0 when unknown
};

/// An edge: where the loops of one or two faces (or one face twice: a seam) meet.
struct Edge {
  bool degenerate = false;  ///< a pole: a pcurve that is a single point in space
  double tolerance_mm = 0;  ///< how far the pcurves and the 3-D curve may lie apart
};

/// A boundary representation in mm: what a STEP file becomes.
struct Part {
  std::vector<Face> faces;
  std::vector<Edge> edges;
};

/// A face over a rectangle of a surface, with edges numbered from `first_edge` in the order
/// v = lo, u = hi, v = hi, u = lo. A direction that spans its whole period gets a seam (both
/// sides share one edge, so only three or two numbers are used); a side that shrinks to a point
/// is marked in `degenerate` (four flags, same order).
struct RectangularFace {
  Face face;
  std::vector<Edge> edges;
};
RectangularFace make_rectangular_face(const Surface& surface, const Interval& u, const Interval& v,
                                      int first_edge = 0);

/// A part of that one face: what tests and programs without a STEP file use.
Part make_rectangular_part(const Surface& surface, const Interval& u, const Interval& v);

}  // namespace afptraj
