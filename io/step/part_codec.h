#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/step/read_step.h"

namespace afptraj::step {

/// A surface as data: what the importer makes and sends, before `Surface` prepares it.
struct PlainSurface {
  SurfaceKind kind = SurfaceKind::plane;
  Frame frame;
  double radius = 0, second = 0;  ///< cone: second is the half angle; torus: the minor radius
  BSplineSurface spline;
};

struct PlainFace {
  PlainSurface surface;
  bool reversed = false;
  std::vector<Loop> loops;
  std::string name, instance;
  int step_id = 0;
  int body = -1;  ///< the solid it belongs to; -1 for shells and loose faces
  std::optional<std::array<double, 3>> colour;
};

/// A StepModel without `part`, and the part as data.
struct PlainModel {
  StepModel head;
  std::vector<PlainFace> faces;
  std::vector<Edge> edges;
};

/// Writes a model as bytes for the same program on the same machine, and reads it back. Throws
/// Error(internal) when the bytes do not hold together.
std::string encode(const PlainModel& model);
PlainModel decode(std::string_view bytes);

/// The surface of the data. Throws std::invalid_argument when it does not fit together.
Surface make_surface(PlainSurface plain);

/// Prepares the surfaces. Throws Error(bad_input) with the entity when one does not fit together.
StepModel to_step_model(PlainModel model, const std::string& where);

}  // namespace afptraj::step
