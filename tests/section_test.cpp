// Sections against closed forms and OpenCASCADE.
#include "geometry/section.h"

#include <gtest/gtest.h>

#include <GCPnts_AbscissaPoint.hxx>
#include <GeomAPI_IntSS.hxx>
#include <GeomAdaptor_Curve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_Plane.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <cmath>
#include <gp_Pln.hxx>
#include <random>

namespace afptraj {
namespace {

Frame tilted_frame() {
  Frame f;
  f.origin = Vec3(10, -20, 5);
  f.x = Vec3(1, 2, 2) / 3;
  f.y = Vec3(2, 1, -2) / 3;
  f.z = Vec3(-2, 2, -1) / 3;
  return f;
}

Vec3 place(const Frame& f, double x, double y, double z) { return f.origin + x * f.x + y * f.y + z * f.z; }
Vec3 turn(const Frame& f, const Vec3& d) { return d.x() * f.x + d.y() * f.y + d.z() * f.z; }

Skin skin_of(Part part) {
  const auto count = static_cast<int>(part.faces.size());
  std::vector<int> faces;
  for (int i = 0; i < count; ++i) faces.push_back(i);
  return Skin(std::make_shared<const Part>(std::move(part)), faces);
}

Skin rectangle(const Surface& surface, const Interval& u, const Interval& v) {
  return skin_of(make_rectangular_part(surface, u, v));
}

double total(const std::vector<SectionCurve>& curves) {
  double sum = 0;
  for (const SectionCurve& c : curves) sum += c.length_mm();
  return sum;
}

/// What holds for any section: samples on the plane and in the material, in order, chords no
/// longer than arcs.
void expect_sound(const Skin& skin, const Plane& plane, const SectionCurve& curve, double step) {
  ASSERT_EQ(curve.points.size(), curve.s_mm.size());
  ASSERT_GT(curve.points.size(), 1u);
  for (std::size_t i = 0; i < curve.points.size(); ++i) {
    const Vec3 p = skin.point(curve.points[i]);
    EXPECT_LE(std::abs(plane.normal.dot(p - plane.origin)), 1e-10);
    // Ends lie on a loop to rounding; a step inward they must be in.
    if (i > 0 && i + 1 < curve.points.size()) {
      EXPECT_TRUE(skin.trim(curve.points[i].face).contains(curve.points[i].uv));
    }
    if (i == 0) continue;
    const double arc = curve.s_mm[i] - curve.s_mm[i - 1];
    const double chord = (p - skin.point(curve.points[i - 1])).norm();
    EXPECT_GE(arc, chord - 1e-9);
    // Steps turn by 0.3 rad at most: arc / chord <= 0.15 / sin 0.15, with room for growing curvature.
    EXPECT_LE(arc, 1.05 * chord + 1e-9);
    EXPECT_LE(chord, step + 1e-9);
  }
  if (curve.closed) {
    EXPECT_LE((skin.point(curve.points.front()) - skin.point(curve.points.back())).norm(), 2e-6);
  }
}

double ellipse_perimeter(double a, double b) {
  return 4 * a * std::comp_ellint_2(std::sqrt(1 - b * b / (a * a)));
}

// The tolerance asked for is 5e-7 mm per metre of length.
double allowed(double length) { return 5e-10 * length + 1e-9; }

TEST(Section, PlaneGivesASegment) {
  const Frame f = tilted_frame();
  const Skin skin = rectangle(Surface::plane(f), {-30, 70}, {0, 50});
  const Plane plane{place(f, 0, 10, 0), turn(f, Vec3(-3, 4, 5)).normalized()};
  const auto curves = section(skin, plane);
  ASSERT_EQ(curves.size(), 1u);
  expect_sound(skin, plane, curves[0], 5);
  // The line -3 x + 4 (y - 10) = 0 between y = 0 (x = -13.333) and y = 50 (x = 53.333).
  EXPECT_NEAR(curves[0].length_mm(), std::hypot(50, 200.0 / 3), allowed(100));
  EXPECT_FALSE(curves[0].closed);
}

TEST(Section, CylinderGivesAnEllipseThroughTheSeam) {
  const Frame f = tilted_frame();
  const Skin skin = rectangle(Surface::cylinder(f, 50), {0, 2 * pi}, {-200, 200});
  for (const double angle : {0.0, 0.3, 1.0}) {
    const Plane plane{f.origin, turn(f, Vec3(std::sin(angle) * 0.6, std::sin(angle) * 0.8, std::cos(angle)))};
    const auto curves = section(skin, plane);
    ASSERT_EQ(curves.size(), 1u) << angle;
    expect_sound(skin, plane, curves[0], 5);
    EXPECT_TRUE(curves[0].closed);
    const double perimeter = ellipse_perimeter(50 / std::cos(angle), 50);
    EXPECT_NEAR(curves[0].length_mm(), perimeter, allowed(perimeter));
  }
}

TEST(Section, ConeGivesAnEllipse) {
  const double alpha = 0.35, R = 60, beta = 0.5;
  const Skin skin = rectangle(Surface::cone(Frame{}, R, alpha), {0, 2 * pi}, {-R / std::sin(alpha), 150});
  const Plane plane{Vec3(0, 0, 10), Vec3(std::sin(beta), 0, std::cos(beta))};
  const auto curves = section(skin, plane);
  ASSERT_EQ(curves.size(), 1u);
  expect_sound(skin, plane, curves[0], 5);
  EXPECT_TRUE(curves[0].closed);
  // In the plane y = 0 the generatrices x = +-(R + z tan a) meet z = 10 - x tan b at the ends of the
  // major axis; the minor half axis follows from the circle at the ellipse's centre.
  const double ta = std::tan(alpha), tb = std::tan(beta);
  const double x1 = (R + 10 * ta) / (1 + tb * ta), x2 = -(R + 10 * ta) / (1 - tb * ta);
  const double a = 0.5 * (x1 - x2) / std::cos(beta), xc = 0.5 * (x1 + x2);
  const double b = std::sqrt(std::pow(R + (10 - xc * tb) * ta, 2) - xc * xc);
  EXPECT_NEAR(curves[0].length_mm(), ellipse_perimeter(a, b), allowed(ellipse_perimeter(a, b)));
}

TEST(Section, SphereGivesCirclesWithAndWithoutSeamAndPoles) {
  const Frame f = tilted_frame();
  const Skin skin = rectangle(Surface::sphere(f, 80), {0, 2 * pi}, {-pi / 2, pi / 2});
  struct Case {
    Vec3 normal;
    double height;
    bool closed;
  };
  for (const Case& c : {Case{Vec3(-1, 0.2, 0.1), 60, true}, Case{Vec3(1, 0.1, 0), 70, true},
                        Case{Vec3(0, 0, 1), -35, true}, Case{Vec3(0.1, 0.2, 1), 10, true},
                        Case{Vec3(1, 2, 0.3), 0, true}, Case{Vec3(-1, 0.2, 0.1), 79.99, true}}) {
    const Vec3 n = turn(f, c.normal.normalized());
    const Plane plane{f.origin + c.height * n, n};
    const auto curves = section(skin, plane);
    ASSERT_EQ(curves.size(), 1u) << c.normal.transpose();
    expect_sound(skin, plane, curves[0], 5);
    EXPECT_EQ(curves[0].closed, c.closed);
    const double perimeter = 2 * pi * std::sqrt(80 * 80 - c.height * c.height);
    EXPECT_NEAR(curves[0].length_mm(), perimeter, allowed(perimeter));
  }
  // Through both poles: two half circles end there.
  const Plane meridian{f.origin, turn(f, Vec3(0.6, 0.8, 0))};
  const auto halves = section(skin, meridian);
  EXPECT_EQ(halves.size(), 2u);
  EXPECT_NEAR(total(halves), 2 * pi * 80, allowed(500));
}

TEST(Section, TorusGivesItsCircles) {
  const Skin skin = rectangle(Surface::torus(Frame{}, 60, 20), {0, 2 * pi}, {0, 2 * pi});
  // The equator plane is the seam v = 0 itself, so a little above: circles R +- r cos v.
  const double z = 6, half = std::sqrt(20 * 20 - z * z);
  EXPECT_NEAR(total(section(skin, {Vec3(0, 0, z), Vec3::UnitZ()})), 2 * pi * 120, allowed(760));
  EXPECT_EQ(section(skin, {Vec3(0, 0, z), Vec3::UnitZ()}).size(), 2u);
  EXPECT_GT(half, 0);
  const auto across = section(skin, {Vec3::Zero(), Vec3(0.6, 0.8, 0)});
  EXPECT_EQ(across.size(), 2u);
  EXPECT_NEAR(total(across), 2 * 2 * pi * 20, allowed(260));
  // Villarceau circles of radius R; they meet in two points, where the plane touches the torus.
  const double tilt = std::asin(20.0 / 60);
  const auto near_villarceau = section(skin, {Vec3(0, 0, 1e-6), Vec3(0, -std::sin(tilt), std::cos(tilt))});
  // 1e-6 beside it the four corners are cut at about sqrt(2e-6 x 60) = 0.01 mm.
  EXPECT_NEAR(total(near_villarceau), 2 * 2 * pi * 60, 0.1);
  // A closed branch inside the face, away from both seams.
  const Skin patch = rectangle(Surface::torus(Frame{}, 60, 20), {0.5, 2.6}, {0.2, 2.9});
  const Plane cap{Vec3(0, 75, 0), Vec3(0.05, 0.9, 0.44).normalized()};
  for (const SectionCurve& c : section(patch, cap)) expect_sound(patch, cap, c, 5);
}

/// z = (x^2 + y^2) / 100 over [-50, 50]^2, exactly, as one biquadratic.
Surface paraboloid() {
  BSplineSurface s;
  s.degree_u = s.degree_v = 2;
  s.knots_u = s.knots_v = {0, 0, 0, 1, 1, 1};
  const double square[3] = {2500, -2500, 2500};  // blossom of x^2
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      s.poles.emplace_back(50 * (i - 1), 50 * (j - 1), (square[i] + square[j]) / 100);
  }
  return Surface::bspline(s);
}

TEST(Section, ClosedBranchesInsideAFace) {
  const Skin skin = rectangle(paraboloid(), {0, 1}, {0, 1});
  for (const double radius : {49.0, 20.0, 1.0, 0.01}) {
    const Plane plane{Vec3(0, 0, radius * radius / 100), Vec3::UnitZ()};
    const auto curves = section(skin, plane);
    ASSERT_EQ(curves.size(), 1u) << radius;
    EXPECT_TRUE(curves[0].closed);
    expect_sound(skin, plane, curves[0], 5);
    // Heights round to 5e-14 (coordinates of 50), the radius to that over the slope r / 50.
    const double rounding = 2 * pi * 5e-14 / (radius / 50);
    EXPECT_NEAR(curves[0].length_mm(), 2 * pi * radius, allowed(2 * pi * radius) + 2 * rounding);
  }
  // Beyond the inscribed circle four arcs remain: 8 (pi/4 - acos(50/r)) r.
  const double radius = 60;
  const auto arcs = section(skin, {Vec3(0, 0, 36), Vec3::UnitZ()});
  EXPECT_EQ(arcs.size(), 4u);
  EXPECT_NEAR(total(arcs), 8 * (pi / 4 - std::acos(50 / radius)) * radius, allowed(400));
}

// Sections of paraboloids of revolution by oblique planes are ellipses: the loop law at other angles.
TEST(Section, TheArcLengthConvergesWithTheFourthOrderAtLeast) {
  const Frame f;
  const Skin skin = rectangle(Surface::cylinder(f, 50), {0, 2 * pi}, {-200, 200});
  const Plane plane{f.origin, Vec3(0.6, 0, 0.8)};
  const double perimeter = ellipse_perimeter(50 / 0.8, 50);
  SectionOptions options;
  options.tolerance_mm = 1e9;  // no control of the error: the rule alone
  double last = 0;
  for (const double step : {12.0, 6.0, 3.0}) {
    options.step_mm = step;
    const double error = std::abs(total(section(skin, plane, options)) - perimeter);
    if (last > 0) {
      EXPECT_GE(std::log2(last / error), 4) << last << " " << error;
    }
    last = error;
  }
}

/// A floor and a wall that meet in the line x = 100; the wall's pcurve runs the other way round.
Part folded_sheet() {
  Frame wall;
  wall.origin = Vec3(100, 0, 0);
  wall.x = Vec3::UnitZ();
  wall.y = Vec3::UnitY();
  wall.z = Vec3::UnitZ().cross(Vec3::UnitY());
  RectangularFace a = make_rectangular_face(Surface::plane(Frame{}), {0, 100}, {0, 60}, 0);
  RectangularFace b = make_rectangular_face(Surface::plane(wall), {0, 40}, {0, 60}, 4);
  Part part;
  part.faces = {a.face, b.face};
  part.edges = a.edges;
  part.edges.insert(part.edges.end(), b.edges.begin(), b.edges.end());
  // u = 0 of the wall is u = 100 of the floor, with the same parameter v.
  part.faces[1].loops[0].coedges[3].edge = part.faces[0].loops[0].coedges[1].edge;
  return part;
}

TEST(Section, CrossesSharedEdges) {
  const Skin skin = skin_of(folded_sheet());
  const Plane plane{Vec3(0, 20, 0), Vec3(-0.1, 1, 0.2).normalized()};
  const auto curves = section(skin, plane);
  ASSERT_EQ(curves.size(), 1u);
  expect_sound(skin, plane, curves[0], 5);
  // y = 20 + 0.1 x on the floor, y = 30 - 0.2 z on the wall.
  EXPECT_NEAR(curves[0].length_mm(), std::hypot(100, 10) + std::hypot(40, 8), allowed(150));
  // From the floor toward +x, over the edge and up; and from the edge itself, both ways.
  const SectionCurve up = trace_section(skin, plane, {0, Uv(50, 25)}, Vec3::UnitX());
  EXPECT_NEAR(up.length_mm(), std::hypot(50, 5) + std::hypot(40, 8), allowed(150));
  EXPECT_EQ(up.points.back().face, 1);
  EXPECT_NEAR(up.points.back().uv.x(), 40, 1e-9);
  const SectionCurve down = trace_section(skin, plane, {0, Uv(100, 30)}, -Vec3::UnitX());
  EXPECT_NEAR(down.length_mm(), std::hypot(100, 10), allowed(150));
  const SectionCurve over = trace_section(skin, plane, {0, Uv(100, 30)}, Vec3::UnitX());
  EXPECT_NEAR(over.length_mm(), std::hypot(40, 8), allowed(150));
}

TEST(Section, BothHalvesMakeTheWhole) {
  const Frame f = tilted_frame();
  const Skin skin = rectangle(Surface::torus(f, 100, 30), {0.3, 2.5}, {-1.2, 1.4});
  const SurfacePoint start{0, Uv(1.2, 0.3)};
  const Plane plane{skin.point(start), turn(f, Vec3(0.8, 0.5, 0.1).normalized())};
  const SectionCurve a = trace_section(skin, plane, start, f.z);
  const SectionCurve b = trace_section(skin, plane, start, -f.z);
  EXPECT_FALSE(a.closed);
  EXPECT_GT(a.length_mm(), 1);
  EXPECT_GT(b.length_mm(), 1);
  double nearest = 1e9;
  for (const SectionCurve& c : section(skin, plane)) {
    nearest = std::min(nearest, std::abs(c.length_mm() - a.length_mm() - b.length_mm()));
  }
  EXPECT_LE(nearest, allowed(300));
}

TEST(Section, HolesCutTheSectionInTwo) {
  Part part = make_rectangular_part(Surface::plane(Frame{}), {0, 100}, {0, 100});
  Loop hole;
  const std::vector<Uv> corners = {Uv(40, 40), Uv(40, 60), Uv(60, 60), Uv(60, 40)};
  for (std::size_t i = 0; i < 4; ++i) {
    hole.coedges.push_back(
        {line_segment(corners[i], corners[(i + 1) % 4]), false, static_cast<int>(part.edges.size())});
    part.edges.push_back(Edge{});
  }
  part.faces[0].loops.push_back(hole);
  const Skin skin = skin_of(std::move(part));
  const Plane plane{Vec3(0, 50, 0), Vec3(0, 1, 0)};
  const auto curves = section(skin, plane);
  ASSERT_EQ(curves.size(), 2u);
  EXPECT_NEAR(curves[0].length_mm(), 40, 1e-9);
  EXPECT_NEAR(curves[1].length_mm(), 40, 1e-9);
}

// ---- OpenCASCADE as the oracle ----

BSplineSurface bumpy(unsigned seed, int count, double height) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> z(-height, height);
  BSplineSurface s;
  s.degree_u = s.degree_v = 3;
  s.knots_u.assign(4, 0.0);
  for (int i = 1; i < count - 3; ++i) s.knots_u.push_back(static_cast<double>(i) / (count - 3));
  s.knots_u.insert(s.knots_u.end(), 4, 1.0);
  s.knots_v = s.knots_u;
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < count; ++j)
      s.poles.emplace_back(1000.0 * i / (count - 1), 600.0 * j / (count - 1), z(random));
  }
  return s;
}

opencascade::handle<Geom_BSplineSurface> occt_surface(const BSplineSurface& s) {
  const int n = s.count_u();
  TColgp_Array2OfPnt poles(1, n, 1, n);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const Vec3& p = s.poles[static_cast<std::size_t>(i * n + j)];
      poles.SetValue(i + 1, j + 1, gp_Pnt(p.x(), p.y(), p.z()));
    }
  }
  const int spans = n - 3;
  TColStd_Array1OfReal knots(1, spans + 1);
  TColStd_Array1OfInteger multiplicities(1, spans + 1);
  for (int i = 0; i <= spans; ++i) {
    knots.SetValue(i + 1, static_cast<double>(i) / spans);
    multiplicities.SetValue(i + 1, i == 0 || i == spans ? 4 : 1);
  }
  return new Geom_BSplineSurface(poles, knots, knots, multiplicities, multiplicities, 3, 3);
}

TEST(Section, LengthsAgreeWithOpenCascade) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const BSplineSurface spline = bumpy(seed, 8 + static_cast<int>(seed), 25);
    const Skin skin = rectangle(Surface::bspline(spline), {0, 1}, {0, 1});
    const Plane plane{Vec3(470, 310, 0), Vec3(0.5, 0.2 * seed, seed % 2 == 0 ? 0.05 : 0).normalized()};
    const opencascade::handle<Geom_Plane> cut =
        new Geom_Plane(gp_Pln(gp_Pnt(plane.origin.x(), plane.origin.y(), plane.origin.z()),
                              gp_Dir(plane.normal.x(), plane.normal.y(), plane.normal.z())));
    GeomAPI_IntSS intersection(occt_surface(spline), cut, 1e-7);
    ASSERT_TRUE(intersection.IsDone());
    double oracle = 0;
    for (int i = 1; i <= intersection.NbLines(); ++i) {
      GeomAdaptor_Curve line(intersection.Line(i));
      oracle += GCPnts_AbscissaPoint::Length(line, 1e-10);
    }
    const auto curves = section(skin, plane);
    for (const SectionCurve& c : curves) expect_sound(skin, plane, c, 5);
    // OpenCASCADE approximates its line within 1e-7 of the surface and the arc length of that.
    EXPECT_NEAR(total(curves), oracle, 1e-6 * oracle) << seed;
    // Our own length with much finer steps: what the tolerance promises.
    SectionOptions fine;
    fine.step_mm = 0.5;
    fine.tolerance_mm = 1e-9;
    EXPECT_NEAR(total(curves), total(section(skin, plane, fine)), allowed(oracle)) << seed;
  }
}

// Contour lines of a bumpy sheet: many closed branches and branches between edges.
TEST(Section, ContoursOfABumpySheet) {
  for (unsigned seed = 11; seed <= 14; ++seed) {
    const BSplineSurface spline = bumpy(seed, 12, 60);
    const Skin skin = rectangle(Surface::bspline(spline), {0, 1}, {0, 1});
    for (const double z : {-20.0, 0.5, 15.0}) {
      const Plane plane{Vec3(0, 0, z), Vec3::UnitZ()};
      const auto curves = section(skin, plane);
      double ours = total(curves);
      for (const SectionCurve& c : curves) expect_sound(skin, plane, c, 5);
      // Marching squares on a fine grid sees every branch longer than its cells; its length is off
      // by the square of the cell over the radius: about 1e-4 here.
      constexpr int n = 1500;
      std::vector<double> height(static_cast<std::size_t>((n + 1) * (n + 1)));
      std::vector<Vec3> at(height.size());
      for (int i = 0; i <= n; ++i) {
        for (int j = 0; j <= n; ++j) {
          const auto k = static_cast<std::size_t>(i * (n + 1) + j);
          at[k] = skin.face(0).surface.point(Uv(static_cast<double>(i) / n, static_cast<double>(j) / n));
          height[k] = at[k].z() - z;
        }
      }
      double squares = 0;
      const auto triangle = [&](std::size_t a, std::size_t b, std::size_t c) {
        std::vector<Vec3> ends;
        const std::size_t corner[4] = {a, b, c, a};
        for (int e = 0; e < 3; ++e) {
          const std::size_t x = corner[e], y = corner[e + 1];
          if ((height[x] < 0) == (height[y] < 0)) continue;
          ends.emplace_back(at[x] + height[x] / (height[x] - height[y]) * (at[y] - at[x]));
        }
        if (ends.size() == 2) squares += (ends[1] - ends[0]).norm();
      };
      for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
          const auto k = static_cast<std::size_t>(i * (n + 1) + j);
          triangle(k, k + 1, k + n + 2);
          triangle(k, k + n + 1, k + n + 2);
        }
      }
      EXPECT_NEAR(ours, squares, 3e-4 * squares + 1) << seed << " " << z;
    }
  }
}

TEST(Section, RefusesSenselessOptions) {
  const Skin skin = rectangle(Surface::plane(Frame{}), {0, 1}, {0, 1});
  SectionOptions options;
  options.step_mm = 0;
  EXPECT_THROW(section(skin, {Vec3::Zero(), Vec3::UnitX()}, options), std::invalid_argument);
}

}  // namespace
}  // namespace afptraj
