// The same part said in another way gives the same courses.
#include <gtest/gtest.h>

#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_NurbsConvert.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_ConicalSurface.hxx>
#include <Geom_CylindricalSurface.hxx>
#include <Geom_SphericalSurface.hxx>
#include <Geom_ToroidalSurface.hxx>
#include <STEPControl_Writer.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <cmath>
#include <functional>

#include "boundary/plan_ply.h"
#include "io/step/read_step.h"
#include "tests/parallel_curves.h"
#include "tests/specimens.h"
#include "tests/step_oracle.h"
#include "tests/temporary_directory.h"

namespace afptraj {
namespace {

using test::distance_to;
using test::exact_options;
using test::for_each_midpoint;
using test::on_skin;
using test::uv_line;
using test::W;

// --- surfaces ---

Handle(Geom_BSplineSurface) to_occt(const BSplineSurface& s) {
  const auto split = [](const std::vector<double>& flat) {
    std::vector<std::pair<double, int>> knots;
    for (const double k : flat)
      if (knots.empty() || k > knots.back().first)
        knots.emplace_back(k, 1);
      else
        ++knots.back().second;
    return knots;
  };
  const auto u = split(s.knots_u), v = split(s.knots_v);
  const auto arrays = [](const std::vector<std::pair<double, int>>& knots, TColStd_Array1OfReal& values,
                         TColStd_Array1OfInteger& multiplicities) {
    for (int i = 0; i < values.Length(); ++i) {
      values.SetValue(i + 1, knots[static_cast<std::size_t>(i)].first);
      multiplicities.SetValue(i + 1, knots[static_cast<std::size_t>(i)].second);
    }
  };
  TColStd_Array1OfReal ku(1, static_cast<int>(u.size())), kv(1, static_cast<int>(v.size()));
  TColStd_Array1OfInteger mu(1, static_cast<int>(u.size())), mv(1, static_cast<int>(v.size()));
  arrays(u, ku, mu);
  arrays(v, kv, mv);
  TColgp_Array2OfPnt poles(1, s.count_u(), 1, s.count_v());
  for (int i = 0; i < s.count_u(); ++i)
    for (int j = 0; j < s.count_v(); ++j) {
      const Vec3& p = s.poles[static_cast<std::size_t>(i * s.count_v() + j)];
      poles.SetValue(i + 1, j + 1, gp_Pnt(p.x(), p.y(), p.z()));
    }
  return new Geom_BSplineSurface(poles, ku, kv, mu, mv, s.degree_u, s.degree_v);
}

Surface from_occt(const Handle(Geom_BSplineSurface)& g) {
  BSplineSurface s;
  s.degree_u = g->UDegree();
  s.degree_v = g->VDegree();
  for (int i = 1; i <= g->NbUKnots(); ++i)
    s.knots_u.insert(s.knots_u.end(), static_cast<std::size_t>(g->UMultiplicity(i)), g->UKnot(i));
  for (int i = 1; i <= g->NbVKnots(); ++i)
    s.knots_v.insert(s.knots_v.end(), static_cast<std::size_t>(g->VMultiplicity(i)), g->VKnot(i));
  for (int i = 1; i <= g->NbUPoles(); ++i)
    for (int j = 1; j <= g->NbVPoles(); ++j)
      s.poles.emplace_back(g->Pole(i, j).X(), g->Pole(i, j).Y(), g->Pole(i, j).Z());
  return Surface::bspline(s);
}

/// S(v, u): u and v change places, and the normal turns.
Surface swapped(const BSplineSurface& s) {
  BSplineSurface t = s;
  std::swap(t.degree_u, t.degree_v);
  std::swap(t.knots_u, t.knots_v);
  for (int i = 0; i < t.count_u(); ++i)
    for (int j = 0; j < t.count_v(); ++j)
      t.poles[static_cast<std::size_t>(i * t.count_v() + j)] =
          s.poles[static_cast<std::size_t>(j * s.count_v() + i)];
  return Surface::bspline(t);
}

constexpr Interval trimmed{0.1, 0.9};  // in u and v

/// The face ends within its surface, with room for rays from the extended reference to reach its corners.
/// Beyond them a level curve goes on by its own geodesic from wherever the last ray ended, which steps
/// decide.
Skin panel_skin(const Surface& surface, bool reversed = false) {
  Part part = make_rectangular_part(surface, trimmed, trimmed);
  part.faces[0].reversed = reversed;
  return Skin(std::make_shared<const Part>(part), {0});
}

/// Points on the gentle panel, directions that swing by some degrees about 30.
PlyOrientation panel_ply(const Skin& skin) {
  PlyOrientation ply{"P", {}, 0};
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 4; ++j) {
      const SurfacePoint at{0, Uv(0.12 + 0.76 * i / 5, 0.13 + 0.74 * j / 3)};
      const double angle = (30 + 4 * std::sin(1.1 * i + 0.7 * j)) * pi / 180;
      ply.points.push_back({skin.point(at), Vec3(std::cos(angle), std::sin(angle), 0), 0});
    }
  ply.start = 9;
  return ply;
}

PlanOptions panel_options() {
  PlanOptions o;
  o.range_mm = 250;
  return o;
}

struct Planned {
  Skin skin;
  Ply ply;
};
const Planned& panel() {
  static const Planned planned = [] {
    const Skin skin = panel_skin(gentle_surface());
    return Planned{skin, plan_ply(skin, panel_ply(skin), panel_options())};
  }();
  return planned;
}

/// How a second plan follows from the first: places by a rigid motion, numbers and all that turns with the
/// normal by a sign.
struct Motion {
  Eigen::Isometry3d move = Eigen::Isometry3d::Identity();
  int sides = 1;
};

// What may differ: the geodesics hold 1e-9 mm a level, and there are a dozen; the least-squares problem of
// the reference adds rounding. Samples need not fall together, but then they lie on the other's cubics to
// 1e-5 mm only: that they do within 1e-8 says that all decisions were the same.
constexpr double place_mm = 1e-8;

void expect_same(const Planned& a, const Planned& b, const Motion& motion) {
  ASSERT_EQ(a.ply.courses.size(), b.ply.courses.size());
  double worst = 0, worst_length = 0, worst_kg = 0, worst_deviation = 0;
  int matched = 0;
  for (const Course& course : a.ply.courses) {
    const Course* other = nullptr;
    for (const Course& c : b.ply.courses)
      if (c.number == motion.sides * course.number) other = &c;
    ASSERT_TRUE(other) << course.number;
    EXPECT_EQ(course.segments.size(), other->segments.size()) << course.number;
    worst_length = std::max(worst_length, std::abs(course.length_mm() - other->length_mm()));
    std::vector<SurfaceCurve> curves;
    for (const CourseSegment& segment : other->segments) curves.push_back(curve_of(b.skin, segment));
    for (std::size_t i = 0; i < course.segments.size(); ++i)
      for (const CourseSample& s : course.segments[i].samples) {
        const Vec3 p = motion.move * s.position;
        worst = std::max(worst, distance_to(b.skin, curves, p));
        // Where samples fall together, so does what is said of them. (Two segments may meet in a corner.)
        if (i >= other->segments.size()) continue;
        for (const CourseSample& q : other->segments[i].samples) {
          if ((q.position - p).norm() > place_mm) continue;
          ++matched;
          worst_kg = std::max(worst_kg, std::abs(q.kg_per_mm - motion.sides * s.kg_per_mm));
          worst_deviation = std::max(worst_deviation, std::abs(q.deviation_rad - motion.sides * s.deviation_rad));
          EXPECT_LT((q.normal - motion.sides * (motion.move.linear() * s.normal)).norm(), 1e-10);
          EXPECT_LT((q.tangent - motion.move.linear() * s.tangent).norm(), 1e-10);
        }
      }
  }
  EXPECT_LT(worst, place_mm);
  EXPECT_LT(worst_length, 10 * place_mm);
  EXPECT_GT(matched, 1000);
  // By a place_mm over the shortest radius and distance of ply points, some 100 mm.
  EXPECT_LT(worst_kg, 1e-10);
  EXPECT_LT(worst_deviation, 1e-10);
  const PlyReport &r = a.ply.report, &q = b.ply.report;
  EXPECT_NEAR(r.L1_mm, motion.sides > 0 ? q.L1_mm : q.L2_mm, 1e-3);  // sections to 1e-4 a metre
  EXPECT_NEAR(r.L2_mm, motion.sides > 0 ? q.L2_mm : q.L1_mm, 1e-3);
  EXPECT_EQ(r.N1, motion.sides > 0 ? q.N1 : q.N2);
  EXPECT_EQ(r.N2, motion.sides > 0 ? q.N2 : q.N1);
  EXPECT_NEAR(r.fit_rms_mm, q.fit_rms_mm, 1e-6);
}

// On the gentle panel, and on one where fronts fold and courses are cut.
TEST(Invariance, OfARigidMotion) {
  ASSERT_GT(panel().ply.courses.size(), 15u);
  const Skin folded = panel_skin(bumpy_surface());
  Motion motion;
  motion.move =
      Eigen::Translation3d(-4321, 1234, 777) * Eigen::AngleAxisd(2.2, Vec3(0.3, -0.5, 0.8).normalized());
  for (const Planned& planned : {panel(), {folded, plan_ply(folded, panel_ply(folded), panel_options())}}) {
    BSplineSurface moved = *planned.skin.face(0).surface.spline();
    for (Vec3& p : moved.poles) p = motion.move * p;
    PlyOrientation ply = panel_ply(planned.skin);
    for (PlyPoint& p : ply.points) {
      p.position = motion.move * p.position;
      p.direction = motion.move.linear() * p.direction;
    }
    const Skin skin = panel_skin(Surface::bspline(moved));
    expect_same(planned, {skin, plan_ply(skin, ply, panel_options())}, motion);
  }
}

TEST(Invariance, OfInsertedKnots) {
  const Handle(Geom_BSplineSurface) g = to_occt(*gentle_surface().spline());
  for (const double u : {0.111, 0.5, 0.734}) g->InsertUKnot(u, 1, 1e-12);
  for (const double v : {0.29, 0.31, 0.9}) g->InsertVKnot(v, 1, 1e-12);
  const Skin skin = panel_skin(from_occt(g));
  expect_same(panel(), {skin, plan_ply(skin, panel_ply(panel().skin), panel_options())}, {});
}

TEST(Invariance, OfARaisedDegree) {
  const Handle(Geom_BSplineSurface) g = to_occt(*gentle_surface().spline());
  g->IncreaseDegree(5, 4);
  const Skin skin = panel_skin(from_occt(g));
  expect_same(panel(), {skin, plan_ply(skin, panel_ply(panel().skin), panel_options())}, {});
}

// With u and v swapped S_u x S_v turns; a face that is turned back is the same, one that is not is the same
// seen from behind.
TEST(Invariance, OfSwappedParameters) {
  for (const bool reversed : {true, false}) {
    const Skin skin = panel_skin(swapped(*gentle_surface().spline()), reversed);
    Motion motion;
    motion.sides = reversed ? 1 : -1;
    expect_same(panel(), {skin, plan_ply(skin, panel_ply(panel().skin), panel_options())}, motion);
  }
}

// Seen from behind, left is right: course +k becomes -k where it was; normals, kappa_g and deviations turn.
TEST(Invariance, OfAReversedFace) {
  const Skin skin = panel_skin(gentle_surface(), true);
  Motion motion;
  motion.sides = -1;
  expect_same(panel(), {skin, plan_ply(skin, panel_ply(panel().skin), panel_options())}, motion);
}

// A fibre has no sense: the length and sign of directions change nothing but, by the first one, the walk's
// sense.
TEST(Invariance, OfTurnedDirections) {
  PlyOrientation ply = panel_ply(panel().skin);
  for (std::size_t i = 1; i < ply.points.size(); i += 2) ply.points[i].direction *= -3;
  expect_same(panel(), {panel().skin, plan_ply(panel().skin, ply, panel_options())}, {});
}

// --- files ---

std::filesystem::path write_step_file(const std::filesystem::path& path, const TopoDS_Shape& shape,
                                      const char* unit) {
  const test::HushedCout hushed;
  Interface_Static::SetCVal("xstep.cascade.unit", "MM");
  Interface_Static::SetCVal("write.step.unit", unit);  // the writer's model takes it at once
  STEPControl_Writer writer;
  EXPECT_EQ(writer.Transfer(shape, STEPControl_AsIs), IFSelect_RetDone);
  EXPECT_EQ(writer.Write(path.c_str()), IFSelect_RetDone);
  Interface_Static::SetCVal("write.step.unit", "MM");
  return path;
}

TEST(Invariance, OfTheFilesUnit) {
  const test::TemporaryDirectory scratch;
  const TopoDS_Shape face = BRepBuilderAPI_MakeFace(to_occt(*gentle_surface().spline()), trimmed.lo,
                                                    trimmed.hi, trimmed.lo, trimmed.hi, 1e-7)
                                .Shape();
  for (const char* unit : {"MM", "M", "INCH"}) {
    SCOPED_TRACE(unit);
    const StepModel model = read_step(write_step_file(scratch / (std::string(unit) + ".step"), face, unit));
    EXPECT_NEAR(model.unit_scale_to_mm, unit[0] == 'I' ? 25.4 : unit[1] == 'M' ? 1 : 1000, 1e-12);
    const Skin skin(std::make_shared<const Part>(model.part), {0});
    // The same knots; poles to the 15 digits of the file.
    expect_same(panel(), {skin, plan_ply(skin, panel_ply(panel().skin), panel_options())}, {});
  }
}

/// The whole face over a surface, converted to a B-spline by OpenCASCADE, written and read again.
Skin as_bspline(const Handle(Geom_Surface)& surface, double v0, double v1) {
  const test::TemporaryDirectory scratch;
  const TopoDS_Shape face = BRepBuilderAPI_MakeFace(surface, 0, 2 * pi, v0, v1, 1e-7).Shape();
  const TopoDS_Shape spline = BRepBuilderAPI_NurbsConvert(face).Shape();
  const StepModel model = read_step(write_step_file(scratch / "part.step", spline, "MM"));
  EXPECT_EQ(model.part.faces.size(), 1u);
  EXPECT_EQ(model.part.faces[0].surface.kind(), SurfaceKind::bspline);
  return Skin(std::make_shared<const Part>(model.part), {0});
}

const gp_Ax3 axes(gp::Origin(), gp::DZ(), gp::DX());

struct Shape {
  const char* name;
  Handle(Geom_Surface) occt;
  Surface exact;
  double v0, v1;
};
std::vector<Shape> shapes() {
  return {{"cylinder", new Geom_CylindricalSurface(axes, 350), Surface::cylinder({}, 350), -1000, 1000},
          {"sphere", new Geom_SphericalSurface(axes, 600), Surface::sphere({}, 600), -pi / 2, pi / 2},
          {"torus", new Geom_ToroidalSurface(axes, 700, 250), Surface::torus({}, 700, 250), 0, 2 * pi},
          {"cone", new Geom_ConicalSurface(axes, 0.35, 400), Surface::cone({}, 400, 0.35), -700, 1500}};
}

// A geodesic is a curve of the surface, not of its parameters: 1 m on the rational B-spline, over knots and
// seam, ends where it does on the analytic surface, to the 1e-9 mm that are promised.
TEST(Invariance, GeodesicsOfAnalyticShapesAsBSplines) {
  GeodesicOptions options;
  options.tolerance_mm = 1e-12;
  for (const Shape& shape : shapes()) {
    const Skin exact = make_skin(shape.exact, {0, 2 * pi}, {shape.v0, shape.v1});
    const Skin spline = as_bspline(shape.occt, shape.v0, shape.v1);
    const GeodesicTracer on_exact(exact, options), on_spline(spline, options);
    double worst = 0;
    for (int i = 0; i < 24; ++i) {
      // Places around the whole shape, headings all round; away from poles and rims by more than they walk.
      const double middle = shape.exact.kind() == SurfaceKind::torus ? 0.26 * i : 0.5 * (shape.v0 + shape.v1);
      const SurfacePoint start{0, Uv(0.1 + 0.26 * i, shape.exact.kind() == SurfaceKind::cone ? 400 : middle)};
      const SurfaceDerivatives d = exact.derivatives(start);
      const Vec3 t =
          std::cos(0.4 + 1.7 * i) * d.Su.normalized() + std::sin(0.4 + 1.7 * i) * d.Sv.normalized();
      const auto at = spline.closest_point().closest(d.S);
      ASSERT_TRUE(at);
      EXPECT_LT(at->distance_mm, 1e-11 * 1000);
      GeodesicState a = on_exact.start(start, t), b = on_spline.start(at->at, t);
      const TraceEnd end = on_exact.advance(a, 1000);
      EXPECT_EQ(end, on_spline.advance(b, 1000)) << shape.name << " " << i;
      if (end != TraceEnd::reached) continue;
      const PathFrame fa = frame_of(exact, a), fb = frame_of(spline, b);
      worst = std::max(worst, (fa.position - fb.position).norm());
      EXPECT_LT((fa.tangent - fb.tangent).norm(), 1e-10) << shape.name << " " << i;
      EXPECT_NEAR(a.y, b.y, 1e-9) << shape.name << " " << i;
    }
    EXPECT_LT(worst, 1e-9) << shape.name;
  }
}

/// The level curves between their nodes, and the known distance of their points from the reference.
void expect_levels(const Skin& skin, const Parallels& parallels, int courses,
                   const std::function<double(const Vec3&)>& distance) {
  int laid = 0;
  double worst = 0;
  for (const LevelCurve& level : parallels.levels) {
    const auto stretches = on_skin(skin, level);
    laid += !stretches.empty();
    for (const SurfaceCurve& stretch : stretches)
      for_each_midpoint(skin, stretch, [&](const CurveFrame& f) {
        worst = std::max(worst, std::abs(distance(f.frame.position) - level.number * W));
      });
  }
  EXPECT_EQ(laid, courses);
  EXPECT_LT(worst, 1e-6);
}

/// The line of constant v through the point of the skin at `p`, over the whole of u.
std::shared_ptr<const SplinePath> hoop(const Skin& skin, const Vec3& p) {
  const auto at = skin.closest_point().closest(p);
  EXPECT_LT(at->distance_mm, 1e-9);
  const Interval u = skin.face(0).surface.domain_u();
  return uv_line(skin, Uv(u.lo, at->at.uv.y()), Uv(u.hi, at->at.uv.y()), true);
}

TEST(Invariance, ParallelsOfASphereAsABSpline) {
  const double R = 600;
  const Skin skin = as_bspline(new Geom_SphericalSurface(axes, R), -pi / 2, pi / 2);
  const Parallels parallels = geodesic_parallels(skin, hoop(skin, Vec3(R, 0, 0)), exact_options(skin));
  // The pole lies 18.55 W away.
  expect_levels(skin, parallels, 37, [&](const Vec3& p) { return R * std::asin(p.z() / R); });
}

TEST(Invariance, ParallelsOfATorusAsABSpline) {
  const double R = 300, r = 120;
  const Skin skin = as_bspline(new Geom_ToroidalSurface(axes, R, r), 0, 2 * pi);
  const Parallels parallels = geodesic_parallels(skin, hoop(skin, Vec3(R + r, 0, 0)), exact_options(skin));
  // pi r / W = 7.42
  expect_levels(skin, parallels, 15,
                [&](const Vec3& p) { return r * std::atan2(p.z(), std::hypot(p.x(), p.y()) - R); });
}

TEST(Invariance, ParallelsOfACylinderAsABSpline) {
  const double R = 350;
  const Skin skin = as_bspline(new Geom_CylindricalSurface(axes, R), 0, 1000);
  const Parallels parallels = geodesic_parallels(skin, hoop(skin, Vec3(R, 0, 430)), exact_options(skin));
  // 570 / W = 11.2, 430 / W = 8.5
  expect_levels(skin, parallels, 20, [&](const Vec3& p) { return p.z() - 430; });
}

TEST(Invariance, ParallelsOfAConeAsABSpline) {
  const double half = 0.35;
  const Skin skin = as_bspline(new Geom_ConicalSurface(axes, half, 400), 0, 1000);
  const Parallels parallels = geodesic_parallels(
      skin, hoop(skin, Vec3(400, 0, 0) + 430 * Vec3(std::sin(half), 0, std::cos(half))), exact_options(skin));
  expect_levels(skin, parallels, 20, [&](const Vec3& p) { return p.z() / std::cos(half) - 430; });
}

}  // namespace
}  // namespace afptraj
