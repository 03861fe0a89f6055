#pragma once

// Private to io/step: from the bytes of a STEP file to placed OpenCASCADE faces.

#include <TopoDS_Face.hxx>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "io/step/read_step.h"
#include "io/step/step_text.h"

namespace afptraj::step {

/// A face of the file, placed, in mm.
struct SourceFace {
  TopoDS_Face face;
  int group = 0;  ///< faces of one solid, or of one shell or loose set, have one number
  bool in_solid = false;
  std::string name, instance;
  int step_id = 0;
  std::optional<std::array<double, 3>> colour;
};

struct SourceModel {
  std::vector<SourceFace> faces;  ///< in the order of the file, instance after instance
  int groups = 0;
  int solids = 0, shells = 0;
  std::string declared_unit;
  double unit_scale_to_mm = 1;
  std::vector<std::string> warnings;
};

/// Reads and transfers with OpenCASCADE. Throws Error(bad_input) for what it refuses and for
/// files without faces; may crash on malformed ones (run_isolated is for that).
SourceModel collect_faces(const std::string& bytes, const StepText& text, const std::string& where,
                          const std::string& unit_override);

/// Millimetres in "mm", "cm", "m", "in" or "ft"; nothing for any other word.
std::optional<double> millimetres_in(const std::string& unit);

}  // namespace afptraj::step
