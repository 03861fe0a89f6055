#pragma once

#include <string>
#include <vector>

#include "trajectory/ply_orientation.h"

namespace afptraj {

/// What plies.csv holds: the plies in the order of the file, and what was passed over.
struct PliesFile {
  std::vector<PlyOrientation> plies;
  std::vector<std::string> warnings;
};

/// Reads `ply,x,y,z,dx,dy,dz[,start]`: mm in part coordinates, directions of any length, `start` 1 on
/// the row where the ply's reference path begins (else its first row). Rows of a ply stand together.
/// Throws Error(bad_input, "file:line", ...) naming the column and the fix.
PliesFile read_plies_file(const std::string& path);

/// Only the plies.
std::vector<PlyOrientation> read_plies(const std::string& path);

}  // namespace afptraj
