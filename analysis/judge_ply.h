#pragma once

#include "boundary/plan_ply.h"

namespace afptraj {

struct JudgeOptions {
  double band_width_mm = 50.8;
  int area_samples = 8000;      ///< over the whole skin
  int spacing_samples = 1500;   ///< points between samples at which E_k is measured, spread over all courses
  double tolerance_mm = 1e-9;   ///< of the geodesics
};

/// How much of the skin lies within W/2 of a centre line, and where the rest is.
struct Coverage {
  double covered_share = 1;  ///< within W/2 of a centre line on the skin
  double reached_share = 1;  ///< or of one that runs off the skin
  std::vector<UncoveredSpot> uncovered;  ///< by area, greatest first
};

/// Samples the skin by area (midpoints of a grid in (u, v), each with its area) and measures for each
/// sample the distance along the skin to the nearest centre line. A chord longer than W/2 decides, one
/// shorter than the arc it may span on the most curved direction does too; between them the geodesic
/// does. Standard error of the share: about sqrt(p (1 - p) / samples).
Coverage measure_coverage(const Skin& skin, const Ply& ply, const JudgeOptions& options);

/// E_k: the greatest | distance to the neighbour toward course 0 - W | over points between samples
/// whose foot on that neighbour (its off-skin stretches included) is interior. `checked` counts them.
struct SpacingError {
  double worst_mm = 0;
  int worst_course = 0;
  Vec3 where = Vec3::Zero();
  int checked = 0;
};
SpacingError measure_spacing(const Skin& skin, const Ply& ply, const JudgeOptions& options);

/// Fills the judged part of the report.
void judge_ply(const Skin& skin, const JudgeOptions& options, Ply& ply);

}  // namespace afptraj
