#pragma once

#include <string>
#include <vector>

#include "boundary/ply.h"

namespace afptraj {

/// The content of coverage.csv: a header and one row per gap and overlap, in the order of plies, greatest
/// area first. Columns: ply,kind,layers,area_mm2,length_mm,width_mm,x,y,z,face,boundary,tows. `tows` names
/// those at its edge, course and tow, as in "c-1t8 c0t1". Throws Error(internal) for a NaN.
std::string coverage_csv(const std::vector<Ply>& plies);

/// Course and tow, as in "c-1t8 c0t1".
std::string tow_names(const TowSpot& spot);

}  // namespace afptraj
