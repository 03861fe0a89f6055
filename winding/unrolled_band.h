#pragma once

#include <string>
#include <vector>

#include "winding/meridian_band.h"
#include "winding/simulate_program.h"

namespace afptraj {

/// A place on an unrolled mandrel: along its meridian from the first end, and round it from where it was
/// fixed.
struct UnrolledPoint {
  double along_mm = 0, turn_deg = 0;
};

/// A piece of a band between its edges, which have as many points.
struct UnrolledStrip {
  std::vector<UnrolledPoint> left, right;  ///< of the way it was laid
  bool back = false;                       ///< laid towards the first end
};

struct UnrolledLayer {
  std::string name;
  std::vector<UnrolledStrip> strips;  ///< in the order of laying, none longer than a quarter of a turn
};

/// A mandrel's surface and what lies on it.
struct UnrolledBand {
  double length_mm = 0;  ///< of the meridian
  double radius_mm = 0;  ///< widest
  std::vector<UnrolledLayer> layers;
};

/// The edges stay within this of the true ones, round the mandrel at its widest place.
inline constexpr double unrolled_tolerance_mm = 0.05;

/// The band of a rebuilt path on a mandrel with a meridian.
UnrolledLayer unrolled_layer(const std::string& name, const Meridian& meridian, const WindTow& tow,
                             const std::vector<ContactPoint>& path);
/// The band of pieces on a cylinder or cone.
UnrolledLayer unrolled_layer(const std::string& name, const WindMandrel& mandrel, const WindTow& tow,
                             const std::vector<LaidPiece>& pieces);

}  // namespace afptraj
