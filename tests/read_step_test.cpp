#include "io/step/read_step.h"

#include <gtest/gtest.h>

#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepGProp.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <GProp_GProps.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BezierCurve.hxx>
#include <Geom_BezierSurface.hxx>
#include <Geom_Circle.hxx>
#include <Geom_Ellipse.hxx>
#include <Geom_OffsetSurface.hxx>
#include <Geom_SphericalSurface.hxx>
#include <Geom_SurfaceOfLinearExtrusion.hxx>
#include <Geom_SurfaceOfRevolution.hxx>
#include <Geom_ToroidalSurface.hxx>
#include <STEPControl_Writer.hxx>
#include <TColgp_Array1OfPnt.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "geometry/error.h"
#include "geometry/skin.h"
#include "tests/step_oracle.h"
#include "tests/temporary_directory.h"

namespace afptraj {
namespace {

const std::filesystem::path steps = std::filesystem::path(AFPTRAJ_SHARED_DIR) / "data" / "steps";

/// What the files are known to hold (faces, solids, shells), from the data set's own manifest.
struct RealPart {
  const char* file;
  int faces, solids, shells;
  double size_mm;  ///< the longest side of its box
};
void PrintTo(const RealPart& part, std::ostream* out) { *out << part.file; }

class RealParts : public testing::TestWithParam<RealPart> {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(steps / GetParam().file))
      GTEST_SKIP() << "the real parts are not on this machine";
  }
  const StepModel& model() {
    static std::map<std::string, StepModel> known;
    auto found = known.find(GetParam().file);
    if (found == known.end())
      found = known.emplace(GetParam().file, read_step(steps / GetParam().file)).first;
    return found->second;
  }
};

Uv start_of(const Coedge& c) { return c.pcurve.point(c.reversed ? c.pcurve.last() : c.pcurve.first()); }
Uv end_of(const Coedge& c) { return c.pcurve.point(c.reversed ? c.pcurve.first() : c.pcurve.last()); }

struct Box {
  Vec3 lo = Vec3::Constant(1e300), hi = Vec3::Constant(-1e300);
  double longest() const { return (hi - lo).maxCoeff(); }
};
Box box_of_boundary(const Part& part) {
  Box box;
  for (const Face& face : part.faces) {
    for (const Loop& loop : face.loops) {
      for (const Coedge& c : loop.coedges) {
        for (int k = 0; k <= 20; ++k) {
          const Vec3 p = face.surface.point(
              c.pcurve.point(c.pcurve.first() + (c.pcurve.last() - c.pcurve.first()) * k / 20));
          box.lo = box.lo.cwiseMin(p), box.hi = box.hi.cwiseMax(p);
        }
      }
    }
  }
  return box;
}

void uv_box(const Face& face, Uv& lo, Uv& hi) {
  lo = Uv::Constant(1e300), hi = Uv::Constant(-1e300);
  for (const Loop& loop : face.loops) {
    for (const Coedge& c : loop.coedges) {
      for (const Uv& pole : c.pcurve.poles) lo = lo.cwiseMin(pole), hi = hi.cwiseMax(pole);
    }
  }
}

double area_of(const Loop& loop) {
  double sum = 0;
  for (const Coedge& c : loop.coedges) {
    const int n = 200;
    double part = 0;
    for (int k = 0; k < n; ++k) {
      const double a = c.pcurve.first() + (c.pcurve.last() - c.pcurve.first()) * k / n;
      const double b = c.pcurve.first() + (c.pcurve.last() - c.pcurve.first()) * (k + 1) / n;
      const Uv p = c.pcurve.point(a), q = c.pcurve.point(b);
      part += 0.5 * (p.x() * q.y() - q.x() * p.y());
    }
    sum += c.reversed ? -part : part;
  }
  return sum;
}

struct Use {
  const Face* face;
  const Coedge* coedge;
};
std::vector<std::vector<Use>> uses_of_edges(const Part& part) {
  std::vector<std::vector<Use>> uses(part.edges.size());
  for (const Face& face : part.faces) {
    for (const Loop& loop : face.loops) {
      for (const Coedge& c : loop.coedges) uses.at(static_cast<std::size_t>(c.edge)).push_back({&face, &c});
    }
  }
  return uses;
}

/// Loops are closed, on the right side, and edges hold their tolerance.
void expect_sound(const Part& part) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  for (const Face& face : part.faces) {
    SCOPED_TRACE("face #" + std::to_string(face.step_id));
    ASSERT_FALSE(face.loops.empty());
    Uv lo, hi;
    uv_box(face, lo, hi);
    for (std::size_t l = 0; l < face.loops.size(); ++l) {
      const auto& coedges = face.loops[l].coedges;
      for (std::size_t i = 0; i < coedges.size(); ++i) {
        // Poles at the ends are set equal: rounding of the evaluation is left.
        EXPECT_LE((end_of(coedges[i]) - start_of(coedges[(i + 1) % coedges.size()])).norm(),
                  1e-13 * (1 + hi.norm() + lo.norm()));
      }
      if (l == 0) {
        EXPECT_GT(area_of(face.loops[l]), 0);
      } else {
        EXPECT_LT(area_of(face.loops[l]), 0);
      }
    }
  }
  for (std::size_t e = 0; e < part.edges.size(); ++e) {
    const auto uses = uses_of_edges(part)[e];
    ASSERT_GE(uses.size(), 1u);
    ASSERT_LE(uses.size(), 2u);
    if (uses.size() == 1 || part.edges[e].degenerate) continue;
    const BSplineCurve2 &a = uses[0].coedge->pcurve, &b = uses[1].coedge->pcurve;
    ASSERT_EQ(a.first(), b.first());
    ASSERT_EQ(a.last(), b.last());
    for (int k = 0; k < 20; ++k) {
      const double t = a.first() + (a.last() - a.first()) * unit(random);
      const double gap =
          (uses[0].face->surface.point(a.point(t)) - uses[1].face->surface.point(b.point(t))).norm();
      // The tolerance is the greatest of samples and a tenth more: a random point may lie a little above.
      EXPECT_LE(gap, 1.3 * part.edges[e].tolerance_mm + 1e-9) << "edge " << e;
    }
  }
}

/// S and its derivatives agree with OpenCASCADE's at random points of the face's box in (u, v).
/// `slack` is the error of the surface in mm over cells of size h: by Markov's inequality the
/// derivatives of an interpolant of degree 9 are within 2 * 81 / h, and 2 * 81 * 64 / h^2, of it.
void expect_same_surface(const Face& face, const TopoDS_Face& oracle) {
  const Handle(Geom_Surface) surface = BRep_Tool::Surface(oracle);
  const bool interpolated = face.surface.kind() == SurfaceKind::bspline &&
                            surface->DynamicType()->Name() != std::string("Geom_BSplineSurface") &&
                            surface->DynamicType()->Name() != std::string("Geom_BezierSurface");
  Uv lo, hi;
  uv_box(face, lo, hi);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(0, 1);
  const double h = interpolated ? 0.05 * std::min((hi - lo).x(), (hi - lo).y()) : 1;
  for (int k = 0; k < 40; ++k) {
    const Uv uv = lo + (hi - lo).cwiseProduct(Uv(unit(random), unit(random)));
    gp_Pnt p;
    gp_Vec du, dv, duu, dvv, duv;
    surface->D2(uv.x(), uv.y(), p, du, dv, duu, dvv, duv);
    const SurfaceDerivatives d = face.surface.derivatives(uv);
    // Rounding of the poles, by the same inequality over the knot span (both programs round).
    Uv span_lo, span_hi;
    face.surface.span_box(face.surface.span_at(uv), span_lo, span_hi);
    const double span = std::min({1.0, (span_hi - span_lo).x(), (span_hi - span_lo).y()});
    const BSplineSurface* spline = face.surface.spline();
    const double degree = spline ? std::max(spline->degree_u, spline->degree_v) : 1;
    const double rounding = 2e-15 * d.S.norm();
    const double point = 1e-9 + 2e-13 * d.S.norm();
    const double first =
        1e-9 + rounding * 2 * degree * degree / span + (interpolated ? point * 2 * 81 / h : 0);
    const double second = 1e-9 + 1e-13 * (d.Suu.norm() + d.Suv.norm() + d.Svv.norm()) +
                          rounding * 4 * std::pow(degree, 4) / (span * span) +
                          (interpolated ? point * 2 * 81 * 64 / (h * h) : 0);
    const auto off = [](const Vec3& a, double x, double y, double z) { return (a - Vec3(x, y, z)).norm(); };
    EXPECT_LE(off(d.S, p.X(), p.Y(), p.Z()), point) << uv.transpose();
    EXPECT_LE(off(d.Su, du.X(), du.Y(), du.Z()), first) << uv.transpose();
    EXPECT_LE(off(d.Sv, dv.X(), dv.Y(), dv.Z()), first) << uv.transpose();
    EXPECT_LE(off(d.Suu, duu.X(), duu.Y(), duu.Z()), second) << uv.transpose();
    EXPECT_LE(off(d.Suv, duv.X(), duv.Y(), duv.Z()), second) << uv.transpose();
    EXPECT_LE(off(d.Svv, dvv.X(), dvv.Y(), dvv.Z()), second) << uv.transpose();
  }
}

/// Flux of the position vector through the faces, over three: the volume, where normals point out.
double volume_by_flux(const Part& part) {
  double sum = 0;
  for (std::size_t f = 0; f < part.faces.size(); ++f) {
    const Face& face = part.faces[f];
    for (const AreaSample& sample : area_samples(part, static_cast<int>(f), TrimRegion(face), 2000)) {
      const SurfaceDerivatives d = face.surface.derivatives(sample.at.uv);
      sum += (face.reversed ? -1 : 1) * d.S.dot(d.Su.cross(d.Sv).normalized()) * sample.area_mm2 / 3;
    }
  }
  return sum;
}

TEST_P(RealParts, HasTheFacesOfTheFile) {
  EXPECT_EQ(static_cast<int>(model().part.faces.size()), GetParam().faces);
  EXPECT_EQ(model().solids, GetParam().solids);
  EXPECT_EQ(model().shells, GetParam().shells);
  EXPECT_EQ(model().colours.size(), model().part.faces.size());
  // Boundaries need not reach the extremes of a curved face.
  const double longest = box_of_boundary(model().part).longest();
  EXPECT_LE(longest, 1.01 * GetParam().size_mm);
  EXPECT_GE(longest, 0.49 * GetParam().size_mm);
}

TEST_P(RealParts, EveryFaceHasItsEntity) {
  std::set<std::pair<int, std::string>> seen;
  for (const Face& face : model().part.faces) EXPECT_GT(face.step_id, 0);
}

TEST_P(RealParts, LoopsAndEdgesAreSound) { expect_sound(model().part); }

TEST_P(RealParts, SurfacesAreThoseOfOpenCascade) {
  const test::OracleModel oracle = test::read_with_occt(steps / GetParam().file);
  ASSERT_FALSE(oracle.shape.IsNull());
  int compared = 0;
  for (const Face& face : model().part.faces) {
    const auto found = oracle.faces.find(face.step_id);
    if (found == oracle.faces.end()) continue;
    SCOPED_TRACE("face #" + std::to_string(face.step_id) + " " + to_string(face.surface.kind()));
    expect_same_surface(face, found->second);
    ++compared;
  }
  EXPECT_GT(2 * compared, GetParam().solids > 10 ? 0 : GetParam().faces);
}

INSTANTIATE_TEST_SUITE_P(All, RealParts,
                         testing::Values(RealPart{"tigl_nacelle.stp", 6, 0, 1, 2599.82},
                                         RealPart{"iea15mw_blade_cfd.stp", 3, 0, 3, 117},
                                         RealPart{"caddee_simple_wing_foot.stp", 12, 0, 0, 5486},
                                         RealPart{"openvsp_fish_m.stp", 8, 0, 0, 1000},
                                         RealPart{"goteborg_hull_m.step", 3, 0, 3, 6120},
                                         RealPart{"esp_closebody_m.stp", 5, 0, 1, 4688.8},
                                         RealPart{"volmdlr_aircraft_engine.step", 57, 1, 1, 5483},
                                         RealPart{"aeroshape_box_wing.step", 6, 0, 2, 10.52},
                                         RealPart{"turbo3d_impeller.step", 92, 11, 11, 116.01},
                                         RealPart{"brl_rhino_primitives_m.stp", 8, 0, 4, 70000},
                                         RealPart{"cax_s1_head_rational_pole.stp", 5, 1, 1, 120},
                                         RealPart{"cax_s1_mainbody_back_inch.stp", 31, 1, 1, 146},
                                         RealPart{"ncc_compost_x_test_141.stp", 3, 0, 1, 236.4},
                                         RealPart{"jpl_horn_ap242.stp", 111, 10, 11, 273.88},
                                         RealPart{"occt_conical_surface.step", 5, 1, 1, 27.04},
                                         RealPart{"micro_ap214_vertex_loop_spline_pole.stp", 1, 0, 1, 10},
                                         RealPart{"micro_ap214_periodic_band_with_hole.stp", 1, 0, 1, 20},
                                         RealPart{"micro_ap214_offset_revolution.stp", 1, 0, 1, 22},
                                         RealPart{"micro_ap214_nurbs_native_seam.stp", 1, 0, 1, 20},
                                         RealPart{"malformed/no_freeform_as1_assembly.stp", 160, 18, 18,
                                                  200}),
                         [](const auto& info) {
                           std::string name = std::filesystem::path(info.param.file).stem().string();
                           return name;
                         });

#define NEEDS(file) \
  if (!std::filesystem::exists(steps / (file))) GTEST_SKIP() << "the real parts are not on this machine"

TEST(ReadStep, NormalsOfSolidsPointOut) {
  NEEDS("cax_s1_head_rational_pole.stp");
  for (const char* file :
       {"cax_s1_head_rational_pole.stp", "occt_conical_surface.step", "cax_s1_mainbody_back_inch.stp"}) {
    SCOPED_TRACE(file);
    GProp_GProps properties;
    BRepGProp::VolumeProperties(test::read_with_occt(steps / file).shape, properties);
    // Area samples inside of curved loops are right to about one cell in forty.
    EXPECT_NEAR(volume_by_flux(read_step(steps / file).part), properties.Mass(), 0.05 * properties.Mass());
  }
}

TEST(ReadStep, SewsLooseFacesAndTurnsThemOutward) {
  NEEDS("openvsp_fish_m.stp");
  const StepModel model = read_step(steps / "openvsp_fish_m.stp");
  EXPECT_EQ(model.sewn_edges, 12);
  EXPECT_LT(model.greatest_sewn_gap_mm, 1e-9);
  for (const auto& uses : uses_of_edges(model.part))
    EXPECT_TRUE(uses.size() == 2 || uses[0].coedge->pcurve.degree == 1);
  EXPECT_GT(volume_by_flux(model.part), 0);
}

TEST(ReadStep, SewsTheBladeAtAnyScale) {
  NEEDS("iea15mw_blade_cfd.stp");
  const StepModel as_declared = read_step(steps / "iea15mw_blade_cfd.stp");
  StepReadOptions metres;
  metres.unit_override = "m";
  const StepModel model = read_step(steps / "iea15mw_blade_cfd.stp", metres);
  EXPECT_EQ(as_declared.sewn_edges, 3);
  EXPECT_EQ(model.sewn_edges, 3);
  EXPECT_EQ(as_declared.unit_scale_to_mm, 1);
  EXPECT_EQ(model.unit_scale_to_mm, 1000);
  EXPECT_EQ(model.declared_unit, "millimetre");
  EXPECT_EQ(as_declared.warnings.size(), 1u);
  EXPECT_NE(as_declared.warnings[0].find("--unit m"), std::string::npos);
  EXPECT_TRUE(model.warnings.empty());
  const Box small = box_of_boundary(as_declared.part), large = box_of_boundary(model.part);
  EXPECT_LE((1000 * small.hi - large.hi).norm(), 1e-7);
  EXPECT_LE((1000 * small.lo - large.lo).norm(), 1e-7);
}

TEST(ReadStep, SewingCanBeTurnedOff) {
  NEEDS("openvsp_fish_m.stp");
  StepReadOptions options;
  options.sew_tolerance_mm = 0;
  const StepModel model = read_step(steps / "openvsp_fish_m.stp", options);
  EXPECT_EQ(model.sewn_edges, 0);
  for (const auto& uses : uses_of_edges(model.part)) EXPECT_EQ(uses.size(), 1u);
}

TEST(ReadStep, InstancesOfAnAssemblyStandApart) {
  NEEDS("malformed/no_freeform_as1_assembly.stp");
  const StepModel model = read_step(steps / "malformed" / "no_freeform_as1_assembly.stp");
  std::map<std::string, int> instances;
  for (const Face& face : model.part.faces) ++instances[face.instance];
  EXPECT_EQ(instances.size(), 18u);
  // Solids share no edges: every edge is used twice within one instance.
  for (const auto& uses : uses_of_edges(model.part)) {
    ASSERT_EQ(uses.size(), 2u);
    EXPECT_EQ(uses[0].face->instance, uses[1].face->instance);
  }
}

TEST(ReadStep, SameResultWithoutIsolation) {
  NEEDS("ncc_compost_x_test_141.stp");
  StepReadOptions options;
  options.isolate = false;
  const StepModel inside = read_step(steps / "ncc_compost_x_test_141.stp", options);
  const StepModel child = read_step(steps / "ncc_compost_x_test_141.stp");
  ASSERT_EQ(inside.part.faces.size(), child.part.faces.size());
  EXPECT_EQ(inside.sha256, child.sha256);
  EXPECT_EQ(inside.sha256.size(), 64u);
  for (std::size_t i = 0; i < child.part.faces.size(); ++i) {
    EXPECT_EQ(inside.part.faces[i].name, child.part.faces[i].name);
    EXPECT_EQ(inside.part.faces[i].loops.size(), child.part.faces[i].loops.size());
  }
}

/// Surfaces of kinds that the kernel does not have, written by OpenCASCADE and read back: the
/// interpolated B-spline follows OpenCASCADE's own evaluation in the same parameters.
class OtherKinds : public testing::Test {
 protected:
  void expect_read(const Handle(Geom_Surface)& surface, double u0, double u1, double v0, double v1,
                   SurfaceKind kind) {
    const test::TemporaryDirectory directory;
    const std::string path = directory / "part.step";
    {
      const test::HushedCout hushed;
      STEPControl_Writer writer;
      ASSERT_EQ(
          writer.Transfer(BRepBuilderAPI_MakeFace(surface, u0, u1, v0, v1, 1e-7).Face(), STEPControl_AsIs),
          IFSelect_RetDone);
      ASSERT_EQ(writer.Write(path.c_str()), IFSelect_RetDone);
    }
    const StepModel model = read_step(path);
    ASSERT_EQ(model.part.faces.size(), 1u);
    EXPECT_EQ(model.part.faces[0].surface.kind(), kind);
    expect_sound(model.part);
    const test::OracleModel oracle = test::read_with_occt(path);
    ASSERT_EQ(oracle.faces.size(), 1u);
    expect_same_surface(model.part.faces[0], oracle.faces.begin()->second);
  }

  static Handle(Geom_Curve) meridian() {
    TColgp_Array1OfPnt poles(1, 4);
    poles(1) = gp_Pnt(100, 0, 0), poles(2) = gp_Pnt(160, 0, 80), poles(3) = gp_Pnt(90, 0, 200),
    poles(4) = gp_Pnt(120, 0, 300);
    return new Geom_BezierCurve(poles);
  }
};

TEST_F(OtherKinds, RevolutionOverItsPeriod) {
  expect_read(new Geom_SurfaceOfRevolution(meridian(), gp::OZ()), 0, 2 * pi, 0, 1, SurfaceKind::bspline);
}
TEST_F(OtherKinds, RevolutionOverAPart) {
  expect_read(new Geom_SurfaceOfRevolution(meridian(), gp::OZ()), 1, 2.5, 0.1, 0.8, SurfaceKind::bspline);
}
TEST_F(OtherKinds, ExtrusionOfAnEllipse) {
  const Handle(Geom_Ellipse) ellipse = new Geom_Ellipse(gp::XOY(), 300, 100);
  expect_read(new Geom_SurfaceOfLinearExtrusion(ellipse, gp_Dir(0.3, 0, 1)), 0, 2 * pi, 0, 500,
              SurfaceKind::bspline);
}
TEST_F(OtherKinds, OffsetOfARevolution) {
  const Handle(Geom_Surface) basis = new Geom_SurfaceOfRevolution(meridian(), gp::OZ());
  expect_read(new Geom_OffsetSurface(basis, 12), 0.5, 3, 0.1, 0.9, SurfaceKind::bspline);
}
TEST_F(OtherKinds, BezierPatch) {
  TColgp_Array2OfPnt poles(1, 4, 1, 3);
  for (int i = 1; i <= 4; ++i) {
    for (int j = 1; j <= 3; ++j) poles(i, j) = gp_Pnt(100 * i, 150 * j, 20 * std::sin(i + 2.0 * j));
  }
  expect_read(new Geom_BezierSurface(poles), 0, 1, 0, 1, SurfaceKind::bspline);
}
TEST_F(OtherKinds, WholeSphere) {
  expect_read(new Geom_SphericalSurface(gp::XOY(), 250), 0, 2 * pi, -pi / 2, pi / 2, SurfaceKind::sphere);
}
TEST_F(OtherKinds, WholeTorus) {
  expect_read(new Geom_ToroidalSurface(gp::XOY(), 400, 90), 0, 2 * pi, 0, 2 * pi, SurfaceKind::torus);
}

/// A box whose faces were written one by one: joined to a closed body facing outward, of its volume.
TEST(ReadStep, JoinsTheFacesOfABox) {
  const test::TemporaryDirectory directory;
  const std::string path = directory / "box.step";
  {
    const test::HushedCout hushed;
    STEPControl_Writer writer;
    int k = 0;
    for (TopExp_Explorer it(BRepPrimAPI_MakeBox(300, 200, 100).Shape(), TopAbs_FACE); it.More(); it.Next()) {
      const TopoDS_Face face = TopoDS::Face(it.Current());
      writer.Transfer(++k % 2 ? face : TopoDS::Face(face.Reversed()), STEPControl_AsIs);
    }
    writer.Write(path.c_str());
  }
  const StepModel model = read_step(path);
  EXPECT_EQ(model.part.faces.size(), 6u);
  EXPECT_EQ(model.sewn_edges, 12);
  EXPECT_EQ(model.part.edges.size(), 12u);
  EXPECT_NEAR(volume_by_flux(model.part), 6e6, 1);
}

}  // namespace
}  // namespace afptraj
