#pragma once

#include <optional>
#include <string>

#include "geometry/error.h"
#include "winding/wind_definition.h"

namespace afptraj {

/// Why a layer cannot be wound.
struct LayerFault {
  std::size_t layer = 0;                  ///< from 1
  std::string message;                    ///< what is wrong; in native mode also what to do
  ErrorCode code = ErrorCode::bad_input;  ///< or no_path: the numbers are sound, but no such winding exists
};

/// The first fault of the first faulty layer, in the order: what follows a terminal layer, hoop on a cone,
/// the bounds of the angle, the cone and what a geodesic reaches on it, the pattern. In FiberPath mode the
/// rules and texts are FiberPath's.
std::optional<LayerFault> first_fault(const WindDefinition& definition, WindMode mode);

}  // namespace afptraj
