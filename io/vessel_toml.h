#pragma once

#include <optional>
#include <string>
#include <vector>

#include "winding/vessel_program.h"

namespace afptraj {

/// A winding of a mandrel with a meridian, without the mandrel itself, which is in a file of its own.
struct VesselFile {
  std::string mandrel;  ///< a path: .csv meridian or a part
  std::string faces;    ///< of a part: the faces of the mandrel ("2-4"); empty: all that are not plane
  WindTow tow;
  double feed_mm_per_min = 0;
  std::string machine;  ///< a path to a machine profile; empty: none is named
  std::vector<VesselLayer> layers;
  bool growth = true;
};

/// Reads it (docs/winding.md, "Vessels"). The paths of mandrel and machine are taken from
/// the directory of the file. Throws
/// Error(usage, "file:line:column", what is wrong; what to do).
VesselFile read_vessel(const std::string& path);

}  // namespace afptraj
