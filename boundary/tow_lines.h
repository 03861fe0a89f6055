#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "geometry/surface_curve.h"
#include "trajectory/parallels.h"

namespace afptraj {

/// How the lines of tows are found. Lengths in mm.
struct TowLineOptions {
  double tow_width_mm = 6.35;
  int tows = 8;
  double coverage_rule = 0.5;  ///< p, see tow_cuts.h: which lines within a tow decide on a cut
  double station_mm = 16;      ///< greatest distance of stations along the centre line
  double tolerance_mm = 1e-3;  ///< estimated error of the cubics between stations; more stations where it is not held
  double beyond_mm = 0;        ///< how far lines go on past the last place where any of them is on the skin
};

/// A line at a constant geodesic distance from a centre line, positive to the left. A run ends where no ray leads.
struct TowLine {
  double offset_mm = 0;
  std::vector<SurfaceCurve> runs;
};

/// The lines of the N tows along one curve of a course. All lines share the parameter t of the centre
/// line: the same t is the same place of the head. Tow j = 1 ... N lies between edges[j - 1] (its left) and
/// edges[j]; vectors that belong to tows are indexed by j - 1.
struct TowBand {
  int course = 0;
  bool closed = false;
  double first = 0, last = 0;    ///< of t, the extension past open ends off the skin included
  std::vector<TowLine> edges;    ///< N + 1, at (N / 2 - j) d, from the left
  std::vector<TowLine> middles;  ///< at ((N + 1) / 2 - j) d
  /// Within a tow at p of its width from its left edge, and from its right; empty where p is 0, 1/2 or 1.
  std::vector<TowLine> from_left, from_right;
};

/// Finds the tow lines of curves, one by one, as geodesic parallels: rays leave the centre line at right
/// angles, lines are cubics between their ends, and pass edges between faces exactly (level_curve.h).
///
/// A centre line that ends off the skin or at its boundary goes on along its own geodesic, over the continuation of the skin, as long as
/// one of its lines is on the skin: at a boundary at an angle a the outer tows go on for W / (2 tan a). One that ends
/// within the skin (a meeting of fronts) ends square there.
///
/// Error: the tolerance, as estimated from every second station; tests/lay_tows_test.cpp measures it on a sphere.
class TowBandMaker {
 public:
  TowBandMaker(const Skin& skin, const TowLineOptions& options);
  ~TowBandMaker();
  TowBandMaker(const TowBandMaker&) = delete;
  TowBandMaker& operator=(const TowBandMaker&) = delete;

  /// Nothing where no tow of the curve touches the skin. Several threads may ask at once.
  std::optional<TowBand> band(int course, const SurfaceCurve& curve) const;

 private:
  struct Parts;
  std::unique_ptr<const Parts> parts_;
};

/// The bands of all curves of all levels, in their order; those of which no tow touches the skin are left out.
std::vector<TowBand> tow_bands(const Skin& skin, const std::vector<LevelCurve>& levels, const TowLineOptions& options);

}  // namespace afptraj
