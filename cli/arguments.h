#pragma once

#include <optional>
#include <string>
#include <vector>

namespace afptraj::cli {

/// A flag that sets a key of the job: "--step", "planning.step", "2".
struct JobFlag {
  std::string flag, key, text;
};

/// What follows `afptraj wind`.
struct WindArguments {
  enum class Command { validate, plan, simulate, plot, patterns, inspect };
  Command command = Command::validate;
  std::string file, output, faces, machine;
  std::string plies;  ///< plan of a part: the ply points
  bool fiberpath = false;
  std::string angle, angle_from, tolerance, tow_width, overlap, point_count;  ///< as typed
  std::string thickness, feed, friction;                                      ///< as typed
  std::optional<double> angle_deg;     ///< from the axis; none, in patterns: that of the first helical layer
  std::optional<double> tow_width_mm;  ///< patterns on a mandrel, plan of a part
  double most_overlap = 0.1;           ///< patterns on a mandrel, plan of a part
  double tolerance_deg = 2;            ///< patterns, plan of a part
  double thickness_mm = 0, feed_mm_per_min = 0, friction_ratio = 0;  ///< plan of a part
  std::string over_speed;  ///< plan of a vessel or part: "", "clamp" or "refuse"
  std::string layer_text;  ///< as typed
  int layer = 0;           ///< plot: from 1; 0: all
  int points = 0;          ///< inspect --json: pieces of the path that is listed
};

/// What follows `afptraj fill`.
struct FillArguments {
  enum class Pattern { contour, outline, raster, zigzag };
  enum class Connect { none, nested, spiral };
  Pattern pattern = Pattern::contour;
  std::string file, output;
  std::string pattern_text, spacing, compensate, corner_radius, tolerance, angle, max_link, connect_text,
      least_void;  ///< as typed
  double spacing_mm = 1, compensate_mm = -0.5, corner_radius_mm = 0.25, tolerance_mm = 1e-3;
  double angle_deg = 0, max_link_mm = 10;
  double least_void_mm2 = 0.05;
  std::string feed, extrusion;  ///< as typed
  double feed_mm_per_min = 1200, extrusion_mm_per_mm = 0;
  bool outline = false, gcode = false, vtp = false;
  Connect connect = Connect::none;
};

/// What the command line asks for. Texts are not judged yet, except for what CLI11 must know.
struct Arguments {
  enum class Command { none, help, version, run, inspect, wind, fill, doctor };
  Command command = Command::none;
  std::string help;  ///< the text to print for `help`

  std::string part, plies, job;
  std::vector<JobFlag> job_flags;  ///< in the order of the documentation; later ones override nothing
  int threads = 0;                 ///< 0: all cores
  double timeout_s = 0;            ///< 0: none
  double tangent_angle_deg = 5;    ///< inspect
  WindArguments wind;
  FillArguments fill;
  bool coverage = false;           ///< run: gaps and overlaps of the tows
  bool force = false, strict = false, json = false, quiet = false, verbose = false;
};

/// The number that `text` means, in [lo, hi] and whole where asked for. Throws Error(usage, flag, ...).
double bounded(const std::string& flag, const std::string& text, double lo, double hi, bool whole);

/// Throws Error(usage), naming the nearest command or flag for an unknown one.
Arguments parse_arguments(int count, const char* const* words);

}  // namespace afptraj::cli
