#pragma once

#include <array>
#include <vector>

#include "analysis/chord_index.h"
#include "analysis/course_ends.h"
#include "analysis/judge_ply.h"

/// The judgements over lines that are already indexed. Internal to this room; see judge_ply.h.
namespace afptraj {

using LineEnds = std::vector<std::array<LineEnd, 2>>;

Coverage measure_coverage(const GeodesicTracer& tracer, const std::vector<CourseLine>& lines, const ChordIndex& index,
                          const JudgeOptions& options);
SpacingError measure_spacing(const GeodesicTracer& tracer, const std::vector<CourseLine>& lines,
                             const ChordIndex& index, const LineEnds& ends, const JudgeOptions& options);
std::vector<CourseCrossing> find_crossings(const std::vector<CourseLine>& lines, const ChordIndex& index,
                                           double band_width_mm);

}  // namespace afptraj
