#include "analysis/judge_ply.h"

#include <chrono>
#include <cmath>
#include <cstdio>

#include "analysis/geodesic_way.h"
#include "analysis/judge_lines.h"
#include "analysis/tow_coverage.h"

namespace afptraj {
namespace {

constexpr double reported_off_skin_mm = 1e-3;  // a smaller error there is not worth a warning

/// What every judgement needs of a ply.
struct Judged {
  Judged(const Skin& skin, const Ply& ply, const JudgeOptions& options)
      : tracer(skin, judge_geodesics(skin, options.band_width_mm, options.tolerance_mm)),
        lines(course_lines(skin, ply)),
        index(lines) {}
  Judged(const Judged&) = delete;
  Judged& operator=(const Judged&) = delete;
  GeodesicTracer tracer;
  std::vector<CourseLine> lines;
  ChordIndex index;
};

/// Whether the reference has come alongside itself at this end: a spiral has nowhere to go on to.
bool beside_itself(const std::vector<CourseLine>& lines, std::size_t own, bool last, double band_width_mm) {
  const CourseLine& line = lines[own];
  if (line.course != 0) return false;
  const Vec3& p = last ? line.points.back() : line.points.front();
  const double t = last ? line.t.back() : line.t.front();
  for (std::size_t l = 0; l < lines.size(); ++l) {
    if (lines[l].course != 0 || lines[l].off_skin) continue;
    for (std::size_t i = 0; i < lines[l].points.size(); ++i)
      if ((lines[l].points[i] - p).norm() < band_width_mm && (l != own || std::abs(lines[l].t[i] - t) > 3 * band_width_mm))
        return true;
  }
  return false;
}

std::vector<LooseEnd> loose_ends(const std::vector<CourseLine>& lines, const LineEnds& ends, double band_width_mm) {
  std::vector<LooseEnd> out;
  for (std::size_t l = 0; l < lines.size(); ++l)
    for (const bool last : {false, true})
      if (ends[l][last ? 1 : 0] == LineEnd::loose && !beside_itself(lines, l, last, band_width_mm))
        out.push_back({lines[l].course, last ? lines[l].points.back() : lines[l].points.front()});
  return out;
}

std::string at(const Vec3& p) {
  char out[96];
  std::snprintf(out, sizeof out, "(%.6g, %.6g, %.6g)", p.x(), p.y(), p.z());
  return out;
}

std::string number(double x) {
  char out[32];
  std::snprintf(out, sizeof out, "%.3g", x);
  return out;
}

std::string times(std::size_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

void tell(PlyReport& report) {
  if (!report.crossings.empty()) {
    const CourseCrossing& first = report.crossings.front();
    const std::string whose = first.course == first.other
                                  ? "course " + std::to_string(first.course) + " with itself"
                                  : "courses " + std::to_string(first.course) + " and " + std::to_string(first.other);
    report.violations.push_back("centre lines cross at " + times(report.crossings.size(), "place", "places") + ", first " +
                                whose + " at " + at(first.where));
  }
  if (!report.loose_ends.empty()) {
    const LooseEnd& first = report.loose_ends.front();
    report.violations.push_back(times(report.loose_ends.size(), "course end lies", "course ends lie") +
                                " inside the skin and meets no other, first of course " + std::to_string(first.course) +
                                " at " + at(first.where));
  }
  if (report.spacing.off_skin_worst_mm > reported_off_skin_mm)
    report.warnings.push_back("the spacing is off by up to " + number(report.spacing.off_skin_worst_mm) + " mm at " +
                              times(report.spacing.off_skin, "place", "places") +
                              " where the way to the neighbour runs over missing material");
  if (report.spacing.unresolved > 0)
    report.warnings.push_back("the spacing could not be measured at " +
                              times(report.spacing.unresolved, "place", "places") + ", first at " +
                              at(report.spacing.first_unresolved));
}

void tell_coverage(PlyReport& report) {
  const TowCoverage& c = report.tow_coverage;
  if (c.holds()) return;
  report.warnings.push_back("gaps and overlaps do not add up: the polygons miss " + number(c.skin_residual_mm2) +
                            " mm2 of the skin and " + number(c.laid_residual_mm2) + " mm2 of the tows (bounds " +
                            number(c.error_mm2) + " and " + number(c.error_mm2 + c.laid_error_mm2) +
                            "); tows fold there, or faces lie between the edges of one tow");
}

}  // namespace

Coverage measure_coverage(const Skin& skin, const Ply& ply, const JudgeOptions& options) {
  const Judged judged(skin, ply, options);
  return measure_coverage(judged.tracer, judged.lines, judged.index, options);
}

SpacingError measure_spacing(const Skin& skin, const Ply& ply, const JudgeOptions& options) {
  const Judged judged(skin, ply, options);
  return measure_spacing(judged.tracer, judged.lines, judged.index, line_ends(judged.tracer, judged.lines), options);
}

std::vector<CourseCrossing> find_crossings(const Skin& skin, const Ply& ply, const JudgeOptions& options) {
  const Judged judged(skin, ply, options);
  return find_crossings(judged.lines, judged.index, options.band_width_mm);
}

std::vector<LooseEnd> find_loose_ends(const Skin& skin, const Ply& ply, const JudgeOptions& options) {
  const Judged judged(skin, ply, options);
  return loose_ends(judged.lines, line_ends(judged.tracer, judged.lines), options.band_width_mm);
}

void judge_ply(const Skin& skin, const JudgeOptions& options, Ply& ply) {
  PlyReport& report = ply.report;
  auto last = std::chrono::steady_clock::now();
  const auto stage = [&](const char* name) {
    const auto now = std::chrono::steady_clock::now();
    report.times.push_back({name, std::chrono::duration<double>(now - last).count()});
    last = now;
  };
  const Judged judged(skin, ply, options);
  const Coverage coverage = measure_coverage(judged.tracer, judged.lines, judged.index, options);
  report.covered_share = coverage.covered_share;
  report.reached_share = coverage.reached_share;
  report.uncovered = coverage.uncovered;
  stage("coverage");
  const LineEnds ends = line_ends(judged.tracer, judged.lines);
  report.spacing = measure_spacing(judged.tracer, judged.lines, judged.index, ends, options);
  report.spacing_error_mm = report.spacing.worst_mm;
  stage("spacing");
  report.crossings = find_crossings(judged.lines, judged.index, options.band_width_mm);
  report.loose_ends = loose_ends(judged.lines, ends, options.band_width_mm);
  tell(report);
  stage("crossings and ends");
  if (!options.tow_coverage) return;
  report.tow_coverage = measure_tow_coverage(skin, ply);
  tell_coverage(report);
  stage("tow coverage");
}

}  // namespace afptraj
