// The oracle against closed forms: it judges others, so it is judged first.
#include <gtest/gtest.h>

#include <BRepBuilderAPI_MakeFace.hxx>
#include <GeomConvert.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_ConicalSurface.hxx>
#include <Geom_CylindricalSurface.hxx>
#include <Geom_Plane.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <Geom_SphericalSurface.hxx>
#include <Geom_ToroidalSurface.hxx>
#include <cmath>
#include <gp_Ax3.hxx>

#include "chart_free_geodesic.h"
#include "checks.h"

namespace oracle {
namespace {

constexpr double pi = 3.14159265358979323846;

TopoDS_Face face_of(const Handle(Geom_Surface)& surface, double u0, double u1, double v0, double v1) {
  return BRepBuilderAPI_MakeFace(surface, u0, u1, v0, v1, 1e-7).Face();
}

Handle(Geom_Surface) sphere(double r) { return new Geom_SphericalSurface(gp_Ax3(), r); }
Handle(Geom_Surface) cylinder(double r) { return new Geom_CylindricalSurface(gp_Ax3(), r); }

Handle(Geom_Surface) as_bspline(const Handle(Geom_Surface)& s, double u0, double u1, double v0, double v1) {
  return GeomConvert::SurfaceToBSplineSurface(new Geom_RectangularTrimmedSurface(s, u0, u1, v0, v1));
}

Shot shoot_from(const Skin& skin, const Vec& p, const Vec& direction, double length,
                const ShotOptions& options = {}) {
  const Foot start = skin.nearest(p);
  return shoot(skin, start, skin.jet(start.face, start.u, start.v).normal(), direction.Normalized(), length,
               0, options);
}

// A segment through points given with unit tangents and normals by `at(s)`.
template <class At>
Segment segment_of(int course, double length, int count, At at) {
  Segment segment{course, 0, {}, false};
  for (int i = 0; i <= count; ++i) {
    Sample s = at(length * i / count);
    s.s = length * i / count;
    segment.samples.push_back(s);
  }
  return segment;
}

// The parallel of latitude `lat` on a sphere of radius R over longitudes [0, turn].
Segment parallel_of(int course, double R, double lat, double turn, int count) {
  const double r = R * std::cos(lat);
  return segment_of(course, r * turn, count, [&](double s) {
    const double a = s / r;
    Sample p;
    p.n = Vec(std::cos(lat) * std::cos(a), std::cos(lat) * std::sin(a), std::sin(lat));
    p.x = p.n * R;
    p.t = Vec(-std::sin(a), std::cos(a), 0);
    return p;
  });
}

// A straight line y = `y` of the plane z = 0 over x in [x0, x1].
Segment line_of(int course, double y, double x0, double x1, int count) {
  return segment_of(course, x1 - x0, count, [&](double s) {
    Sample p;
    p.x = Vec(x0 + s, y, 0);
    return p;
  });
}

Skin plate(double width, double height) {
  return Skin({face_of(new Geom_Plane(gp_Ax3()), 0, width, 0, height)});
}

TEST(Geodesic, GreatCircleAndItsJacobiField) {
  const double R = 1000, length = 1500;
  const Skin skin({face_of(sphere(R), 0, 2 * pi, -1.5, 1.5)});
  const Vec p(R, 0, 0), t = Vec(0, std::cos(0.6), std::sin(0.6));
  const Shot shot = shoot_from(skin, p, t, length);
  const Vec exact = p * std::cos(length / R) + t * (R * std::sin(length / R));
  // 1e-8 mm a step, about 20 steps, and a direction error that grows with the way.
  EXPECT_LT((shot.at.point - exact).Modulus(), 1e-6);
  EXPECT_NEAR(shot.y, std::cos(length / R), 1e-9);
  EXPECT_FALSE(shot.left_skin);
}

TEST(Geodesic, FixedStepsAreOfFourthOrder) {
  // A geodesic of the torus that winds: curvature changes along it (on a sphere, symmetric steps do better).
  const Skin skin({face_of(new Geom_ToroidalSurface(gp_Ax3(), 1000, 300), 0, 2 * pi, 0, 2 * pi)});
  const Vec p(1300, 0, 0), t(0, 0.6, 0.8);
  const auto end = [&](double h) { return shoot_from(skin, p, t, 800, {0, h}).at.point; };
  const Vec exact = end(2.5);
  const double coarse = (end(40) - exact).Modulus(), fine = (end(20) - exact).Modulus();
  EXPECT_NEAR(std::log2(coarse / fine), 4, 0.3);

  const Skin ball({face_of(sphere(1000), 0, 2 * pi, -1.5, 1.5)});
  const auto error = [&](double h) {
    const Vec q(1000, 0, 0), d(0, 0.8, 0.6);
    return (shoot_from(ball, q, d, 1000, {0, h}).at.point - (q * std::cos(1.0) + d * (1000 * std::sin(1.0))))
        .Modulus();
  };
  EXPECT_GT(std::log2(error(200) / error(100)), 3.7);
}

TEST(Geodesic, HelixOnACylinderAnalyticAndAsBSpline) {
  const double R = 350, length = 1414.2136;  // reference case R1
  for (const bool spline : {false, true}) {
    const Handle(Geom_Surface) surface = spline ? as_bspline(cylinder(R), 0, 2 * pi, -10, 1100) : cylinder(R);
    double u0, u1, v0, v1;
    surface->Bounds(u0, u1, v0, v1);
    const Skin skin({face_of(surface, u0, u1, spline ? v0 : -10, spline ? v1 : 1100)});
    const Shot shot = shoot_from(skin, Vec(R, 0, 0), Vec(0, 1, 1), length);
    const double z = length / std::sqrt(2.0), a = z / R;
    const double error = (shot.at.point - Vec(R * std::cos(a), R * std::sin(a), z)).Modulus();
    EXPECT_LT(error, 2e-6) << (spline ? "B-spline" : "analytic");  // 100 steps of 1e-8, knots included
    EXPECT_NEAR(a / (2 * pi), 0.454728, 1e-6);
    EXPECT_NEAR(shot.y, 1, 1e-6);
  }
}

TEST(Geodesic, ClairautOnATorus) {
  const Skin skin({face_of(new Geom_ToroidalSurface(gp_Ax3(), 1000, 200), 0, 2 * pi, 0, 2 * pi)});
  const double angle =
      50 * pi / 180;  // from the meridian; above 41.81 degrees it never crosses the hole (R10)
  const Vec p(1200, 0, 0), t(0, std::sin(angle), std::cos(angle));
  for (const double length : {300.0, 900.0, 2000.0}) {
    const Shot shot = shoot_from(skin, p, t, length);
    const Vec& x = shot.at.point;
    const double momentum = x.X() * shot.tangent.Y() - x.Y() * shot.tangent.X();
    EXPECT_NEAR(momentum, 1200 * std::sin(angle), 1e-6);
    EXPECT_GT(std::hypot(x.X(), x.Y()), 1200 * std::sin(angle) - 1e-6);
  }
}

TEST(Geodesic, CrossesFacesAsTheUnrolledLine) {
  // A plate, a quarter cylinder and a plate: developable, so the geodesic is a line of the unrolled strip.
  const double R = 20;
  const gp_Ax3 bend_frame(gp_Pnt(100, 0, R), gp_Dir(0, -1, 0), gp_Dir(0, 0, -1));
  const Skin skin({face_of(new Geom_Plane(gp_Ax3()), 0, 100, -100, 100),
                   face_of(new Geom_CylindricalSurface(bend_frame, R), 0, pi / 2, -100, 100),
                   face_of(new Geom_Plane(gp_Ax3(gp_Pnt(100 + R, 0, R), gp_Dir(1, 0, 0), gp_Dir(0, 0, 1))), 0,
                           100, -100, 100)});
  const double length = 110, angle = 0.5;
  const Shot shot = shoot_from(skin, Vec(50, 0, 0), Vec(std::cos(angle), std::sin(angle), 0), length);
  const double up = length * std::cos(angle) - 50 - R * pi / 2;
  EXPECT_LT((shot.at.point - Vec(100 + R, length * std::sin(angle), R + up)).Modulus(), 1e-5);
  EXPECT_FALSE(shot.left_skin);
}

TEST(Geodesic, TurnsStraightOverACrease) {
  const double dihedral = 0.4;
  const gp_Ax3 tilted(gp_Pnt(100, 0, 0), gp_Dir(-std::sin(dihedral), 0, std::cos(dihedral)),
                      gp_Dir(std::cos(dihedral), 0, std::sin(dihedral)));
  const Skin skin({face_of(new Geom_Plane(gp_Ax3()), 0, 100, -100, 100),
                   face_of(new Geom_Plane(tilted), 0, 100, -100, 100)});
  const double angle = 0.7, length = 120;
  const Shot shot = shoot_from(skin, Vec(60, 0, 0), Vec(std::cos(angle), std::sin(angle), 0), length);
  const double beyond = length * std::cos(angle) - 40;
  const Vec exact(100 + beyond * std::cos(dihedral), length * std::sin(angle), beyond * std::sin(dihedral));
  EXPECT_LT((shot.at.point - exact).Modulus(), 1e-3);  // the edge is met to a thousandth of the way
}

// An apex has no tangent plane: a shot from one, or into one, falls short and is finite. Once it became a NaN
// and ended the program.
TEST(Geodesic, EndsAtAnApex) {
  const double angle = 0.6, radius = 100, slant = radius / std::sin(angle);
  const Handle(Geom_Surface) cone = new Geom_ConicalSurface(gp_Ax3(), angle, radius);
  const Skin skin({face_of(as_bspline(cone, 0, pi, -slant, 0), 0, pi, -slant, 0),
                   face_of(as_bspline(cone, pi, 2 * pi, -slant, 0), pi, 2 * pi, -slant, 0)});
  const Vec apex(0, 0, -radius / std::tan(angle));
  const Shot from = shoot(skin, skin.nearest(apex), Vec(0, 0, -1), Vec(1, 0, 0), slant, 0);
  EXPECT_LT(from.length, slant);
  EXPECT_NEAR((from.at.point - apex).Modulus(), 0, 1e-9);
  const Vec p(radius * std::cos(2), radius * std::sin(2), 0);
  const Shot into = shoot_from(skin, p * 0.5 + apex * 0.5, apex - p, slant);
  EXPECT_TRUE(std::isfinite(into.at.point.SquareModulus() + into.tangent.SquareModulus()));
  EXPECT_TRUE(into.left_skin || into.length < slant / 2 + 1e-3);
}

TEST(Distance, ParallelsOfTheEquator) {
  const double R = 1000;
  const Skin skin({face_of(sphere(R), -0.5, 1.5, -1, 1)});
  PlyPaths ply{"p", {parallel_of(0, R, 0, 1, 110)}};
  check_on_surface(skin, ply);
  for (const double d : {50.8, 101.6, 254.0, 508.0}) {  // reference case R5
    const double a = 0.5;
    const Vec p(R * std::cos(d / R) * std::cos(a), R * std::cos(d / R) * std::sin(a), R * std::sin(d / R));
    const DistanceResult found = geodesic_distance(skin, ply.segments[0], skin.nearest(p), 480);
    ASSERT_EQ(found.kind, DistanceResult::Kind::found);
    EXPECT_NEAR(found.distance, d, 1e-6);
    EXPECT_NEAR(found.s, R * a, 1e-5);
  }
  const Vec beyond(R * std::cos(0.05) * std::cos(1.2), R * std::cos(0.05) * std::sin(1.2),
                   R * std::sin(0.05));
  EXPECT_EQ(geodesic_distance(skin, ply.segments[0], skin.nearest(beyond), 990).kind,
            DistanceResult::Kind::beyond_end);
}

// Coordinates of 1e4 mm and more in a file of nine decimals leave a noise above 1e-9 mm across the shot.
TEST(Distance, IsFoundFromRoundedCoordinates) {
  const double R = 1e4, d = 800;
  const gp_Pnt centre(5e4, 5e4, 0);
  const Skin skin(
      {face_of(new Geom_SphericalSurface(gp_Ax3(centre, gp_Dir(0, 0, 1)), R), -0.5, 1.5, -1, 1.5)});
  const auto rounded = [](const Vec& v) {
    const auto r = [](double x) { return std::round(x * 1e9) / 1e9; };
    return Vec(r(v.X()), r(v.Y()), r(v.Z()));
  };
  const double latitude = 1.2;
  PlyPaths ply{"p", {parallel_of(0, R, latitude, 1, 5000)}};
  for (Sample& s : ply.segments[0].samples)
    s.x = rounded(s.x + Vec(centre.XYZ())), s.t = rounded(s.t), s.n = rounded(s.n);
  check_on_surface(skin, ply);
  for (int i = 1; i < 40; ++i) {
    const double a = i / 40.0, b = latitude + d / R;
    const Vec p =
        Vec(std::cos(b) * std::cos(a), std::cos(b) * std::sin(a), std::sin(b)) * R + Vec(centre.XYZ());
    const double s = a * R * std::cos(latitude);
    const DistanceResult found = geodesic_distance(skin, ply.segments[0], skin.nearest(p), s + 2);
    EXPECT_EQ(found.kind, DistanceResult::Kind::found) << i;
    EXPECT_NEAR(found.distance, d, 1e-6) << i;
  }
}

TEST(Spacing, ExactParallelsPassAndAPlantedErrorIsSeen) {
  const double R = 1000, W = 50.8;
  const Skin skin({face_of(sphere(R), -0.5, 1.5, -1, 1)});
  const auto paths = [&](double off) {
    PlyPaths ply{"p", {}};
    for (int k = -3; k <= 3; ++k)
      ply.segments.push_back(parallel_of(k, R, (k * W + (k >= 2 ? off : 0)) / R, 1, 200));
    check_on_surface(skin, ply);
    return ply;
  };
  const SpacingCheck exact = check_spacing(skin, paths(0), W, 300);
  EXPECT_EQ(exact.courses, 6);
  EXPECT_GT(exact.measured, 250);
  EXPECT_EQ(exact.unresolved, 0);
  EXPECT_LT(exact.error.value, 1e-6);  // Hermite over 5 mm at R 1000: h^4 / (384 R^3) = 2e-9 mm
  EXPECT_NEAR(check_spacing(skin, paths(0.01), W, 300).error.value, 0.01, 1e-6);
  EXPECT_NEAR(check_spacing(skin, paths(20), W, 300).error.value, 20, 1e-6);
}

// Beyond the end of the nearer of two lines, W and more from that end, the line behind has a foot: not the
// nearest point. So it is where the line that ends would be nearer if it went on. An end nearer than W
// excuses nothing.
TEST(Spacing, AFootBehindANearerEndIsNone) {
  const double W = 50;
  const Skin skin = plate(400, 200);
  const auto check = [&](double y, int to) {
    PlyPaths ply{"p", {line_of(0, 10, 0, 400, 80), line_of(0, 20, 0, 100, 20), line_of(1, y, 0, to, to / 5)}};
    check_on_surface(skin, ply);
    return check_spacing(skin, ply, W, 300);
  };
  EXPECT_LT(check(20 + W, 115).error.value, 1e-6);
  EXPECT_EQ(check(20 + W, 115).beyond_end, 3);
  EXPECT_LT(check(20 + W, 150).error.value, 1e-6);
  EXPECT_EQ(check(20 + W, 150).beyond_end, 10);
  EXPECT_NEAR(check(18 + W, 115).error.value, 8, 1e-6);
}

TEST(Surface, SeesAPointOffTheSurfaceAndOneOutside) {
  const Skin skin = plate(100, 100);
  PlyPaths ply{"p", {line_of(0, 50, 0, 100, 20)}};
  EXPECT_LT(check_on_surface(skin, ply).distance.value, 1e-12);
  ply.segments[0].samples[7].x += Vec(0, 0, 1e-5);
  EXPECT_NEAR(check_on_surface(skin, ply).distance.value, 1e-5, 1e-12);
  EXPECT_LT(check_on_surface(skin, ply).arc.value, 1e-9);
  for (std::size_t i = 12; i < 21; ++i) ply.segments[0].samples[i].s += 0.7;  // a jump of s without way
  EXPECT_GT(check_on_surface(skin, ply).arc.value, 0.4);
  PlyPaths wide{"p", {line_of(0, 50, 0, 101, 20)}};
  EXPECT_NEAR(check_on_surface(skin, wide).outside.value, 1, 1e-9);
}

TEST(Ends, OnTheBoundaryShortOfItAndInside) {
  const Skin skin = plate(100, 100);
  const EndCheck good = check_ends(skin, {"p", {line_of(0, 50, 0, 100, 20)}});
  EXPECT_EQ(good.boundary, 2);
  EXPECT_LT(good.error.value, 1e-12);
  EXPECT_NEAR(check_ends(skin, {"p", {line_of(0, 50, 0, 100 - 1e-4, 20)}}).error.value, 1e-4, 1e-10);
  const EndCheck short_of_it = check_ends(skin, {"p", {line_of(0, 50, 0, 90, 20)}});
  EXPECT_EQ(short_of_it.inside, 1);
  EXPECT_NEAR(short_of_it.error.value, 10, 1e-9);
}

TEST(Ends, AnEdgeSharedByTwoFacesIsNotABoundary) {
  const Skin skin({face_of(new Geom_Plane(gp_Ax3()), 0, 100, 0, 100),
                   face_of(new Geom_Plane(gp_Ax3()), 100, 200, 0, 100)});
  const EndCheck ends = check_ends(skin, {"p", {line_of(0, 50, 0, 100, 20), line_of(1, 60, 0, 200, 20)}});
  EXPECT_EQ(ends.shared, 1);
  EXPECT_EQ(ends.boundary, 3);
}

// Edges run into a pole, and what stands on it to 1e-6 mm stands on them too: an end at the pole. Farther
// from it the same edge is one that two faces share.
TEST(Ends, APoleIsNoSharedEdge) {
  const double R = 100, beside_edge = 0.05;
  const Skin skin({face_of(sphere(R), 0, pi / 2, 0, pi / 2), face_of(sphere(R), pi / 2, pi, 0, pi / 2)});
  const auto ends = [&](double from_pole) {
    const double a = pi / 2 - beside_edge, length = R * pi / 2 - from_pole;
    return check_ends(skin, {"p", {segment_of(0, length, 20, [&](double s) {
                               Sample p;
                               p.n = Vec(std::cos(s / R) * std::cos(a), std::cos(s / R) * std::sin(a),
                                         std::sin(s / R));
                               p.x = p.n * R;
                               return p;
                             })}});
  };
  EXPECT_EQ(ends(5e-7).pole, 1);
  EXPECT_EQ(ends(5e-7).shared, 0);
  EXPECT_EQ(ends(1e-5).pole, 0);
  EXPECT_EQ(ends(1e-5).shared, 1);
}

TEST(Crossings, FoundBetweenAndWithinCourses) {
  PlyPaths ply{"p", {line_of(0, 10, 0, 100, 20), line_of(1, 20, 0, 100, 20)}};
  EXPECT_EQ(check_crossings(ply, 10).mutual, 0);
  Segment across = segment_of(2, 50, 7, [](double s) {
    Sample p;
    p.x = Vec(33.3, s, 0);
    p.t = Vec(0, 1, 0);
    return p;
  });
  ply.segments.push_back(across);
  EXPECT_EQ(check_crossings(ply, 10).mutual, 2);
  PlyPaths loop{"p", {segment_of(0, 300, 60, [](double s) {
                  const double a = 2 * pi * s / 300 - 0.3;  // a lemniscate, run over once
                  Sample p;
                  p.x = Vec(50 * std::sin(a), 30 * std::sin(2 * a), 0);
                  return p;
                })}};
  EXPECT_EQ(check_crossings(loop, 10).self, 1);
}

TEST(ClosedCourses, ParallelsRoundABSplineSphereWithSeamAndPoles) {
  const double R = 1000, W = 100;
  const Skin skin({face_of(as_bspline(sphere(R), 0, 2 * pi, -pi / 2, pi / 2), 0, 2 * pi, -pi / 2, pi / 2)});
  PlyPaths ply{"p", {}};
  for (int k = -14; k <= 14; ++k) ply.segments.push_back(parallel_of(k, R, k * W / R, 2 * pi, 500));
  mark_closed(ply);
  const SurfaceCheck surface = check_on_surface(skin, ply);
  EXPECT_LT(surface.distance.value, 1e-9);
  EXPECT_LT(surface.normal.value, 1e-9);
  EXPECT_EQ(check_ends(skin, ply).closed, 29);
  EXPECT_EQ(check_crossings(ply, W).self + check_crossings(ply, W).mutual, 0);
  const SpacingCheck spacing = check_spacing(skin, ply, W, 600);
  EXPECT_GT(spacing.measured, 580);
  EXPECT_EQ(spacing.beyond_end + spacing.unresolved + spacing.off_skin, 0);
  EXPECT_LT(spacing.error.value, 1e-6);
  // The caps beyond 1450 mm of arc from the equator are left.
  EXPECT_NEAR(check_coverage(skin, ply, W, 20000).share(), std::sin(1.45), 2e-3);
}

TEST(Coverage, FullPlateAndAMissingCourse) {
  const double W = 10;
  const Skin skin = plate(200, 100);
  PlyPaths ply{"p", {}};
  for (int k = 0; k < 10; ++k) ply.segments.push_back(line_of(k, 5 + 10 * k, 0, 200, 40));
  check_on_surface(skin, ply);
  EXPECT_EQ(check_coverage(skin, ply, W, 8000).share(), 1);
  ply.segments.erase(ply.segments.begin() + 3);
  const CoverageCheck missing = check_coverage(skin, ply, W, 8000);
  EXPECT_NEAR(missing.share(), 0.9, 0.01);  // one row of samples is 1 / 63
  EXPECT_NEAR(missing.distance.value, 10, 1);
}

TEST(Coverage, GeodesicNotChordDecides) {
  // A cylinder of radius 20, axis z, and a line along it: W/2 = 25 reaches 25 mm of arc, a chord of 23.4.
  const Skin skin({face_of(cylinder(20), 0, pi, 0, 200)});
  PlyPaths ply{"p", {segment_of(0, 200, 40, [](double s) {
                 Sample p;
                 p.x = Vec(0, 20, s);
                 p.n = Vec(0, 1, 0);
                 p.t = Vec(0, 0, 1);
                 return p;
               })}};
  check_on_surface(skin, ply);
  EXPECT_NEAR(check_coverage(skin, ply, 50, 20000).share(), 50 / (20 * pi), 0.01);
}

}  // namespace
}  // namespace oracle
