#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "boundary/ply.h"
#include "io/job_toml.h"

namespace afptraj::cli {

/// Limits of the job that the ply does not hold, one line each.
std::vector<std::string> limit_violations(const Ply& ply, const Job& job);

/// A ply's result for people: courses, coverage, spacing, steering, deviation.
std::string ply_table(const Ply& ply, const Job& job, const std::vector<std::string>& violations);

}  // namespace afptraj::cli
