// Fills of the flower r = 15 (1 + 0.15 cos 10 t) by the number of rings, lines or points.
#include <benchmark/benchmark.h>

#include <cmath>

#include "fill/connect.h"
#include "fill/contour_parallel.h"
#include "fill/line_fill.h"

namespace {

using namespace afptraj;

Slice flower(int n) {
  SliceRing ring;
  for (int i = 0; i < n; ++i) {
    const double t = 2 * pi * i / n, r = 15 * (1 + 0.15 * std::cos(10 * t));
    ring.points.emplace_back(r * std::cos(t), r * std::sin(t));
  }
  return Slice(std::vector<SliceRing>{ring});
}

// The greatest inscribed circle has the radius 12.75.
double spacing_for(std::int64_t rings) { return 12.75 / static_cast<double>(rings); }

Fill rings_of(const Slice& slice, double spacing) {
  Fill fill;
  const DistanceDiagram diagram = DistanceDiagram::of(slice, 0);
  for (int k = 0; (k + 0.5) * spacing < diagram.greatest_mm(); ++k) {
    for (const ArcRing& ring : diagram.level((k + 0.5) * spacing, spacing / 50))
      fill.paths.push_back({flattened(ring, spacing / 1000), PathKind::ring, k});
  }
  return fill;
}

void levels(benchmark::State& state) {
  const Slice slice = flower(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(rings_of(slice, spacing_for(state.range(1))));
}
BENCHMARK(levels)
    ->Args({1000, 13})
    ->Args({1000, 1000})
    ->Args({10000, 10})
    ->Args({100000, 10})
    ->Unit(benchmark::kMillisecond);

void connect(benchmark::State& state, Connection connection) {
  const Slice slice = flower(1000);
  const double spacing = spacing_for(state.range(0));
  const Fill rings = rings_of(slice, spacing);
  for (auto _ : state) {
    const Fill joined = connected(rings, slice, spacing, connection);
    state.counters["paths"] = static_cast<double>(joined.paths.size());
  }
  state.counters["rings"] = static_cast<double>(rings.paths.size());
}
BENCHMARK_CAPTURE(connect, nested, Connection::nested)
    ->Arg(10)
    ->Arg(100)
    ->Arg(1000)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(connect, spiral, Connection::spiral)
    ->Arg(10)
    ->Arg(100)
    ->Arg(1000)
    ->Unit(benchmark::kMillisecond);

void zigzag(benchmark::State& state) {
  const Slice slice = flower(static_cast<int>(state.range(0)));
  LineOptions options;
  options.zigzag = true;
  for (auto _ : state) benchmark::DoNotOptimize(line_fill(slice, options));
}
BENCHMARK(zigzag)->Arg(1000)->Arg(10000)->Arg(100000)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
