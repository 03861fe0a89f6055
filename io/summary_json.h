#pragma once

#include <string>
#include <utility>
#include <vector>

#include "boundary/ply.h"
#include "geometry/skin.h"
#include "io/job_toml.h"
#include "io/step/read_step.h"

namespace afptraj {

/// An input file as the summary records it.
struct InputRecord {
  std::string role;  ///< "part", "plies", "job"
  std::string path;  ///< as given
  std::string sha256;
};

/// What a run knows beside its plies.
struct RunRecord {
  std::vector<std::pair<std::string, std::string>> versions;  ///< program or library, version
  std::vector<InputRecord> inputs;
  Job job;
  std::string faces_reason;  ///< how the faces were chosen
  std::vector<std::string> warnings;
  std::vector<std::pair<std::string, std::vector<std::string>>> violations;  ///< ply, limits that do not hold
  std::vector<StageTime> times;
  int threads = 0;
  double peak_memory_mb = 0;
  std::string started;  ///< wall clock, ISO 8601
};

/// The content of summary.json (docs/files.md says what each member means). Everything that may
/// differ between two runs of the same input - wall time, clock, threads - stands in the one
/// member "times". Throws Error(internal) for a NaN.
std::string summary_json(const RunRecord& run, const StepModel& model, const Skin& skin,
                         const std::vector<Ply>& plies);

}  // namespace afptraj
