#pragma once

#include <string>
#include <utility>
#include <vector>

#include "boundary/plan_ply.h"

namespace afptraj {

/// Which faces of the part to lay on. Face numbers are those of `afptraj inspect`, from 1.
/// At most one of the first three is given; none means the tangent-connected group of faces
/// nearest to the ply points.
struct FaceChoice {
  std::vector<int> numbers;       ///< exactly these
  std::string name;               ///< all faces of this name
  std::vector<int> tangent_from;  ///< these and what is reached over smooth edges
  double tangent_angle_rad = 5 * pi / 180;
};

/// Everything a run can be told beside its two input files. Each member is a key of job.toml and,
/// where the command line has one, a flag; docs/files.md lists them.
struct Job {
  PlanOptions plan;
  FaceChoice faces;
  std::string unit;                    ///< mm, cm, m, in, ft; empty: what the file declares
  double sew_tolerance_mm = -1;        ///< negative: automatic, see StepReadOptions
  double min_coverage = 0.999;         ///< limit: share of the skin within W/2 of a centre line
  double max_spacing_error_mm = 1e-3;  ///< limit: E_k
  std::string short_tows = "symmetric";  ///< plan.cut.short_tows, as a word; see plan_options()
  std::string output_directory;        ///< empty: <surface>-afptraj
};

/// What the planner is told.
PlanOptions plan_options(const Job& job);

/// Reads job.toml over the defaults. Throws Error(usage, "file:line:column", ...) for what is not
/// TOML, unknown keys (with the nearest known), wrong types and values out of range.
Job read_job(const std::string& path);

/// Sets one key ("planning.step") from text, as a flag of the command line does; `where` names the flag.
/// Throws Error(usage, where, ...).
void set_job_key(Job& job, const std::string& key, const std::string& text, const std::string& where);

/// Throws Error(usage) where keys contradict each other.
void check_job(const Job& job, const std::string& where);

/// "3,5-9" as numbers, sorted and without repeats. Throws Error(usage, where, ...).
std::vector<int> parse_face_list(const std::string& text, const std::string& where);

/// A key of job.toml as documentation shows it.
struct JobKeyInfo {
  std::string name;   ///< "planning.step"
  std::string range;  ///< "0.01 ... 100", or the words allowed
  std::string unit;   ///< "mm", may be empty
  std::string meaning;
};
std::vector<JobKeyInfo> job_keys();

/// Every key with its value, in the order of job_keys(), as the summary records it.
std::vector<std::pair<std::string, std::string>> job_values(const Job& job);

}  // namespace afptraj
