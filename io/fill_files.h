#pragma once

#include <string>
#include <utility>
#include <vector>

#include "analysis/judge_fill.h"
#include "fill/fill_path.h"
#include "fill/slice.h"
#include "io/summary_json.h"

namespace afptraj {

/// What a fill's summary records beside its paths.
struct FillRecord {
  std::vector<std::pair<std::string, std::string>> versions;  ///< program or library, version
  std::vector<InputRecord> inputs;
  std::vector<std::pair<std::string, std::string>> options;  ///< name, value as text; numbers become numbers
  std::vector<std::string> warnings;
  std::vector<std::string> files;  ///< that are written
  std::vector<StageTime> times;
  std::string started;  ///< wall clock, ISO 8601
};

std::string to_string(PathKind kind);

/// paths.csv: path,closed,i,x,y,z; paths and points are counted from 0, the first point of a closed path is
/// not repeated.
std::string fill_paths_csv(const Fill& fill, double z_mm);

/// The content of summary.json (docs/fill.md); what may differ between two runs stands in "times".
std::string fill_summary_json(const FillRecord& record, const Slice& slice, const Fill& fill,
                              const FillReport& report);

/// A picture: the slice, the beads at their width, the centre lines; y upwards, one unit is a millimetre.
std::string fill_svg(const Slice& slice, const Fill& fill, double width_mm);

}  // namespace afptraj
