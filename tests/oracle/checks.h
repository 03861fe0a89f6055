#pragma once

#include <string>
#include <vector>

#include "courses.h"
#include "occt_skin.h"

namespace oracle {

/// A measured greatest value and where it occurs.
struct Worst {
  double value = 0;
  Vec where{0, 0, 0};
  std::string what;
  void take(double v, const Vec& p, const std::string& w) {
    if (v > value) value = v, where = p, what = w;
  }
};

struct SurfaceCheck {
  Worst distance;  ///< of a sample from the nearest selected face
  Worst outside;   ///< of a sample from the material, where its foot is outside of the trim loops
  Worst normal;    ///< angle between the given and the true normal, rad
  Worst tangent;   ///< angle of the tangent out of the tangent plane, rad
  Worst spacing;   ///< of samples
  Worst arc;       ///< s between samples against their chord: what 5 % does not explain, mm
  std::size_t points = 0;
};
/// Sets Sample::at.
SurfaceCheck check_on_surface(const Skin& skin, PlyPaths& ply);

struct EndCheck {
  Worst error;        ///< distance of an end from the boundary (the nearer of pcurve and 3-D curve)
  Worst error_curve;  ///< distance to the 3-D curve of that edge
  int boundary = 0, seam = 0, shared = 0, pole = 0, corner = 0, closed = 0, inside = 0;
};
/// `reach_mm`: an end farther than this from any edge is `inside`.
EndCheck check_ends(const Skin& skin, const PlyPaths& ply, double reach_mm = 1e-3);

struct CrossingCheck {
  int self = 0, mutual = 0;
  std::vector<std::string> where;  ///< the first few
};
CrossingCheck check_crossings(const PlyPaths& ply, double band_mm);

struct SpacingCheck {
  Worst error;  ///< |d_geo(p, course k) - W|, over midpoints p of course k+1
  double rms = 0;
  int measured = 0;
  int beyond_end = 0;  ///< foot not on course k: nothing to measure
  int off_skin = 0;    ///< the connecting geodesic runs outside of the material: not counted in `error`
  Worst off_skin_error;
  int unresolved = 0;  ///< Newton did not converge though the foot is inside
  int courses = 0;
};
SpacingCheck check_spacing(const Skin& skin, const PlyPaths& ply, double band_mm, int points);

struct CoverageCheck {
  double area = 0;       ///< mm2
  double near_line = 0;  ///< within W/2 of a centre line as it is written
  double covered = 0;    ///< ... or of its geodesic continuation past the boundary, where the band is cut
  int samples = 0, measured = 0;
  Worst distance;  ///< of an uncovered sample from the nearest centre line (chord where far)
  struct Spot {
    Vec where;
    double distance, area;
  };
  std::vector<Spot> uncovered;  ///< every uncovered sample
  double near_line_share() const { return area > 0 ? near_line / area : 1; }
  double share() const { return area > 0 ? covered / area : 1; }
};
CoverageCheck check_coverage(const Skin& skin, const PlyPaths& ply, double band_mm, int samples);

/// Geodesic distance of the surface point `p` from a segment by Newton on (s, d), started from s0.
struct DistanceResult {
  enum class Kind { found, beyond_end, unresolved } kind = Kind::unresolved;
  double distance = 0, s = 0;
  double side = 0;  // 1: to the left of the segment
  bool left_skin = false;
};
/// `d0` > 0 and `side` (1 left, -1 right) replace the chord as the first guess.
DistanceResult geodesic_distance(const Skin& skin, const Segment& segment, const Foot& p, double s0,
                                 double d0 = 0, int side = 0);

}  // namespace oracle
