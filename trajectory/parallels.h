#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "trajectory/front.h"

namespace afptraj {

struct ParallelOptions {
  FrontOptions front;
  GeodesicOptions geodesic;
  int max_levels = 2000;
};

/// The curves at one distance from the reference: number k lies at |k| W, to the left for k > 0.
struct LevelCurve {
  int number = 0;
  std::vector<SurfaceCurve> curves;
};

struct Parallels {
  std::vector<LevelCurve> levels;  ///< by number, from the right to the left
  bool reached_max_levels = false;
};

/// Geodesic parallels of a reference curve on the extended skin, to both sides until no ray is left.
///
/// Law (P1): every point p of level k + 1 has a foot on level k at geodesic distance W, and no point
/// of level k is nearer (one-sided; checked between samples by tests/parallels_test.cpp with an
/// independent integrator). Where fronts fold or collide each ends where they meet.
///
/// The reference is first extended past its open ends along its own geodesic; a level curve that
/// ends inside the skin is extended likewise and its extension becomes part of the level, so that
/// the next level keeps its distance from it too.
/// `progress` is called once a level and may return false to stop.
Parallels geodesic_parallels(const Skin& skin, std::shared_ptr<const SourceCurve> reference,
                             const ParallelOptions& options, const std::function<bool(int level)>& progress = {});

}  // namespace afptraj
