#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "winding/wind_definition.h"

namespace afptraj {

/// How a mandrel is covered by the tow that was laid on it.
struct BandCoverage {
  double covered_share = 0;  ///< of the wound length's surface
  double overlap_share = 0;  ///< surface laid more than once, each further time counted, by the covered one
  double widest_gap_mm = 0;  ///< bare between two tows, round the mandrel at one place along it
  double gap_z_mm = 0, gap_deg = 0;  ///< where the widest is: along the axis, and its middle round it
};

/// Rebuilds the band that a winding lays: each straight piece of the path on the unrolled mandrel is a
/// rectangle of the tow's width, with the wedge between it and the next where the path bends. The union is
/// exact along `sections` circles spread evenly from z = 0 to L (the ends themselves are half a section off).
/// On a cone a piece is unrolled at its own radius.
class LaidBand {
 public:
  LaidBand(const WindMandrel& mandrel, double tow_width_mm, int sections);

  /// A piece of the path: along the axis, and the mandrel's angle against the eye, unbounded.
  void lay(double z0_mm, double angle0_deg, double z1_mm, double angle1_deg);
  BandCoverage coverage() const;

 private:
  struct Arc {
    double from, to;     // degrees, unbounded
    std::int64_t piece;  // that laid it, or its last part
  };
  struct Circle {
    double laid_deg = 0, bare_deg = 360;
    double widest_deg = 0, widest_at_deg = 0;  // the widest bare arc, and its middle
  };
  static Circle united(const std::vector<Arc>& laid);
  double radius(double z_mm) const;
  void cover(std::size_t section, Arc arc);

  WindMandrel mandrel_;
  std::int64_t piece_ = 0;
  double half_width_mm_, step_mm_, slant_;  // slant: way on the surface by way along the axis
  std::vector<std::vector<Arc>> arcs_;      // by section
};

}  // namespace afptraj
