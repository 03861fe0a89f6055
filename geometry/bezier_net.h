#pragma once

#include <vector>

#include "geometry/surface.h"

/// B-spline surfaces cut into Bezier pieces. Internal to this room.
namespace afptraj::bezier {

/// One knot span of a direction, and how the Bezier points on it follow from its degree + 1 poles.
struct SpanMatrix {
  double lo, hi;
  int first_pole, index;
  Eigen::MatrixXd to_bezier;
};
std::vector<SpanMatrix> span_matrices(const std::vector<double>& knots, int degree);

using Net = std::vector<Eigen::Vector4d>;  // homogeneous (w x, w y, w z, w), v fastest

/// The Bezier points of the piece over two spans.
Net bezier_net(const BSplineSurface& spline, const SpanMatrix& u, const SpanMatrix& v);

/// Splits a net of degrees p, q at the middle of one direction; `net` becomes the upper half.
Net split_net(Net& net, int p, int q, bool along_u);

/// The multiples of `period` by which [lo, hi] must be moved to meet [box_lo, box_hi]; 0 alone
/// where there is no period.
std::vector<double> shifts(double period, double lo, double hi, double box_lo, double box_hi);

}  // namespace afptraj::bezier
