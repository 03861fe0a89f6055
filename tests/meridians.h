#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "winding/meridian.h"

namespace afptraj::test {

/// The quarter of an ellipse from (z0, r0) to (z1, r1), whose tangents there are along the axis and across it
/// (`axial_first`), or the other way round: a rational parabola, exact.
inline BSplineCurve2 quarter_ellipse(double z0, double r0, double z1, double r1, bool axial_first) {
  BSplineCurve2 curve;
  curve.degree = 2;
  curve.knots = {0, 0, 0, 1, 1, 1};
  curve.poles = {{z0, r0}, axial_first ? Eigen::Vector2d{z1, r0} : Eigen::Vector2d{z0, r1}, {z1, r1}};
  curve.weights = {1, std::numbers::sqrt2 / 2, 1};
  return curve;
}

/// A cylinder of radius R and length L from z = 0, with domes of half-axis `height` (R: hemispheres).
inline Meridian vessel(double R, double L, double height) {
  std::vector<BSplineCurve2> pieces{quarter_ellipse(-height, 0, 0, R, false)};
  if (L > 0) pieces.push_back(line_segment({0, R}, {L, R}));
  pieces.push_back(quarter_ellipse(L, R, L + height, 0, true));
  return Meridian(std::move(pieces));
}

}  // namespace afptraj::test
