#pragma once

#include <cstdint>
#include <vector>

#include "winding/band_arcs.h"
#include "winding/wind_definition.h"

namespace afptraj {

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
  double radius(double z_mm) const;

  WindMandrel mandrel_;
  std::int64_t piece_ = 0;
  double half_width_mm_, step_mm_, slant_;  // slant: way on the surface by way along the axis
  std::vector<std::vector<BandArc>> arcs_;  // by section
};

}  // namespace afptraj
