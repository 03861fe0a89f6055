#pragma once

#include <vector>

#include "geometry/surface.h"

namespace afptraj {

/// Areas on a surface of regions of its parameter plane, by their boundaries: with A(u, v) the integral of
/// |Su x Sv| over v from the box's lower side, the area is the integral of -A du along the boundary (Green).
///
/// |Su x Sv| is interpolated by polynomials of degree 5 in cells that end on the surface's knot lines; what
/// follows is exact for the interpolant.
///
/// Laws, checked by tests/tow_coverage_test.cpp:
///   (C1) Two regions that share a boundary get areas that add up to that of their union, to rounding.
///   (C2) Zones of spheres, cones and tori hold to `error_mm2()`.
class ChartArea {
 public:
  /// Over the box from lo to hi (beyond the surface's domain: its continuation). Lengths of the box must not
  /// be 0.
  ChartArea(const Surface& surface, const Uv& lo, const Uv& hi);

  /// The share of the boundary from a to b, a straight line in (u, v): sum it along a loop. Positive
  /// in sum for anticlockwise loops.
  double along(const Uv& a, const Uv& b) const;

  /// Estimates the error of the area of any region of the box: the interpolant's at the corners of the cells,
  /// where it is worst, over their whole areas.
  double error_mm2() const { return error_; }

 private:
  static constexpr int degree = 5;
  struct Cell {
    double a[degree + 1][degree + 2];  // A by powers of the cell's x (in u) and y (in v), both in [-1, 1]
  };
  double value(std::size_t i, std::size_t j, const Uv& uv) const;
  double within_cell(const Uv& a, const Uv& b) const;

  std::vector<double> u_, v_;
  std::vector<Cell> cells_;  // by u, then v
  double error_ = 0;
};

}  // namespace afptraj
