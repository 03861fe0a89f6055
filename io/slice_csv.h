#pragma once

#include <string>

#include "fill/slice.h"

namespace afptraj {

/// A slice and the height at which it lies.
struct SliceFile {
  Slice slice;
  double z_mm = 0;
  std::vector<std::string> warnings;
};

/// Reads closed rings: a CSV table with the columns path, i, x, y (mm) and optionally z (the same everywhere)
/// and closed (0 is refused: a slice needs closed rings). The rows of a ring stand together, i grows; a first
/// point that is repeated at the end is dropped. Throws Error(bad_input, "file:line" or file, what is wrong;
/// what to do); see also Slice.
SliceFile read_slice(const std::string& path);

}  // namespace afptraj
