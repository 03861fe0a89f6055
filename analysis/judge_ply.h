#pragma once

#include "boundary/plan_ply.h"

namespace afptraj {

struct JudgeOptions {
  double band_width_mm = 50.8;
  int area_samples = 8000;      ///< over the whole skin
  int spacing_samples = 4000;   ///< points between samples at which E_k is measured first, spread over all courses
  bool tow_coverage = false;    ///< gaps and overlaps of the tows, see tow_coverage.h
  double tolerance_mm = 1e-7;   ///< of the geodesics; the worst are measured again a thousand times finer
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

/// E_k: the greatest | distance to the level before - W | over points of level k + 1 between samples.
///
/// Law (S1): every point of course +-(k + 1) has geodesic distance exactly W to courses +-k together,
/// the stretches off the skin and the ends where fronts met included. Any other distance, however
/// far from W, is an error. There is nothing to measure only where the foot lies past an end on the
/// boundary, or lies on the other side than a parallel's, and farther than W (`beyond_end`).
///
/// Measured are the first and last chord of every segment and others evenly spread, then those that
/// look worst by chords alone, then all chords around the worst found. The feet are found by the
/// judge's own index and solver, none of the planner's.
SpacingError measure_spacing(const Skin& skin, const Ply& ply, const JudgeOptions& options);

/// Where centre lines cross themselves or each other: chords, seen along the skin's normal.
std::vector<CourseCrossing> find_crossings(const Skin& skin, const Ply& ply, const JudgeOptions& options);

/// Ends that are neither on the boundary nor meet another end of their level, within 1e-3 mm.
std::vector<LooseEnd> find_loose_ends(const Skin& skin, const Ply& ply, const JudgeOptions& options);

/// Fills the judged part of the report.
void judge_ply(const Skin& skin, const JudgeOptions& options, Ply& ply);

}  // namespace afptraj
