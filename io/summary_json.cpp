#include "io/summary_json.h"

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "io/coverage_csv.h"
#include "io/number_text.h"

namespace afptraj {
namespace {

using Json = nlohmann::ordered_json;

// Numbers as text files have them: 1e-9, and no NaN.
Json number(double x) { return rounded_number(x); }
Json degrees(double angle_rad) { return rounded_number(angle_rad * 180 / pi, 6); }
// A quantity that is judged by its order of magnitude, such as an error.
Json small_number(double x) { return rounded_number(x, 12); }

Json vector(const Vec3& v) { return Json::array({number(v.x()), number(v.y()), number(v.z())}); }

Json versions(const RunRecord& run) {
  Json out = Json::object();
  for (const auto& [name, version] : run.versions) out[name] = version;
  return out;
}

Json inputs(const RunRecord& run) {
  Json out = Json::object();
  for (const InputRecord& input : run.inputs)
    out[input.role] = {{"path", input.path}, {"sha256", input.sha256}};
  return out;
}

// Numbers as numbers: the text of a value is one already where it is one.
Json options(const Job& job) {
  Json out = Json::object();
  for (const auto& [name, text] : job_values(job)) {
    const std::size_t dot = name.find('.');
    Json& slot = out[name.substr(0, dot)][name.substr(dot + 1)];
    const auto value = parse_number(text);
    const bool list = name == "faces.list" || name == "faces.tangent_from" || name == "faces.name";
    if (value && !list && text.find_first_of(".e") == std::string::npos) {
      slot = static_cast<std::int64_t>(*value);
    } else if (value && !list) {
      slot = *value;
    } else if (text.empty()) {
      slot = nullptr;
    } else {
      slot = text;
    }
  }
  return out;
}

Json part(const StepModel& model) {
  return {{"schema", model.schema},
          {"declared_unit", model.declared_unit},
          {"unit_scale_to_mm", model.unit_scale_to_mm},
          {"solids", model.solids},
          {"shells", model.shells},
          {"faces", model.part.faces.size()},
          {"sew_tolerance_mm", number(model.sew_tolerance_mm)},
          {"sewn_edges", model.sewn_edges},
          {"greatest_sewn_gap_mm", small_number(model.greatest_sewn_gap_mm)}};
}

Json skin_facts(const RunRecord& run, const Skin& skin) {
  Json faces = Json::array();
  for (const int index : skin.faces()) {
    const Face& face = skin.face(index);
    Json entry = {{"face", index + 1}};
    if (face.step_id > 0) entry["step_id"] = face.step_id;
    if (!face.name.empty()) entry["name"] = face.name;
    if (!face.instance.empty()) entry["instance"] = face.instance;
    faces.push_back(entry);
  }
  return {{"chosen", run.faces_reason},
          {"faces", faces},
          {"area_mm2", number(skin.area())},
          {"box_min", vector(skin.box_min())},
          {"box_max", vector(skin.box_max())}};
}

Json reference(const PlyReport& report) {
  return {{"length_mm", number(report.reference_length_mm)},
          {"points", report.reference_points},
          {"fit_rms_mm", small_number(report.fit_rms_mm)},
          {"fit_max_mm", small_number(report.fit_max_mm)},
          {"range_doubled_share", number(report.range_doubled_share)},
          {"closed_over_mm", small_number(report.reference_closed_over_mm)},
          {"end_backward", report.reference_end[0]},
          {"end_forward", report.reference_end[1]}};
}

Json courses(const Ply& ply) {
  Json out = Json::array();
  for (const Course& course : ply.courses) {
    Json segments = Json::array();
    for (const CourseSegment& segment : course.segments) {
      segments.push_back({{"length_mm", number(segment.length_mm())},
                          {"points", segment.samples.size()},
                          {"closed", segment.closed}});
    }
    out.push_back(
        {{"course", course.number}, {"length_mm", number(course.length_mm())}, {"segments", segments}});
  }
  return out;
}

Json uncovered(const PlyReport& report) {
  Json out = Json::array();
  for (const UncoveredSpot& spot : report.uncovered) {
    out.push_back({{"where", vector(spot.where)},
                   {"area_mm2", number(spot.area_mm2)},
                   {"distance_mm", number(spot.distance_mm)},
                   {"reason", spot.reason}});
  }
  return out;
}

Json spacing(const SpacingError& e) {
  return {{"worst_mm", small_number(e.worst_mm)},
          {"course", e.worst_course},
          {"where", e.worst_mm > 0 ? vector(e.where) : Json()},
          {"measured", e.measured},
          {"beyond_end", e.beyond_end},
          {"unresolved", e.unresolved},
          {"first_unresolved", e.unresolved > 0 ? vector(e.first_unresolved) : Json()},
          {"off_skin", e.off_skin},
          {"off_skin_worst_mm", small_number(e.off_skin_worst_mm)}};
}

Json crossings(const PlyReport& report) {
  const auto self = std::count_if(report.crossings.begin(), report.crossings.end(),
                                  [](const CourseCrossing& c) { return c.course == c.other; });
  Json first;
  if (!report.crossings.empty()) {
    const CourseCrossing& c = report.crossings.front();
    first = {{"course", c.course}, {"other", c.other}, {"where", vector(c.where)}};
  }
  return {{"self", self}, {"mutual", static_cast<std::ptrdiff_t>(report.crossings.size()) - self}, {"first", first}};
}

Json loose_ends(const PlyReport& report) {
  Json first;
  if (!report.loose_ends.empty())
    first = {{"course", report.loose_ends.front().course}, {"where", vector(report.loose_ends.front().where)}};
  return {{"count", report.loose_ends.size()}, {"first", first}};
}

Json tows(const Ply& ply) {
  const TowReport& r = ply.report.tows;
  const bool turns = r.tightest.radius_mm < 1e9;
  return {{"tows", r.tows},
          {"pieces", r.pieces},
          {"adds", r.adds},
          {"cuts", r.cuts},
          {"length_mm", number(r.length_mm)},
          {"shortest_mm", number(r.shortest_mm)},
          {"longest_mm", number(r.longest_mm)},
          {"gaps_laid_through", r.bridged},
          {"short_extended", r.extended},
          {"short_dropped", r.dropped},
          {"min_steering_radius_mm", turns ? number(r.tightest.radius_mm) : Json()},
          {"tightest_turn", turns ? Json{{"course", r.tightest.course},
                                         {"tow", r.tightest.tow},
                                         {"where", vector(r.tightest.where)}}
                                  : Json()}};
}

Json tow_coverage(const TowCoverage& c) {
  if (!c.measured) return {};
  constexpr std::size_t most_worst = 10;
  const auto percent = [&](double area) { return rounded_number(100 * area / c.skin_mm2, 6); };
  const auto gaps =
      static_cast<std::size_t>(std::count_if(c.spots.begin(), c.spots.end(), [](const TowSpot& s) { return s.gap(); }));
  Json worst = Json::array();
  for (std::size_t i = 0; i < std::min(most_worst, c.spots.size()); ++i) {
    const TowSpot& spot = c.spots[i];
    worst.push_back({{"kind", spot.gap() ? "gap" : "overlap"},
                     {"layers", spot.layers},
                     {"area_mm2", number(spot.area_mm2)},
                     {"length_mm", number(spot.length_mm)},
                     {"width_mm", number(spot.width_mm)},
                     {"where", vector(spot.where)},
                     {"face", spot.face + 1},
                     {"boundary", spot.at_boundary},
                     {"tows", tow_names(spot)}});
  }
  return {{"skin_mm2", number(c.skin_mm2)},
          {"covered_mm2", number(c.covered_mm2)},
          {"covered_percent", percent(c.covered_mm2)},
          {"gap_mm2", number(c.gap_mm2)},
          {"gap_percent", percent(c.gap_mm2)},
          {"overlap_mm2", number(c.overlap_mm2)},
          {"overlap_percent", percent(c.overlap_mm2)},
          {"error_mm2", number(c.error_mm2)},
          {"error_percent", percent(c.error_mm2)},
          {"laid_mm2", number(c.laid_mm2)},
          {"off_skin_mm2", number(c.off_skin_mm2)},
          {"laid_error_mm2", number(c.laid_error_mm2)},
          {"skin_residual_mm2", small_number(c.skin_residual_mm2)},
          {"laid_residual_mm2", small_number(c.laid_residual_mm2)},
          {"gaps", gaps},
          {"overlaps", c.spots.size() - gaps},
          {"worst", worst}};
}

Json ply_facts(const Ply& ply, const std::vector<std::string>& violations) {
  const PlyReport& r = ply.report;
  return {
      {"ply", ply.name},
      {"band_width_mm", number(r.band_width_mm)},
      {"courses_laid", ply.courses.size()},
      {"courses_left", r.courses_left},
      {"courses_right", r.courses_right},
      {"N1", r.N1},
      {"N2", r.N2},
      {"L1_mm", number(r.L1_mm)},
      {"L2_mm", number(r.L2_mm)},
      {"courses_reason", r.courses_reason},
      {"total_length_mm", number(r.total_length_mm)},
      {"skin_area_mm2", number(r.skin_area_mm2)},
      {"covered_share", number(r.covered_share)},
      {"reached_share", number(r.reached_share)},
      {"uncovered", uncovered(r)},
      {"spacing_error_mm", small_number(r.spacing_error_mm)},
      {"spacing", spacing(r.spacing)},
      {"crossings", crossings(r)},
      {"loose_ends", loose_ends(r)},
      // nothing turns on the surface: the radius is not a number, JSON has null for it
      {"min_steering_radius_mm", r.min_steering_radius_mm < 1e9 ? number(r.min_steering_radius_mm) : Json()},
      {"max_deviation_deg", degrees(r.max_deviation_rad)},
      {"tows", tows(ply)},
      {"tow_coverage", tow_coverage(r.tow_coverage)},
      {"reference", reference(r)},
      {"courses", courses(ply)},
      {"warnings", r.warnings},
      {"violations", violations}};
}

Json stage_times(const std::vector<StageTime>& times) {
  Json out = Json::object();
  for (const StageTime& time : times) out[time.stage] = rounded_number(time.seconds, 6);
  return out;
}

Json times(const RunRecord& run, const std::vector<Ply>& plies) {
  Json by_ply = Json::array();
  for (const Ply& ply : plies)
    by_ply.push_back({{"ply", ply.name}, {"stages_s", stage_times(ply.report.times)}});
  return {{"started", run.started},
          {"threads", run.threads},
          {"peak_memory_mb", rounded_number(run.peak_memory_mb, 1)},
          {"stages_s", stage_times(run.times)},
          {"plies", by_ply}};
}

}  // namespace

std::string summary_json(const RunRecord& run, const StepModel& model, const Skin& skin,
                         const std::vector<Ply>& plies) {
  Json out;
  out["versions"] = versions(run);
  out["inputs"] = inputs(run);
  out["options"] = options(run.job);
  out["part"] = part(model);
  out["skin"] = skin_facts(run, skin);
  out["plies"] = Json::array();
  for (const Ply& ply : plies) {
    const auto found = std::find_if(run.violations.begin(), run.violations.end(),
                                    [&](const auto& entry) { return entry.first == ply.name; });
    out["plies"].push_back(
        ply_facts(ply, found == run.violations.end() ? ply.report.violations : found->second));
  }
  out["warnings"] = run.warnings;
  const bool covered = std::any_of(plies.begin(), plies.end(), [](const Ply& p) { return p.report.tow_coverage.measured; });
  out["files"] = {"paths.csv", "tows.csv"};
  if (covered) out["files"].push_back("coverage.csv");
  for (const char* name : {"paths.step", "summary.json"}) out["files"].push_back(name);
  out["times"] = times(run, plies);
  // names in a STEP file may be any bytes: what is not UTF-8 is replaced, never a reason to fail
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace afptraj
