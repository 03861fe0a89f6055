#include "io/step/import.h"

#include <BRepBndLib.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <Bnd_Box.hxx>
#include <cmath>
#include <cstdio>

#include "io/step/collect.h"
#include "io/step/convert_faces.h"
#include "io/step/occt.h"

namespace afptraj::step {
namespace {

/// Coordinates beyond 1000 km are rubbish in the file, not a part.
constexpr double farthest_mm = 1e9;
/// A skin for fibre placement is between a hand and a wind turbine blade in size.
constexpr double small_mm = 200, large_mm = 200e3;

std::string short_number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", x);
  return text;
}

void judge_size(const SourceModel& source, const std::string& where, PlainModel& model,
                const StepReadOptions& options) {
  Bnd_Box box;
  for (const SourceFace& face : source.faces)
    BRepBndLib::AddOptimal(face.face, box, Standard_False, Standard_False);
  if (box.IsVoid() || box.IsOpen())
    throw Error(ErrorCode::bad_input, where, "has faces without end; trim the surfaces and export it again");
  double lo[3], hi[3];
  box.Get(lo[0], lo[1], lo[2], hi[0], hi[1], hi[2]);
  double size = 0;
  for (int k = 0; k < 3; ++k) {
    if (!std::isfinite(lo[k]) || !std::isfinite(hi[k]) || std::abs(lo[k]) > farthest_mm ||
        std::abs(hi[k]) > farthest_mm) {
      throw Error(ErrorCode::bad_input, where,
                  "has coordinates beyond 1000 km or not a number; the file is damaged, export it again");
    }
    size = std::max(size, hi[k] - lo[k]);
  }
  if (!(size > 1e-4))
    throw Error(ErrorCode::bad_input, where,
                "has no extent: all points are equal; the file is damaged, export it again");
  if (!options.unit_override.empty()) return;
  const std::string is = "the part is " + short_number(size) + " mm long, ";
  const std::string declared =
      source.declared_unit.empty() ? "assumed mm" : "declared " + source.declared_unit;
  if (size < small_mm) {
    model.head.warnings.push_back(is + "small for fibre placement (" + declared +
                                  "); if its numbers are metres give --unit m, inches --unit in");
  } else if (size > large_mm) {
    model.head.warnings.push_back(is + "large for fibre placement (" + declared +
                                  "); if its numbers are millimetres give --unit mm");
  }
}

/// What OpenCASCADE's own check finds wrong with the faces as read.
void check_validity(const SourceModel& source, PlainModel& model) {
  int faults = 0;
  const SourceFace* first = nullptr;
  for (const SourceFace& face : source.faces) {
    if (BRepCheck_Analyzer(face.face).IsValid()) continue;
    if (faults++ == 0) first = &face;
  }
  if (faults == 0) return;
  model.head.warnings.push_back(std::to_string(faults) + " of " + std::to_string(source.faces.size()) +
                                " faces fail OpenCASCADE's validity check (first: #" +
                                std::to_string(first->step_id) +
                                "): their boundaries may not be what was meant");
}

}  // namespace

PlainModel import_part(const std::string& bytes, const StepText& text, const std::string& where,
                       const StepReadOptions& options) {
  const QuietOcct quiet;
  return occt_guard(ErrorCode::bad_input, where, "reading", [&] {
    const SourceModel source = collect_faces(bytes, text, where, options.unit_override);
    PlainModel model;
    model.head.schema = text.schema;
    model.head.declared_unit = source.declared_unit;
    model.head.unit_scale_to_mm = source.unit_scale_to_mm;
    model.head.solids = source.solids;
    model.head.shells = source.shells;
    model.head.warnings = source.warnings;
    judge_size(source, where, model, options);
    check_validity(source, model);
    convert_faces(source.faces, model);
    if (model.faces.empty())
      throw Error(ErrorCode::bad_input, where,
                  "has no face that can be used (" + model.head.warnings.back() + "); export it again");
    return model;
  });
}

}  // namespace afptraj::step
