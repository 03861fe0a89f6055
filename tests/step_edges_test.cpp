// Joining edges, matching curves and interpolating surfaces: plain geometry, without OpenCASCADE.

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "geometry/geodesic.h"
#include "geometry/skin.h"
#include "io/step/interpolate.h"
#include "io/step/join_edges.h"
#include "io/step/match_edges.h"
#include "io/step/part_codec.h"
#include "io/step/sha256.h"

namespace afptraj {
namespace {

using namespace step;

Frame frame_at(const Vec3& origin, const Vec3& x, const Vec3& y) { return {origin, x, y, x.cross(y)}; }

BSplineCurve2 wavy() {
  BSplineCurve2 curve;
  curve.degree = 3;
  curve.knots = {0, 0, 0, 0, 0.3, 0.7, 0.7, 1, 1, 1, 1};
  curve.poles = {{0, 0}, {1, 2}, {2, -1}, {3, 1}, {4, 0}, {5, 3}, {6, 1}};
  curve.weights = {1, 2, 1, 0.5, 1, 1.5, 1};
  return curve;
}

TEST(SplitCurve, PartsAreTheCurve) {
  const BSplineCurve2 curve = wavy();
  for (const double cut : {0.1, 0.3, 0.5, 0.7, 0.99}) {
    const auto [left, right] = split_curve(curve, cut);
    EXPECT_EQ(left.first(), 0);
    EXPECT_EQ(left.last(), cut);
    EXPECT_EQ(right.first(), cut);
    EXPECT_EQ(right.last(), 1);
    for (int k = 0; k <= 20; ++k) {
      const double a = cut * k / 20, b = cut + (1 - cut) * k / 20;
      EXPECT_LE((left.point(a) - curve.point(a)).norm(), 1e-14);
      EXPECT_LE((right.point(b) - curve.point(b)).norm(), 1e-14);
    }
  }
}

TEST(InterpolateSurface, AnalyticSurfacesWithinTheTolerance) {
  const auto torus = [](double u, double v) {
    return Vec3((400 + 90 * std::cos(v)) * std::cos(u), (400 + 90 * std::cos(v)) * std::sin(u),
                90 * std::sin(v));
  };
  const SurfaceInterpolation made = interpolate_surface(torus, {0, 2 * pi}, {-1, 2}, 1e-9);
  EXPECT_LE(made.error, 1e-9);
  const Surface surface = Surface::bspline(made.spline);
  for (int i = 0; i <= 97; ++i) {
    for (int j = 0; j <= 31; ++j) {
      const double u = 2 * pi * i / 97, v = -1 + 3.0 * j / 31;
      // Between its probes the interpolant may err a few times more.
      EXPECT_LE((surface.point({u, v}) - torus(u, v)).norm(), 3e-9);
    }
  }
}

TEST(InterpolateSurface, PolynomialsKeepTheirDegree) {
  const auto saddle = [](double u, double v) { return Vec3(u, v, u * u * v - 3 * v); };
  const SurfaceInterpolation made = interpolate_surface(saddle, {-1, 2}, {0, 0.5, 3}, 1e-10);
  EXPECT_EQ(made.spline.degree_u, 2);
  EXPECT_EQ(made.spline.degree_v, 1);
  EXPECT_EQ(made.spline.count_u(), 3);
}

TEST(InterpolateSurface, KinksAreCells) {
  const auto roof = [](double u, double v) { return Vec3(u, v, std::abs(u - 1)); };
  const SurfaceInterpolation made = interpolate_surface(roof, {0, 1, 2}, {0, 1}, 1e-12);
  EXPECT_EQ(made.spline.count_u(), 3);
  EXPECT_LE(made.error, 1e-12);
}

/// The same circle as the rim of a cylinder (by angle) and as a rational curve on a plane.
TEST(InParametersOf, OneCircleTwoParametrisations) {
  const Surface cylinder = Surface::cylinder({}, 100), plane = Surface::plane({});
  const BSplineCurve2 rim = line_segment({0, 0}, {pi / 2, 0}, 3, 5);
  BSplineCurve2 arc;
  arc.degree = 2;
  arc.knots = {0, 0, 0, 1, 1, 1};
  arc.poles = {{100, 0}, {100, 100}, {0, 100}};
  arc.weights = {1, std::sqrt(0.5), 1};
  const SpaceCurve a{&cylinder, &rim}, b{&plane, &arc};
  const BSplineCurve2 same = in_parameters_of(a, b, false);
  EXPECT_EQ(same.first(), 3);
  EXPECT_EQ(same.last(), 5);
  EXPECT_LE(greatest_gap(a, {&plane, &same}).distance, 1e-8);
  // Drawn the other way it is the same.
  BSplineCurve2 back = arc;
  std::reverse(back.poles.begin(), back.poles.end());
  const BSplineCurve2 turned = in_parameters_of(a, {&plane, &back}, true);
  EXPECT_LE(greatest_gap(a, {&plane, &turned}).distance, 1e-8);
}

/// An edge's image that is off by 0.01 in the parameters is put where the edge meets the surface.
TEST(InParametersOf, APoorImageIsMadeAnew) {
  const Surface cylinder = Surface::cylinder({}, 100);
  const BSplineCurve2 truth = line_segment({0, 0}, {1, 50});
  const BSplineCurve2 poor = interpolate_curve([](double t) { return Uv(t, 50 * t + std::sin(pi * t)); },
                                               {0, 1}, [](double, double) { return 1e-12; })
                                 .curve;
  const SpaceCurve a{&cylinder, &truth};
  EXPECT_GT(greatest_gap(a, {&cylinder, &poor}).distance, 0.5);
  const BSplineCurve2 better = in_parameters_of(a, {&cylinder, &poor}, false);
  EXPECT_LE(greatest_gap(a, {&cylinder, &better}).distance, 1e-8);
}

/// A model of rectangular faces on planes, every face with edges of its own.
StepModel loose(const std::vector<RectangularFace>& faces) {
  StepModel model;
  for (const RectangularFace& one : faces) {
    Face face = one.face;
    for (Loop& loop : face.loops) {
      for (Coedge& c : loop.coedges) c.edge += static_cast<int>(model.part.edges.size());
    }
    model.part.edges.insert(model.part.edges.end(), one.edges.begin(), one.edges.end());
    model.part.faces.push_back(std::move(face));
  }
  return model;
}

int shared_edges(const Part& part) {
  std::vector<int> uses(part.edges.size(), 0);
  for (const Face& face : part.faces) {
    for (const Loop& loop : face.loops) {
      for (const Coedge& c : loop.coedges) ++uses[static_cast<std::size_t>(c.edge)];
    }
  }
  return static_cast<int>(std::count(uses.begin(), uses.end(), 2));
}

RectangularFace sheet(const Vec3& origin, const Vec3& x, const Vec3& y, double a, double b) {
  return make_rectangular_face(Surface::plane(frame_at(origin, x, y)), {0, a}, {0, b});
}

TEST(JoinEdges, NeighboursWithinTheToleranceOnly) {
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY();
  for (const double gap : {0.0, 0.05, 0.2}) {
    StepModel model = loose({sheet({0, 0, 0}, x, y, 1000, 500), sheet({0, 500 + gap, 0}, x, y, 1000, 300)});
    join_edges(model, {-1, -1}, -1);
    // 1e-4 of the diagonal is more than the bound of 0.1 mm.
    EXPECT_EQ(model.sewn_edges, gap < 0.1 ? 1 : 0) << gap;
    EXPECT_EQ(shared_edges(model.part), model.sewn_edges);
    if (model.sewn_edges) {
      EXPECT_NEAR(model.greatest_sewn_gap_mm, gap, 1e-9);
      EXPECT_EQ(model.part.edges.size(), 7u);
    }
  }
}

/// The foot on the mate's surface lies in the gap, outside of its loops; the path goes on at the mate's edge.
TEST(JoinEdges, AGeodesicGoesOnAtTheEdgeOfAFaceThatGaps) {
  const double gap = 5e-3;
  StepModel model = loose({sheet({0, 0, 0}, Vec3::UnitX(), Vec3::UnitY(), 1000, 500),
                           sheet({0, 500 + gap, 0}, Vec3::UnitX(), Vec3::UnitY(), 1000, 300)});
  join_edges(model, {-1, -1}, -1);
  ASSERT_EQ(model.sewn_edges, 1);
  const Skin skin(std::make_shared<const Part>(model.part), {0, 1});
  const GeodesicTracer tracer(skin, {});
  GeodesicState g = tracer.start({0, Uv(100, 400)}, Vec3(0.6, 0.8, 0));
  // 125 mm to the edge at (175, 500); the gap has no length along the path.
  ASSERT_EQ(tracer.advance(g, 225), TraceEnd::reached);
  EXPECT_EQ(g.at.face, 1);
  EXPECT_LT((g.at.uv - Uv(235, 80)).norm(), 1e-9);
  EXPECT_FALSE(g.outside);
}

TEST(JoinEdges, OtherSolidsStayApart) {
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY();
  StepModel model = loose({sheet({0, 0, 0}, x, y, 1000, 500), sheet({0, 500, 0}, x, y, 1000, 300)});
  join_edges(model, {0, 1}, 0.1);
  EXPECT_EQ(model.sewn_edges, 0);
}

/// A long edge with two shorter ones along it: it is cut where they meet.
TEST(JoinEdges, TJunction) {
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY();
  StepModel model = loose({sheet({0, 0, 0}, x, y, 1000, 500), sheet({0, 500, 0}, x, y, 400, 300),
                           sheet({400, 500, 0}, x, y, 600, 300)});
  join_edges(model, {-1, -1, -1}, 0.1);
  EXPECT_EQ(model.sewn_edges, 3);
  EXPECT_EQ(model.part.faces[0].loops[0].coedges.size(), 5u);
  const auto& coedges = model.part.faces[0].loops[0].coedges;
  for (std::size_t i = 0; i < coedges.size(); ++i) {
    const Coedge &a = coedges[i], &b = coedges[(i + 1) % coedges.size()];
    const Uv end = a.pcurve.point(a.reversed ? a.pcurve.first() : a.pcurve.last());
    const Uv start = b.pcurve.point(b.reversed ? b.pcurve.last() : b.pcurve.first());
    EXPECT_LE((end - start).norm(), 1e-12);
  }
}

TEST(JoinEdges, NormalsAgreeAfterwards) {
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY();
  // The second of three has its normal down.
  StepModel model = loose({sheet({0, 0, 0}, x, y, 100, 100), sheet({100, 100, 0}, -x, y, 100, 100),
                           sheet({0, 200, 0}, x, y, 100, 100)});
  join_edges(model, {-1, -1, -1}, 0.1);
  EXPECT_EQ(model.sewn_edges, 2);
  EXPECT_FALSE(model.part.faces[0].reversed);
  EXPECT_TRUE(model.part.faces[1].reversed);
  EXPECT_FALSE(model.part.faces[2].reversed);
}

/// Two half cylinders make a tube, although each of their edges could also be taken for the other's.
TEST(JoinEdges, HalvesOfATube) {
  const Surface cylinder = Surface::cylinder({}, 80);
  StepModel model = loose({make_rectangular_face(cylinder, {0, pi}, {0, 300}),
                           make_rectangular_face(cylinder, {pi, 2 * pi}, {0, 300})});
  join_edges(model, {-1, -1}, -1);
  EXPECT_EQ(model.sewn_edges, 2);
  EXPECT_LE(model.greatest_sewn_gap_mm, 1e-12);
}

TEST(PartCodec, RoundTripAndBrokenBytes) {
  PlainModel model;
  model.head.schema = "AP242";
  model.head.warnings = {"a", "b"};
  PlainFace face;
  face.surface.kind = SurfaceKind::cone;
  face.surface.radius = 3;
  face.surface.second = 0.2;
  face.loops = {{{{wavy(), true, 4}}}};
  face.name = "skin";
  face.colour = {0.1, 0.2, 0.3};
  model.faces = {face};
  model.edges = {{true, 0.5}};
  const std::string bytes = encode(model);
  const PlainModel back = decode(bytes);
  EXPECT_EQ(encode(back), bytes);
  EXPECT_EQ(back.faces[0].loops[0].coedges[0].pcurve.poles, wavy().poles);
  for (std::size_t cut = 0; cut < bytes.size(); cut += 7)
    EXPECT_ANY_THROW(decode(std::string_view(bytes).substr(0, cut)));
  EXPECT_ANY_THROW(decode(bytes + "x"));
}

TEST(Sha256, KnownAnswers) {  // FIPS 180-4 examples
  EXPECT_EQ(sha256_hex(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256_hex("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256_hex(std::string(1000000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

}  // namespace
}  // namespace afptraj
