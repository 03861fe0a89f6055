#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "geometry/bspline_curve.h"

namespace afptraj {

/// A named wire: curves joined end to end, mm.
struct StepWire {
  std::string name;                       ///< of the course, for example "course +3.1"
  std::string group;                      ///< of the ply; wires of one group stay together
  std::array<double, 3> rgb = {0, 0, 0};  ///< sRGB in [0, 1], as screens show it
  std::vector<BSplineCurve3> curves;
};

enum class StepSchema { ap242, ap214 };

struct StepWriteOptions {
  StepSchema schema = StepSchema::ap242;
  std::string product = "afptraj";  ///< name of the assembly that holds the groups
};

/// Writes wires as `product` > group > wire with names and colours, in mm.
///
/// Law (W1): the same wires give the same bytes. The time stamp in the header is SOURCE_DATE_EPOCH
/// when that is set, else a constant.
/// Law (W2): reading the file back gives the same curves to 1e-9 mm.
///
/// Throws Error(cannot_write) when the file cannot be written whole, and removes it then;
/// Error(internal) when OpenCASCADE refuses a curve. An existing file is overwritten.
void write_step(const std::filesystem::path& path, const std::vector<StepWire>& wires,
                const StepWriteOptions& options = {});

}  // namespace afptraj
