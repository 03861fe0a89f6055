#include "boundary/plan_ply.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include <tbb/parallel_for.h>

#include "boundary/clip.h"
#include "boundary/lay_tows.h"
#include "geometry/error.h"
#include "trajectory/feature_sections.h"
#include "trajectory/parallels.h"
#include "trajectory/path_fit.h"

namespace afptraj {
namespace {

class Stopwatch {
 public:
  explicit Stopwatch(std::vector<StageTime>& times) : times_(times), last_(now()) {}
  void stage(const char* name) {
    const auto t = now();
    times_.push_back({name, std::chrono::duration<double>(t - last_).count()});
    last_ = t;
  }

 private:
  using Clock = std::chrono::steady_clock;
  static Clock::time_point now() { return Clock::now(); }
  std::vector<StageTime>& times_;
  Clock::time_point last_;
};

std::string text(const char* format, double a, double b = 0, double c = 0) {
  char out[240];
  std::snprintf(out, sizeof out, format, a, b, c);
  return out;
}

/// The start point, moved off the boundary when it lies on it.
SurfacePoint start_point(const Skin& skin, const Vec3& p) {
  const auto nearest = skin.closest_point().closest(p);
  SurfacePoint at = nearest->at;
  if (!nearest->on_boundary) return at;
  const TrimRegion& trim = skin.trim(at.face);
  const Uv size = trim.box_max() - trim.box_min();
  for (double reach : {1e-6, 1e-4, 1e-2})
    for (int i = 0; i < 16; ++i) {
      const double a = 2 * pi * i / 16;
      const Uv uv = at.uv + reach * size.cwiseProduct(Uv(std::cos(a), std::sin(a)));
      if (trim.contains(uv)) return {at.face, uv};
    }
  return at;
}

void report_reference(PlyReport& report, const SteppedPath& stepped, const PathFit& fit) {
  report.reference_points = stepped.points.size();
  report.fit_rms_mm = fit.rms_mm;
  report.fit_max_mm = fit.max_mm;
  report.reference_closed_over_mm = stepped.closed_over_mm;
  report.range_doubled_share =
      stepped.steps > 0 ? static_cast<double>(stepped.doubled) / static_cast<double>(stepped.steps) : 0;
  for (int i = 0; i < 2; ++i) {
    report.reference_end[i] = to_string(stepped.end[i]);
    if (stepped.end[i] == WalkEnd::singular_field) {
      const Vec3& p = (i == 0 ? stepped.points.front() : stepped.points.back()).position;
      report.warnings.push_back(text("the asked directions cancel or stand on the skin at (%.6g, %.6g, %.6g); the reference path ends there "
                                     "and goes on as a geodesic",
                                     p.x(), p.y(), p.z()));
    }
  }
  if (stepped.doubled > 0)
    report.warnings.push_back(text("%.3g %% of the steps had no ply point in range; the range was doubled there",
                                   100 * report.range_doubled_share));
}

void report_counts(PlyReport& report, const std::vector<Course>& courses) {
  for (const Course& course : courses) {
    report.total_length_mm += course.length_mm();
    report.courses_left = std::max(report.courses_left, course.number);
    report.courses_right = std::max(report.courses_right, -course.number);
    if (course.number == 0) report.reference_length_mm = course.length_mm();
  }
  if (report.courses_left == report.N1 && report.courses_right == report.N2) return;
  const bool more = report.courses_left + report.courses_right > report.N1 + report.N2;
  report.courses_reason =
      more ? "parallels go on until no part of the skin lies ahead of them; the sections are measured only across the "
             "reference path and in planes"
           : "the plane sections are longer than the geodesic distances, or fronts met before the last band";
}

void judge_limits(PlyReport& report, const std::vector<Course>& courses, const PlanOptions& options) {
  double kg = 0;
  for (const Course& course : courses)
    for (const CourseSegment& segment : course.segments)
      for (const CourseSample& sample : segment.samples) {
        kg = std::max(kg, std::abs(sample.kg_per_mm));
        report.max_deviation_rad = std::max(report.max_deviation_rad, std::abs(sample.deviation_rad));
      }
  // A straight course has no steering radius: report a radius no machine can tell from it.
  report.min_steering_radius_mm = 1 / std::max(kg, 1e-12);
  if (report.min_steering_radius_mm < options.min_steering_radius_mm)
    report.violations.push_back(text("steering radius %.6g mm is below the limit of %.6g mm",
                                     report.min_steering_radius_mm, options.min_steering_radius_mm));
  if (report.max_deviation_rad > options.angle_limit_rad)
    report.violations.push_back(text("fibre angle deviates by %.4g degrees, the limit is %.4g degrees",
                                     report.max_deviation_rad * 180 / pi, options.angle_limit_rad * 180 / pi));
}

/// Cuts the tows and judges how tight they turn.
void add_tows(const Skin& skin, const Parallels& parallels, const PlanOptions& options, Ply& ply) {
  TowLineOptions lines;
  lines.tow_width_mm = options.tow_width_mm;
  lines.tows = options.tows;
  lines.coverage_rule = options.cut.coverage_rule;
  lines.station_mm = std::min(16.0, options.band_width_mm());
  lines.beyond_mm = options.cut.short_tows == ShortTows::drop ? 0 : options.cut.min_cut_length_mm;
  LaidTows tows = lay_tows(skin, parallels.levels, lines, options.cut, options.keep_tow_lines);
  ply.bands = std::move(tows.bands);
  ply.tows = std::move(tows.pieces);
  ply.report.tows = tows.report;
  if (ply.tows.empty() && tows.report.dropped > 0)
    throw Error(ErrorCode::no_path, "ply '" + ply.name + "'",
                text("every tow is shorter than min_cut_length %.6g mm; lower it, or let short tows be extended",
                     options.cut.min_cut_length_mm));
  const TightestTurn& turn = tows.report.tightest;
  if (turn.radius_mm < options.min_steering_radius_mm)
    ply.report.violations.push_back("tow " + std::to_string(turn.tow) + " of course " + std::to_string(turn.course) +
                                    text(" turns with a radius of %.6g mm", turn.radius_mm) +
                                    text(" at (%.6g, %.6g, %.6g)", turn.where.x(), turn.where.y(), turn.where.z()) +
                                    text(", the limit is %.6g mm", options.min_steering_radius_mm));
}

ParallelOptions parallel_options(const Skin& skin, const PlanOptions& options) {
  ParallelOptions out;
  const double W = options.band_width_mm();
  out.front.spacing_mm = W;
  out.front.sample_mm = options.sample_mm > 0 ? options.sample_mm : W / 12;
  out.front.extension_step_mm = options.extension_step_mm;
  out.front.max_extension_mm = 10 * skin.diagonal();
  out.geodesic.tolerance_mm = 1e-10;
  out.geodesic.outside_limit_mm = skin.diagonal();
  // Beside other faces the continuation of one face soon parts from that of the next. A face alone
  // goes on: extensions by half a band, rays from there far enough to come back. Rays walk by whole bands, so
  // that the limit is none: rounding would decide which of them end.
  const bool alone = skin.faces().size() == 1;
  out.front.extension_margin_mm = std::max(alone ? W / 2 : 0.0, 2 * out.front.sample_mm);
  out.geodesic.margin_mm = alone ? 2.5 * W : out.front.extension_margin_mm;
  out.max_levels = options.max_courses;
  return out;
}

/// Samples of the stretches of each level that `clip` keeps.
template <typename Clip>
std::vector<Course> clip_courses(const Skin& skin, const Parallels& parallels, const DirectionField& field, Clip clip) {
  std::vector<Course> courses(parallels.levels.size());
  tbb::parallel_for(std::size_t{0}, courses.size(), [&](std::size_t i) {
    courses[i].number = parallels.levels[i].number;
    for (const SurfaceCurve& curve : parallels.levels[i].curves)
      for (const SurfaceCurve& stretch : clip(curve)) courses[i].segments.push_back(sample_segment(skin, stretch, field));
  });
  std::erase_if(courses, [](const Course& course) { return course.segments.empty(); });
  return courses;
}

/// Off-skin stretches farther from the skin than a band reach nothing: drop them.
void keep_near_skin(const Skin& skin, double reach_mm, std::vector<Course>& courses) {
  tbb::parallel_for(std::size_t{0}, courses.size(), [&](std::size_t i) {
    std::vector<CourseSegment> kept;
    for (CourseSegment& segment : courses[i].segments) {
      CourseSegment run;
      for (const CourseSample& sample : segment.samples) {
        if (skin.closest_point().closest(sample.position, reach_mm)) {
          run.samples.push_back(sample);
          continue;
        }
        if (run.samples.size() > 1) kept.push_back(std::move(run));
        run = {};
      }
      if (run.samples.size() > 1) kept.push_back(std::move(run));
    }
    courses[i].segments = std::move(kept);
  });
  std::erase_if(courses, [](const Course& course) { return course.segments.empty(); });
}

}  // namespace

bool TowCoverage::holds() const {
  return std::abs(skin_residual_mm2) <= error_mm2 && std::abs(laid_residual_mm2) <= error_mm2 + laid_error_mm2;
}

double Course::length_mm() const {
  double sum = 0;
  for (const CourseSegment& segment : segments) sum += segment.length_mm();
  return sum;
}

Ply plan_ply(const Skin& skin, const PlyOrientation& orientation, const PlanOptions& options, const Progress& progress) {
  Ply ply;
  ply.name = orientation.name;
  PlyReport& report = ply.report;
  report.band_width_mm = options.band_width_mm();
  report.skin_area_mm2 = skin.area();
  const auto tell = [&](const char* stage, double done) {
    if (progress && !progress(stage, done)) throw Interrupted{};
  };
  Stopwatch watch(report.times);
  if (orientation.points.empty())
    throw Error(ErrorCode::bad_input, "ply '" + orientation.name + "'", "has no orientation points");

  tell("direction field", 0);
  const double range = options.range_mm > 0 ? options.range_mm : report.band_width_mm;
  const DirectionField field =
      make_direction_field(skin, orientation, range, options.point_distance_limit_mm, options.plies_name);
  watch.stage("direction field");

  tell("reference path", 0);
  StepOptions stepping;
  stepping.step_mm = options.step_mm;
  stepping.chord_error_mm = options.chord_error_mm;
  stepping.band_width_mm = report.band_width_mm;
  stepping.max_length_mm = 1000 * skin.diagonal();
  const SurfacePoint start = start_point(skin, orientation.points[orientation.start].position);
  const SteppedPath stepped = step_reference_path(skin, field, start, stepping);
  if (stepped.points.size() < 3) {
    const Vec3 p = skin.point(start);
    throw Error(ErrorCode::no_path, "ply '" + orientation.name + "'",
                text("no path can start at (%.6g, %.6g, %.6g)", p.x(), p.y(), p.z()) + " (" +
                    to_string(stepped.end[1]) + "); choose another start point");
  }
  watch.stage("reference path");

  FitOptions fitting;
  fitting.fairness = options.fairness;
  fitting.length_mm = report.band_width_mm;
  fitting.knot_spacing_mm = std::max(4 * options.step_mm, report.band_width_mm / 8);
  const PathFit fit = fit_path(skin, stepped, fitting);
  report_reference(report, stepped, fit);
  watch.stage("fit");

  tell("feature sections", 0);
  const FeatureSections sections = feature_sections(skin, *fit.path, report.band_width_mm, report.band_width_mm);
  report.L1_mm = sections.L1_mm;
  report.L2_mm = sections.L2_mm;
  report.N1 = sections.N1;
  report.N2 = sections.N2;
  watch.stage("feature sections");

  const double expected = std::max({1, sections.N1, sections.N2}) + 2;
  bool stopped = false;
  const Parallels parallels =
      geodesic_parallels(skin, fit.path, parallel_options(skin, options), [&](int level) {
        stopped = progress && !progress("parallels", std::min(1.0, level / expected));
        return !stopped;
      });
  if (stopped) throw Interrupted{};
  if (parallels.reached_max_levels)
    report.warnings.push_back(text("stopped after %.0f courses on each side", options.max_courses));
  watch.stage("parallels");

  tell("boundary", 0);
  ply.courses = clip_courses(skin, parallels, field, [&](const SurfaceCurve& c) { return clip_to_skin(skin, c); });
  ply.off_skin = clip_courses(skin, parallels, field, [&](const SurfaceCurve& c) { return off_skin(skin, c); });
  keep_near_skin(skin, report.band_width_mm / 2, ply.off_skin);
  if (ply.courses.empty())
    throw Error(ErrorCode::no_path, "ply '" + orientation.name + "'", "no course touches the skin");
  report_counts(report, ply.courses);
  judge_limits(report, ply.courses, options);
  watch.stage("boundary");
  if (options.cut_tows) {
    tell("tows", 0);
    add_tows(skin, parallels, options, ply);
    watch.stage("tows");
  }
  return ply;
}

}  // namespace afptraj
