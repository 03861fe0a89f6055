#pragma once

#include <vector>

#include "geometry/part.h"

/// The flattened loops of a face in a grid of cells. Internal to this room; see trim_region.h.
///
/// Coordinates here are (u, v) times a power of two per direction, which makes the loops about one
/// unit wide in both and changes no bit of the mantissas: predicates on them are predicates on (u, v).
namespace afptraj::trim {

/// A piece of a loop, in the sense of the loop. The true pcurve lies within `eps` of the chord
/// from `a` to `b` (hull of its Bezier points); its parameter runs from t0 to t1.
struct Segment {
  Uv a, b;
  double eps = 0;
  double t0 = 0, t1 = 0;
  int loop = -1, coedge = -1;
  int control = 0;  ///< first of degree + 1 homogeneous Bezier points in SegmentGrid::control
  int degree = 1;
};

enum class CellState : signed char { outside, inside, mixed };

struct SegmentGrid {
  std::vector<Loop> loops;
  Uv scale, box_lo, box_hi;  // the box in (u, v), not scaled
  double on = 0;             // within this distance of a loop a point is on it
  std::vector<Segment> segments;
  std::vector<Eigen::Vector3d> control;  // (w u, w v, w)

  Uv lo, cells_per_unit;
  int nx = 0, ny = 0;
  std::vector<CellState> state;
  std::vector<int> cell_begin, cell_segments;
  std::vector<int> row_begin, row_segments;
  std::vector<int> mixed_before;  // mixed cells in [0, i) x [0, j)

  SegmentGrid(const Face& face, double flatten_uv);

  Uv scaled(const Uv& uv) const { return uv.cwiseProduct(scale); }
  /// The cells that the box touches; false when it misses the grid.
  bool cells(const Uv& box_min, const Uv& box_max, int& i0, int& i1, int& j0, int& j1) const {
    const Uv x = (box_min - lo).cwiseProduct(cells_per_unit);
    const Uv y = (box_max - lo).cwiseProduct(cells_per_unit);
    if (!(y.x() >= 0 && y.y() >= 0 && x.x() <= nx && x.y() <= ny)) return false;
    i0 = x.x() > 0 ? static_cast<int>(x.x()) : 0;
    j0 = x.y() > 0 ? static_cast<int>(x.y()) : 0;
    i1 = y.x() < nx ? static_cast<int>(y.x()) : nx - 1;
    j1 = y.y() < ny ? static_cast<int>(y.y()) : ny - 1;
    if (i0 >= nx) i0 = nx - 1;
    if (j0 >= ny) j0 = ny - 1;
    return true;
  }
  int mixed_count(int i0, int i1, int j0, int j1) const {
    const auto at = [this](int i, int j) { return mixed_before[static_cast<std::size_t>(j * (nx + 1) + i)]; };
    return at(i1 + 1, j1 + 1) - at(i0, j1 + 1) - at(i1 + 1, j0) + at(i0, j0);
  }
  CellState cell_state(int i, int j) const { return state[static_cast<std::size_t>(j * nx + i)]; }

  /// Of a scaled point; on a loop counts as inside.
  bool contains(const Uv& p) const;

 private:
  void flatten(int loop, const Loop& chain, double tolerance);
  void set_scale();
  void build_cells();
  void fill_states();
  bool contains_in_row(const Uv& p, int row) const;
};

/// Distance of `p` from the chord a-b.
double chord_distance(const Uv& p, const Uv& a, const Uv& b);
/// A homogeneous point of the plane projected.
inline Uv project(const Eigen::Vector3d& h) { return h.head<2>() / h.z(); }
/// Greatest distance of projected control points from the chord.
double hull_deviation(const std::vector<Eigen::Vector3d>& control, const Uv& a, const Uv& b);

}  // namespace afptraj::trim
