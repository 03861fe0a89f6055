#pragma once

#include <string>
#include <vector>

#include "winding/skin_mandrel.h"

namespace afptraj {

/// An asked fibre direction: a place near the mandrel, in the part's coordinates, and the direction there
/// (any length; its sign carries no meaning).
struct FibreDirection {
  Vec3 point = Vec3::Zero(), direction = Vec3::UnitX();
};

/// What the directions of a ply ask of a winder.
struct PlyAngle {
  double angle_deg = 0;   ///< from the axis at the mandrel's widest place: asin(K / R)
  double spread_deg = 0;  ///< at some point the asked direction is so far from that of this geodesic
  double off_mm = 0;      ///< greatest distance of a point from the mandrel
  /// The fibre climbs by growing azimuth about the mandrel's direction (+1), or by falling (-1); 0 where that
  /// is not to be told: along the axis, or round it.
  int sense = 0;
};

/// Each point asks for r sin(alpha) of the geodesic through it; K is their mean.
/// Laws, checked by tests/ply_angles_test.cpp: points along one geodesic give its angle and no spread; the
/// mirrored ply has the other sense; moving part and points together changes nothing.
/// REQUIRES: points. Throws Error(bad_input, "ply", ...) for a point farther from the mandrel than a tenth of
/// its widest radius, a direction across the surface, or points of both senses.
PlyAngle ply_angle(const SkinMandrel& mandrel, const std::vector<FibreDirection>& points);

/// Plies as layers of a winder. A helical layer lays both senses: a ply and the next one, its mirror image,
/// are one layer.
struct PlyLayer {
  double angle_deg = 0;
  std::vector<std::size_t> plies;  ///< by number, from 0
};
std::vector<PlyLayer> layers_of_plies(const std::vector<PlyAngle>& plies, double tolerance_deg);

}  // namespace afptraj
