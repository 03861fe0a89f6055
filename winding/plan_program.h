#pragma once

#include <cstdint>
#include <vector>

#include "winding/program_writer.h"
#include "winding/wind_definition.h"

namespace afptraj {

/// What was written for one layer.
struct LayerReport {
  ProgramTotals totals;       ///< lines without the layer's own comment
  std::int64_t circuits = 0;  ///< helical
  double overlap = 0;         ///< helical: of neighbouring tows, as a share of the tow
};

struct ProgramReport {
  std::vector<LayerReport> layers;
  ProgramTotals totals;
  double feed_mm_per_min = 0;
  double time_s(const ProgramTotals& of) const { return of.total_length_mm() / feed_mm_per_min * 60; }
};

/// Writes the machine program of a definition (docs/winding.md says what is written and why).
/// REQUIRES: first_fault(definition, mode) finds none.
/// Throws Error(resource_limit) when there would be more than `longest_program` lines, Error(no_path) when
/// a position is beyond all numbers.
ProgramReport write_program(const WindDefinition& definition, WindMode mode, const ProgramWriter::Sink& sink);
inline constexpr double longest_program = 1e9;

}  // namespace afptraj
