#pragma once

#include <string>
#include <vector>

#include "cli/arguments.h"
#include "winding/vessel_program.h"

namespace afptraj::cli {

/// A winding asked for by ply points on a part.
struct PlyWinding {
  VesselWinding winding;
  std::vector<std::vector<std::string>> plies;  ///< names, by layer
  std::string notes;                            ///< how plies became layers, a line each
};

/// The part is the mandrel; the angles are those of the ply points, all else the flags'. Throws Error.
PlyWinding read_ply_winding(const WindArguments& arguments);

}  // namespace afptraj::cli
