#pragma once

#include <functional>
#include <string>

#include "boundary/ply.h"
#include "boundary/tow_cuts.h"
#include "geometry/skin.h"
#include "trajectory/ply_orientation.h"

namespace afptraj {

/// What a plan is asked to hold. Lengths in mm, angles in rad.
struct PlanOptions {
  double tow_width_mm = 6.35;
  int tows = 8;
  double step_mm = 2;             ///< lambda, the greatest step of the reference path
  double chord_error_mm = 0.01;   ///< greatest distance of a step's chord from its arc
  double range_mm = 0;            ///< of the direction field; 0: one band width W
  double fairness = 1e-3;         ///< weight of the fairness term of the fit, see trajectory/fairing.h
  double extension_step_mm = 5;   ///< delta l, step of the extension past the ends
  double sample_mm = 0;           ///< greatest distance of output samples; 0: W / 12
  double min_steering_radius_mm = 635;
  double angle_limit_rad = 5 * pi / 180;
  double point_distance_limit_mm = 5;  ///< a ply point farther from the skin is an error
  int max_courses = 2000;         ///< on each side
  bool cut_tows = true;           ///< or only centre lines
  CutRule cut;
  bool keep_tow_lines = true;     ///< Ply::bands; what analysis/tow_coverage.h needs
  std::string plies_name = "plies.csv";  ///< for messages: the file the points come from
  double band_width_mm() const { return tow_width_mm * tows; }
};

/// Told of progress in [0, 1]; returns false to stop the plan (which then throws `Interrupted`).
using Progress = std::function<bool(const char* stage, double done)>;
struct Interrupted {};

/// Plans one ply: direction field, reference path, feature sections, geodesic parallels, clipping, tows.
/// Throws Error(no_path) when no path can start, Error(bad_input) when a ply point lies farther
/// than the limit from the skin.
Ply plan_ply(const Skin& skin, const PlyOrientation& orientation, const PlanOptions& options = {},
             const Progress& progress = {});

}  // namespace afptraj
