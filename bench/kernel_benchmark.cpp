// The kernel's hot loops on one surface, a bumpy panel of 1 x 0.6 m with 20 x 20 bicubic poles, beside
// OpenCASCADE's classes for the same question.
#include <benchmark/benchmark.h>

#include <GeomAPI_IntSS.hxx>
#include <GeomAPI_ProjectPointOnSurf.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_Plane.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <algorithm>
#include <cmath>
#include <random>

#include "geometry/geodesic.h"
#include "geometry/section.h"

namespace {

using namespace afptraj;

constexpr int poles = 20, degree = 3, spans = poles - degree;

BSplineSurface panel_spline() {
  BSplineSurface s;
  s.degree_u = s.degree_v = degree;
  for (int i = 0; i < poles + degree + 1; ++i) {
    s.knots_u.push_back(std::clamp(i - degree, 0, spans) / static_cast<double>(spans));
  }
  s.knots_v = s.knots_u;
  for (int i = 0; i < poles; ++i) {
    for (int j = 0; j < poles; ++j) {
      const double x = 1000.0 * i / (poles - 1), y = 600.0 * j / (poles - 1);
      s.poles.emplace_back(x, y, 40 * std::sin(x / 180) * std::cos(y / 140));
    }
  }
  return s;
}

Handle(Geom_BSplineSurface) panel_occt() {
  const BSplineSurface s = panel_spline();
  TColgp_Array2OfPnt points(1, poles, 1, poles);
  for (int i = 0; i < poles; ++i) {
    for (int j = 0; j < poles; ++j) {
      const Vec3& p = s.poles[static_cast<std::size_t>(i * poles + j)];
      points(i + 1, j + 1) = gp_Pnt(p.x(), p.y(), p.z());
    }
  }
  TColStd_Array1OfReal knots(1, spans + 1);
  TColStd_Array1OfInteger multiplicities(1, spans + 1);
  for (int i = 0; i <= spans; ++i) {
    knots(i + 1) = i / static_cast<double>(spans);
    multiplicities(i + 1) = i == 0 || i == spans ? degree + 1 : 1;
  }
  return new Geom_BSplineSurface(points, knots, knots, multiplicities, multiplicities, degree, degree);
}

const Skin& panel() {
  static const Skin skin(
      std::make_shared<const Part>(make_rectangular_part(Surface::bspline(panel_spline()), {0, 1}, {0, 1})),
      {0});
  return skin;
}

// Places in random order: no help from the neighbour before.
std::vector<Uv> places() {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0.02, 0.98);
  std::vector<Uv> out;
  for (int i = 0; i < 4096; ++i) out.emplace_back(unit(random), unit(random));
  return out;
}

void derivatives(benchmark::State& state) {
  const auto uv = places();
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(panel().face(0).surface.derivatives(uv[++i % uv.size()]));
}
BENCHMARK(derivatives);

void derivatives_occt(benchmark::State& state) {
  const Handle(Geom_BSplineSurface) surface = panel_occt();
  const auto uv = places();
  std::size_t i = 0;
  gp_Pnt p;
  gp_Vec du, dv, duu, dvv, duv;
  for (auto _ : state) {
    ++i;
    surface->D2(uv[i % uv.size()].x(), uv[i % uv.size()].y(), p, du, dv, duu, dvv, duv);
    benchmark::DoNotOptimize(p);
  }
}
BENCHMARK(derivatives_occt);

void closest_point(benchmark::State& state) {
  const auto uv = places();
  std::size_t i = 0;
  for (auto _ : state) {
    const Vec3 p = panel().point({0, uv[++i % uv.size()]}) + Vec3(0, 0, 5);
    benchmark::DoNotOptimize(panel().closest_point().closest(p));
  }
}
BENCHMARK(closest_point);

void closest_point_occt(benchmark::State& state) {
  const Handle(Geom_BSplineSurface) surface = panel_occt();
  const auto uv = places();
  GeomAPI_ProjectPointOnSurf finder;
  finder.Init(surface, 0, 1, 0, 1);
  std::size_t i = 0;
  for (auto _ : state) {
    const Vec3 p = panel().point({0, uv[++i % uv.size()]}) + Vec3(0, 0, 5);
    finder.Perform(gp_Pnt(p.x(), p.y(), p.z()));
    benchmark::DoNotOptimize(finder.LowerDistance());
  }
}
BENCHMARK(closest_point_occt);

void plane_section(benchmark::State& state) {
  const Plane plane{Vec3(500, 300, 0), Vec3(0.3, 1, 0.1).normalized()};
  for (auto _ : state) benchmark::DoNotOptimize(section(panel(), plane));
}
BENCHMARK(plane_section)->Unit(benchmark::kMicrosecond);

void plane_section_occt(benchmark::State& state) {
  const Handle(Geom_BSplineSurface) surface = panel_occt();
  const Handle(Geom_Plane) plane = new Geom_Plane(gp_Pnt(500, 300, 0), gp_Dir(0.3, 1, 0.1));
  for (auto _ : state) {
    const GeomAPI_IntSS curves(surface, plane, 5e-7);
    benchmark::DoNotOptimize(curves.NbLines());
  }
}
BENCHMARK(plane_section_occt)->Unit(benchmark::kMicrosecond);

void geodesic_of_900_mm(benchmark::State& state) {
  GeodesicOptions options;
  options.tolerance_mm = std::pow(10.0, -static_cast<double>(state.range(0)));
  const GeodesicTracer tracer(panel(), options);
  for (auto _ : state) {
    GeodesicState ray = tracer.start({0, {0.03, 0.4}}, Vec3(1, 0.15, 0));
    benchmark::DoNotOptimize(tracer.advance(ray, 900));
    benchmark::DoNotOptimize(ray);
  }
}
BENCHMARK(geodesic_of_900_mm)->Arg(7)->Arg(10)->Unit(benchmark::kMicrosecond);

}  // namespace

BENCHMARK_MAIN();
