#pragma once

#include <cmath>

#include "tests/specimens.h"

namespace afptraj {

/// A whole sphere of radius R about the origin, with its poles on the z axis.
inline Skin sphere_skin(double R) {
  return make_skin(Surface::sphere({}, R), {0, 2 * pi}, {-pi / 2, pi / 2});
}

/// The nose of an ellipsoid with half axes a, b, c, to half of its length along z: two faces, y >= 0 and y <=
/// 0, that share two meridians and the pole at (0, 0, c).
inline Skin ellipsoid_nose(double a, double b, double c) {
  const double h = std::sqrt(0.5);
  const auto half = [&](double side) {
    BSplineSurface s;
    s.degree_u = s.degree_v = 2;
    s.knots_u = {0, 0, 0, 1, 1, 2, 2, 2};  // two quarters of a circle
    s.knots_v = {0, 0, 0, 1, 1, 1};        // from the equator to the pole
    const double circle[5][3] = {{1, 0, 1}, {1, 1, h}, {0, 1, 1}, {-1, 1, h}, {-1, 0, 1}};
    const double meridian[3][3] = {{1, 0, 1}, {1, 1, h}, {0, 1, 1}};
    for (const auto& u : circle)
      for (const auto& v : meridian) {
        s.poles.emplace_back(a * side * u[0] * v[0], b * side * u[1] * v[0], c * v[1]);
        s.weights.push_back(u[2] * v[2]);
      }
    return Surface::bspline(s);
  };
  RectangularFace front = make_rectangular_face(half(1), {0, 2}, {0, 1});
  RectangularFace back =
      make_rectangular_face(half(-1), {0, 2}, {0, 1}, static_cast<int>(front.edges.size()));
  // Sides in order: v = 0, u = 2, v = 1, u = 0. Where one face ends in u the other one begins.
  auto& coedges = back.face.loops[0].coedges;
  coedges[1].edge = front.face.loops[0].coedges[3].edge;
  coedges[3].edge = front.face.loops[0].coedges[1].edge;
  Part part;
  part.faces = {front.face, back.face};
  part.edges = front.edges;
  part.edges.insert(part.edges.end(), back.edges.begin(), back.edges.end());
  return Skin(std::make_shared<const Part>(part), {0, 1});
}

/// A cone with its apex in the origin, open downward along -z, of this slant length.
inline Skin cone_skin(double half_angle, double slant) {
  Frame frame;
  frame.x = Vec3::UnitX();
  frame.y = -Vec3::UnitY();
  frame.z = -Vec3::UnitZ();
  return make_skin(Surface::cone(frame, 0, half_angle), {0, 2 * pi}, {0, slant});
}

}  // namespace afptraj
