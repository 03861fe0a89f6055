#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "cli/arguments.h"
#include "io/vessel_toml.h"
#include "winding/skin_mandrel.h"

namespace afptraj::cli {

/// A mandrel and what is known of where it came from, for machines and for people.
struct MandrelFile {
  Meridian meridian;
  nlohmann::ordered_json source = nlohmann::ordered_json::object();
  std::string text;
};

/// The mandrel that the faces of a part make: those named in `list`, or all that are not plane.
SkinMandrel read_part_mandrel(const std::string& path, const std::string& list);

/// From a meridian (.csv), the mandrel of a `.wind` or vessel file (.toml), or a part (anything else: STEP).
MandrelFile read_mandrel(const WindArguments& arguments);
MandrelFile read_mandrel(const VesselFile& vessel);

}  // namespace afptraj::cli
