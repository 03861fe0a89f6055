#pragma once

#include "geometry/skin.h"
#include "winding/meridian.h"

namespace afptraj {

/// A skin as a mandrel.
struct SkinMandrel {
  Meridian meridian;  ///< z from `origin` along `direction`
  Vec3 origin,
      direction;  ///< of the axis: its place nearest to the part's origin; unit, as `Revolution` has it
  double deviation_mm = 0;  ///< greatest distance found between the skin's other half-planes and the meridian
};

/// The axis is that of the face of revolution which reaches farthest along its axis (spheres only where there
/// is nothing else). The meridian is the section of the skin by a half-plane through the axis, with a corner
/// where it passes from face to face, as a spline within 1e-6 mm of what was found; it is compared with
/// sections by `compared_half_planes` more. Throws Error(bad_input, "skin", ...) naming what is wrong and
/// where: no face of revolution (and how far off), a deviation beyond `tolerance_mm`, a gap along the axis,
/// more than one wall.
SkinMandrel mandrel_from_skin(const Skin& skin, double tolerance_mm);
inline constexpr int compared_half_planes = 7;

}  // namespace afptraj
