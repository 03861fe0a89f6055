#include "sample_surfaces.h"

#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepLib.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Geom2d_Circle.hxx>
#include <Geom2d_Line.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColStd_Array2OfReal.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TopExp.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Wire.hxx>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace samples {
namespace {

constexpr double pi = 3.14159265358979323846;
constexpr int degree = 3;

struct UniformKnots {
  TColStd_Array1OfReal knots;
  TColStd_Array1OfInteger multiplicities;

  UniformKnots(int poles, double length)
      : knots(1, poles - degree + 1), multiplicities(1, poles - degree + 1) {
    const int spans = poles - degree;
    for (int i = 0; i <= spans; ++i) {
      knots.SetValue(i + 1, length * i / spans);
      multiplicities.SetValue(i + 1, i == 0 || i == spans ? degree + 1 : 1);
    }
  }
};

// The mean of the `degree` knots that belong to pole i: with poles at these places u is reproduced.
double greville(int i, int poles, double length) {
  const int spans = poles - degree;
  double sum = 0;
  for (int k = 1; k <= degree; ++k) sum += std::clamp(i + k - degree, 0, spans);
  return length * sum / (degree * spans);
}

Handle(Geom_BSplineSurface) height_field(int count_u, int count_v, double length_u, double length_v,
                                         const std::function<double(double, double)>& height) {
  return bicubic(count_u, count_v, length_u, length_v,
                 [&](double x, double y) { return gp_Pnt(x, y, height(x, y)); });
}

// Half thickness of the NACA four-digit section of relative thickness 0.12, closed at the trailing edge.
double half_thickness(double x) {
  return 0.6 *
         (0.2969 * std::sqrt(x) - 0.1260 * x - 0.3516 * x * x + 0.2843 * x * x * x - 0.1036 * x * x * x * x);
}

double camber(double x) { return 0.02 * (1 - (2 * x - 1) * (2 * x - 1)); }

// A point of the section for w in [-1, 1]: -1 near the trailing edge below, 0 the leading edge, 1
// near the trailing edge above. x = w^2 makes the leading edge smooth in w.
gp_Pnt section_point(double w) {
  const double x = 0.97 * w * w;
  return gp_Pnt(x, 0, camber(x) + (w < 0 ? -1 : 1) * half_thickness(x));
}

TopoDS_Edge edge_on(const Handle(Geom_Surface)& surface, const Handle(Geom2d_Curve)& curve, double first,
                    double last) {
  TopoDS_Edge edge = BRepBuilderAPI_MakeEdge(curve, surface, first, last);
  BRepLib::BuildCurve3d(edge, 1e-7);
  return edge;
}

TopoDS_Edge edge_between(const Handle(Geom_Surface)& surface, const Handle(Geom2d_Curve)& curve, double first,
                         double last, const TopoDS_Vertex& from, const TopoDS_Vertex& to) {
  TopoDS_Edge edge = BRepBuilderAPI_MakeEdge(curve, surface, from, to, first, last);
  BRepLib::BuildCurve3d(edge, 1e-7);
  return edge;
}

TopoDS_Vertex vertex_at(const Handle(Geom_Surface)& surface, double u, double v) {
  TopoDS_Vertex vertex;
  BRep_Builder().MakeVertex(vertex, surface->Value(u, v), 1e-7);
  return vertex;
}

TopoDS_Wire circle_wire(const Handle(Geom_Surface)& surface, const Obround& hole) {
  const gp_Ax22d axes(gp_Pnt2d(hole.u0, hole.v0), gp_Dir2d(1, 0));
  const TopoDS_Edge edge = edge_on(surface, new Geom2d_Circle(axes, hole.r), 0, 2 * pi);
  return BRepBuilderAPI_MakeWire(edge);
}

TopoDS_Wire obround_wire(const Handle(Geom_Surface)& surface, const Obround& hole) {
  const gp_Vec2d along(hole.u1 - hole.u0, hole.v1 - hole.v0);
  const double length = along.Magnitude();
  if (length == 0) return circle_wire(surface, hole);
  const gp_Vec2d t = along / length, left(-t.Y(), t.X());
  const gp_Pnt2d a(hole.u0, hole.v0), b(hole.u1, hole.v1);
  const gp_Pnt2d corner[4] = {a.Translated(-hole.r * left), b.Translated(-hole.r * left),
                              b.Translated(hole.r * left), a.Translated(hole.r * left)};
  TopoDS_Vertex vertex[4];
  for (int i = 0; i < 4; ++i) vertex[i] = vertex_at(surface, corner[i].X(), corner[i].Y());
  const gp_Dir2d down(-left);
  BRepBuilderAPI_MakeWire wire;
  wire.Add(edge_between(surface, new Geom2d_Line(corner[0], gp_Dir2d(t)), 0, length, vertex[0], vertex[1]));
  wire.Add(edge_between(surface, new Geom2d_Circle(gp_Ax22d(b, down), hole.r), 0, pi, vertex[1], vertex[2]));
  wire.Add(edge_between(surface, new Geom2d_Line(corner[2], gp_Dir2d(-t)), 0, length, vertex[2], vertex[3]));
  wire.Add(edge_between(surface, new Geom2d_Circle(gp_Ax22d(a, gp_Dir2d(left)), hole.r), 0, pi, vertex[3],
                        vertex[0]));
  return wire.Wire();
}

}  // namespace

Handle(Geom_BSplineSurface) bicubic(int count_u, int count_v, double length_u, double length_v,
                                    const std::function<gp_Pnt(double, double)>& pole) {
  TColgp_Array2OfPnt poles(1, count_u, 1, count_v);
  for (int i = 0; i < count_u; ++i)
    for (int j = 0; j < count_v; ++j)
      poles.SetValue(i + 1, j + 1, pole(greville(i, count_u, length_u), greville(j, count_v, length_v)));
  const UniformKnots u(count_u, length_u), v(count_v, length_v);
  return new Geom_BSplineSurface(poles, u.knots, v.knots, u.multiplicities, v.multiplicities, degree, degree);
}

TopoDS_Shape whole_face(const Handle(Geom_Surface)& surface) {
  BRepBuilderAPI_MakeFace maker(surface, 1e-7);
  if (!maker.IsDone()) throw std::runtime_error("no face over the surface");
  return maker.Face();
}

TopoDS_Shape face_with_holes(const Handle(Geom_Surface)& surface, const std::vector<Obround>& holes) {
  BRepBuilderAPI_MakeFace maker(surface, 1e-7);
  for (const Obround& hole : holes) maker.Add(TopoDS::Wire(obround_wire(surface, hole).Reversed()));
  if (!maker.IsDone()) throw std::runtime_error("no face with holes");
  TopoDS_Shape face = maker.Face();
  BRepLib::SameParameter(face, 1e-7, true);
  return face;
}

TopoDS_Shape split_and_sewn(const Handle(Geom_BSplineSurface)& surface, const std::vector<double>& u,
                            const std::vector<double>& v) {
  BRepBuilderAPI_Sewing sewing(1e-6);
  for (std::size_t i = 0; i + 1 < u.size(); ++i) {
    for (std::size_t j = 0; j + 1 < v.size(); ++j) {
      Handle(Geom_BSplineSurface) piece = Handle(Geom_BSplineSurface)::DownCast(surface->Copy());
      piece->Segment(u[i], u[i + 1], v[j], v[j + 1]);
      sewing.Add(whole_face(piece));
    }
  }
  sewing.Perform();
  return sewing.SewedShape();
}

Handle(Geom_BSplineSurface) panel_surface() {
  return height_field(20, 20, 1000, 600, [](double x, double y) {
    const double a = x / 1000 - 0.5, b = y / 600 - 0.5;
    return 70 * std::cos(2.4 * a) * std::cos(1.8 * b) + 14 * std::sin(2 * pi * a) * b - 40 * a * b;
  });
}

Handle(Geom_BSplineSurface) wing_surface() {
  // u: around the section over [0, 2], the leading edge at 1; v: along the half span, 2000 mm.
  return bicubic(26, 11, 2, 2000, [](double u, double y) {
    const double eta = y / 2000, chord = 600 - 240 * eta, twist = -3 * pi / 180 * eta;
    const gp_Pnt p = section_point(u - 1);
    const double x = chord * (p.X() - 0.25), z = chord * p.Z();
    return gp_Pnt(150 + 180 * eta + x * std::cos(twist) + z * std::sin(twist), y,
                  60 * eta * eta - x * std::sin(twist) + z * std::cos(twist));
  });
}

Handle(Geom_BSplineSurface) hole_surface() {
  return height_field(14, 10, 800, 500, [](double x, double y) {
    const double a = x / 800 - 0.5, b = y / 500 - 0.5;
    return 90 - 160 * a * a - 60 * b * b + 20 * a * b;
  });
}

// A full circle times an arc of a conic (r, z) with the weight of its middle pole: rational quadratics both.
Handle(Geom_BSplineSurface) revolved(const double (&profile)[3][2], double weight) {
  const double h = std::sqrt(0.5);
  const int ring[9][2] = {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}, {1, 0}};
  TColgp_Array2OfPnt poles(1, 9, 1, 3);
  TColStd_Array2OfReal weights(1, 9, 1, 3);
  for (int i = 0; i < 9; ++i) {
    for (int j = 0; j < 3; ++j) {
      const double r = profile[j][0];
      poles.SetValue(i + 1, j + 1, gp_Pnt(r * ring[i][0], r * ring[i][1], profile[j][1]));
      weights.SetValue(i + 1, j + 1, (i % 2 == 1 ? h : 1) * (j == 1 ? weight : 1));
    }
  }
  TColStd_Array1OfReal u(1, 5), v(1, 2);
  TColStd_Array1OfInteger mult_u(1, 5), mult_v(1, 2);
  for (int i = 0; i < 5; ++i) {
    u.SetValue(i + 1, i);
    mult_u.SetValue(i + 1, i == 0 || i == 4 ? 3 : 2);
  }
  for (int j = 0; j < 2; ++j) {
    v.SetValue(j + 1, j);
    mult_v.SetValue(j + 1, 3);
  }
  return new Geom_BSplineSurface(poles, weights, u, v, mult_u, mult_v, 2, 2);
}

Handle(Geom_BSplineSurface) dome_surface() {
  // A half ellipsoid of radius 400 mm and height 320 mm, exactly.
  const double radius = 400, height = 320;
  return revolved({{radius, 0}, {radius, height}, {0, height}}, std::sqrt(0.5));
}

TopoDS_Shape vessel_shell() {
  const double radius = 150, height = 105, opening = 30, length = 300;
  // The ellipse's arc by its eccentric angle a from the cylinder: (R cos a, h sin a); the middle pole is
  // where the tangents at its ends meet.
  const double half = std::acos(opening / radius) / 2, weight = std::cos(half);
  const double middle_r = radius, middle_z = height * std::tan(half), end_z = height * std::sin(2 * half);
  BRepBuilderAPI_Sewing sewing(1e-6);
  sewing.Add(whole_face(revolved({{opening, -end_z}, {middle_r, -middle_z}, {radius, 0}}, weight)));
  sewing.Add(whole_face(revolved({{radius, 0}, {radius, length / 2}, {radius, length}}, 1)));
  sewing.Add(whole_face(
      revolved({{radius, length}, {middle_r, length + middle_z}, {opening, length + end_z}}, weight)));
  sewing.Perform();
  return sewing.SewedShape();
}

Handle(Geom_BSplineSurface) duct_surface() {
  // Closed in u (16 poles, periodic), 1200 mm along v on a slightly bent axis.
  const int around = 16, along = 12;
  TColgp_Array2OfPnt poles(1, around, 1, along);
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < along; ++j) {
      const double x = greville(j, along, 1200), angle = 2 * pi * i / around;
      const double r = 230 + 25 * std::cos(2 * pi * x / 1200);
      const double flat = 1 + 0.06 * std::sin(pi * x / 1200);
      poles.SetValue(
          i + 1, j + 1,
          gp_Pnt(x, r * flat * std::cos(angle), r / flat * std::sin(angle) + 40 * (x / 1200) * (x / 1200)));
    }
  }
  TColStd_Array1OfReal u(1, around + 1);
  TColStd_Array1OfInteger mult_u(1, around + 1);
  for (int i = 0; i <= around; ++i) {
    u.SetValue(i + 1, i);
    mult_u.SetValue(i + 1, 1);
  }
  const UniformKnots v(along, 1200);
  return new Geom_BSplineSurface(poles, u, v.knots, mult_u, v.multiplicities, degree, degree, true, false);
}

Handle(Geom_BSplineSurface) saddle_surface() {
  return height_field(10, 10, 700, 700, [](double x, double y) {
    const double a = x - 350, b = y - 350;
    return (a * a - b * b) / 1800 + a * b / 4000;
  });
}

}  // namespace samples
