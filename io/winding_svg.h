#pragma once

#include <string>

#include "winding/unrolled_band.h"

namespace afptraj {

/// A picture of an unrolled mandrel in millimetres: the meridian's length to the right, one turn of the
/// widest circle upwards. Each layer is a group with its name, each strip of its band a polygon, half
/// transparent, so that bare places are white and overlaps dark; what was laid towards the first end is a
/// shade lighter.
std::string winding_svg(const UnrolledBand& band);

}  // namespace afptraj
