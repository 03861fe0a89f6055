#pragma once

// Private to io/step: what the importer's process does.

#include <string>

#include "io/step/part_codec.h"
#include "io/step/step_text.h"

namespace afptraj::step {

/// From the bytes of a checked STEP file to a plain model in mm: collect, convert, judge the size.
/// Throws Error; may crash with OpenCASCADE.
PlainModel import_part(const std::string& bytes, const StepText& text, const std::string& where,
                       const StepReadOptions& options);

}  // namespace afptraj::step
