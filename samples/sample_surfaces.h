#pragma once

#include <Geom_BSplineSurface.hxx>
#include <TopoDS_Shape.hxx>
#include <functional>
#include <gp_Pnt.hxx>
#include <vector>

namespace samples {

/// Poles of a clamped, uniform, bicubic B-spline over [0, length_u] x [0, length_v]:
/// `pole(a, b)` for the Greville abscissae (a, b), so that a height field z(x, y) becomes a surface with
/// x = u and y = v exactly.
Handle(Geom_BSplineSurface) bicubic(int count_u, int count_v, double length_u, double length_v,
                                    const std::function<gp_Pnt(double, double)>& pole);

/// The face over the whole surface; a closed direction gets a seam, a side that is a point a
/// degenerate edge.
TopoDS_Shape whole_face(const Handle(Geom_Surface)& surface);

/// A closed chain of straight lines and arcs in (u, v), run anticlockwise: an obround of radius `r`
/// around the segment (u0, v0)-(u1, v1); a circle when both ends agree.
struct Obround {
  double u0, v0, u1, v1, r;
};

/// The face over the whole surface with the obrounds cut out.
TopoDS_Shape face_with_holes(const Handle(Geom_Surface)& surface, const std::vector<Obround>& holes);

/// Pieces of the surface between consecutive `u` and `v`, each on a surface of its own, sewn to a
/// shell.
TopoDS_Shape split_and_sewn(const Handle(Geom_BSplineSurface)& surface, const std::vector<double>& u,
                            const std::vector<double>& v);

Handle(Geom_BSplineSurface) panel_surface();
Handle(Geom_BSplineSurface) wing_surface();
Handle(Geom_BSplineSurface) hole_surface();
Handle(Geom_BSplineSurface) dome_surface();
/// A vessel along z: radius 150 mm, cylinder 300 mm long, domes of half an ellipsoid of 105 mm that end at
/// openings of radius 30 mm, as three faces sewn to a shell.
TopoDS_Shape vessel_shell();
Handle(Geom_BSplineSurface) duct_surface();
Handle(Geom_BSplineSurface) saddle_surface();

}  // namespace samples
