#pragma once

#include <string>
#include <vector>

#include "occt_skin.h"

namespace oracle {

/// A row of paths.csv.
struct Sample {
  double s = 0;
  Vec x{0, 0, 0}, n{0, 0, 1}, t{1, 0, 0};
  double kg = 0;
  int line = 0;
  Foot at;  ///< set by check_on_surface
};

struct Segment {
  int course = 0, number = 0;
  std::vector<Sample> samples;
  bool closed = false;
  double length() const { return samples.back().s - samples.front().s; }

  struct Point {
    Vec x, t;  ///< t is unit
    double kg = 0;
    std::size_t i = 0;  ///< sample before
  };
  /// Cubic Hermite through positions and tangents at arc length s, ends clamped (closed: wrapped).
  Point at(double s) const;
};

struct PlyPaths {
  std::string name;
  std::vector<Segment> segments;
};

/// Reads paths.csv; throws std::runtime_error naming the line.
std::vector<PlyPaths> read_paths(const std::string& path);

/// Marks segments whose ends agree in place and direction.
void mark_closed(PlyPaths& ply);

}  // namespace oracle
