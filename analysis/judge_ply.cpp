#include "analysis/judge_ply.h"

#include <chrono>

namespace afptraj {

void judge_ply(const Skin& skin, const JudgeOptions& options, Ply& ply) {
  const auto start = std::chrono::steady_clock::now();
  const Coverage coverage = measure_coverage(skin, ply, options);
  ply.report.covered_share = coverage.covered_share;
  ply.report.reached_share = coverage.reached_share;
  ply.report.uncovered = coverage.uncovered;
  const auto middle = std::chrono::steady_clock::now();
  ply.report.spacing_error_mm = measure_spacing(skin, ply, options).worst_mm;
  const auto end = std::chrono::steady_clock::now();
  ply.report.times.push_back({"coverage", std::chrono::duration<double>(middle - start).count()});
  ply.report.times.push_back({"spacing", std::chrono::duration<double>(end - middle).count()});
}

}  // namespace afptraj
