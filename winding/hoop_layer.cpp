#include <cmath>
#include <numbers>

#include "winding/frustum.h"
#include "winding/layers.h"

namespace afptraj {
namespace {

// Where the head leans to lay along the spiral. FiberPath takes the diameter for the circumference.
double lean_deg(const WindDefinition& definition, WindMode mode) {
  const double D = definition.mandrel.diameter_mm, w = definition.tow.width_mm;
  if (mode == WindMode::fiberpath) return 90 - degrees(std::atan(D / w));
  return degrees(std::atan(w / (std::numbers::pi * D)));
}

}  // namespace

void write_hoop(ProgramWriter& writer, const WindDefinition& definition, const HoopLayer& layer) {
  const double L = definition.mandrel.length_mm;
  const double turned = L / definition.tow.width_mm * 360;
  const double lean = lean_deg(definition, writer.mode());
  const double far_end = 180 + turned;
  const double far_turned = far_end + 180;
  const double near_end = far_turned + turned;
  const double near_turned = near_end + 180;

  writer.set_purpose(MovePurpose::reposition);
  writer.move_to({0, 180, 0});
  writer.move_to({0, 180, -lean});
  writer.set_purpose(MovePurpose::lay);
  writer.move_to({L, far_end, -lean});
  writer.set_purpose(MovePurpose::turn_around);
  writer.move_to({writer.position().carriage_mm, far_turned, 0});
  if (layer.terminal) return;
  writer.move_to({writer.position().carriage_mm, far_turned, lean});
  writer.set_purpose(MovePurpose::lay);
  writer.move_to({0, near_end, lean});
  writer.set_purpose(MovePurpose::turn_around);
  writer.move_to({writer.position().carriage_mm, near_turned, 0});
  write_zero(writer, near_turned);
}

}  // namespace afptraj
