#pragma once

#include <TopoDS_Face.hxx>
#include <string>
#include <vector>

namespace oracle {

/// A face as OCCT reads it, in mm. `number` counts from 1 in the order of TopExp_Explorer;
/// `step_id` is its entity number in the file, 0 when unknown.
struct StepFace {
  int number = 0;
  int step_id = 0;
  TopoDS_Face face;
};

/// Reads all faces of a STEP file; `unit` (mm, cm, m, in, ft; empty: as declared) replaces the unit the
/// file declares. Throws std::runtime_error with a reason.
std::vector<StepFace> read_step_faces(const std::string& path, const std::string& unit = {});

/// The faces named by `list`: "all", or numbers, ranges and entity numbers: "1,4-6,#661".
std::vector<StepFace> choose_faces(const std::vector<StepFace>& faces, const std::string& list);

}  // namespace oracle
