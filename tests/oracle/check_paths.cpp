// Judges the paths.csv of a run by OpenCASCADE alone; see README.md in this folder.
#include <Standard_Failure.hxx>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "checks.h"
#include "step_faces.h"

namespace {

using Json = nlohmann::ordered_json;
using oracle::Vec;

constexpr const char* usage = R"(usage: check_paths part.step paths.csv --band MM [options]
  --faces LIST        all (default), or numbers and entity numbers: 1,4-6,#661
  --unit UNIT         mm, cm, m, in, ft instead of what the file declares
  --join MM           faces nearer than this along an edge are joined (0.05)
  --summary FILE      summary.json: what it names as not covered is allowed
  --points N          points at which the spacing is measured, per ply (1500)
  --samples N         area samples for the coverage (10000)
  --json FILE         all figures
  --label TEXT        first column of the table row (the part's name)
limits (a figure beyond one makes the exit code 1):
  --max-surface MM 1e-6   --max-spacing MM 1e-3   --max-end MM 1e-6   --min-coverage SHARE 0.999
)";

struct Arguments {
  std::vector<std::string> files;
  std::map<std::string, std::string> values;
  std::string text(const std::string& name, const std::string& fallback) const {
    const auto found = values.find(name);
    return found == values.end() ? fallback : found->second;
  }
  double number(const std::string& name, double fallback) const {
    const auto found = values.find(name);
    return found == values.end() ? fallback : std::strtod(found->second.c_str(), nullptr);
  }
};

Arguments parse(int argc, char** argv) {
  Arguments arguments;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word.rfind("--", 0) != 0)
      arguments.files.push_back(word);
    else if (i + 1 < argc)
      arguments.values[word.substr(2)] = argv[++i];
  }
  return arguments;
}

Json place(const Vec& p) { return Json::array({p.X(), p.Y(), p.Z()}); }
Json worst(const oracle::Worst& w) { return {{"value", w.value}, {"where", place(w.where)}, {"at", w.what}}; }

// What the run itself says of a ply, from summary.json.
struct Named {
  bool known = false;
  double covered_share = 1, uncovered_area = 0;
  bool reasons = true;
  double spacing_error = 0;
};

Named named_in(const Json& summary, const std::string& ply) {
  Named named;
  if (!summary.contains("plies")) return named;
  for (const Json& entry : summary["plies"]) {
    if (entry.value("ply", "") != ply) continue;
    named.known = true;
    named.covered_share = entry.value("covered_share", 1.0);
    named.spacing_error = entry.value("spacing_error_mm", 0.0);
    for (const Json& spot : entry.value("uncovered", Json::array())) {
      named.uncovered_area += spot.value("area_mm2", 0.0);
      if (spot.value("reason", "").empty()) named.reasons = false;
    }
  }
  return named;
}

struct Verdict {
  std::vector<std::string> failures;
  void require(bool holds, const std::string& what) {
    if (!holds) failures.push_back(what);
  }
};

std::string short_number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1e", x);
  return x == 0 ? "0" : text;
}

// One ply: all checks, figures to `out`, one row of the table to stdout; true when all limits hold.
bool judge(const oracle::Skin& skin, oracle::PlyPaths& ply, const Arguments& a, const Json& summary,
           Json& out) {
  const double band = a.number("band", 0);
  const oracle::SurfaceCheck surface = oracle::check_on_surface(skin, ply);
  const oracle::EndCheck ends = oracle::check_ends(skin, ply);
  const oracle::CrossingCheck crossings = oracle::check_crossings(ply, band);
  const oracle::SpacingCheck spacing =
      oracle::check_spacing(skin, ply, band, static_cast<int>(a.number("points", 1500)));
  const oracle::CoverageCheck coverage =
      oracle::check_coverage(skin, ply, band, static_cast<int>(a.number("samples", 10000)));
  const Named named = named_in(summary, ply.name);

  double length = 0;
  std::map<int, int> courses;
  for (const oracle::Segment& s : ply.segments) {
    length += s.length();
    ++courses[s.course];
  }
  Verdict verdict;
  verdict.require(surface.distance.value <= a.number("max-surface", 1e-6), "surface");
  verdict.require(surface.outside.value <= a.number("max-end", 1e-6), "outside");
  verdict.require(surface.normal.value <= 1e-4, "normal");
  verdict.require(surface.arc.value <= 1e-4, "arc-length");
  verdict.require(spacing.error.value <= a.number("max-spacing", 1e-3), "spacing");
  verdict.require(ends.error.value <= a.number("max-end", 1e-6) && ends.inside == 0, "ends");
  verdict.require(ends.shared == 0, "ends-at-shared-edge");
  verdict.require(crossings.self + crossings.mutual == 0, "crossings");
  // Missing area must be named with a reason; the two ways of sampling agree to a fifth or 0.1 %.
  const double missing = coverage.area - coverage.covered;
  const bool explained =
      named.known && named.reasons && named.uncovered_area > 0.8 * missing - 1e-3 * coverage.area;
  verdict.require(coverage.share() >= a.number("min-coverage", 0.999) || explained, "coverage");

  std::string failed;
  for (const std::string& f : verdict.failures) failed += (failed.empty() ? "" : ",") + f;
  std::printf("%-24s %-8s %5d %7zu %5zu %10.1f %9s %9s %9s %4d/%-4d %8.4f%s %7.2f  %s\n",
              a.text("label", a.files[0]).c_str(), ply.name.c_str(), skin.size(), courses.size(),
              ply.segments.size(), length, short_number(surface.distance.value).c_str(),
              short_number(spacing.error.value).c_str(), short_number(ends.error.value).c_str(),
              crossings.self, crossings.mutual, 100 * coverage.share(),
              coverage.share() < 0.999 && explained ? "*" : " ", coverage.distance.value,
              failed.empty() ? "ok" : ("FAIL " + failed).c_str());

  Json spots = Json::array();
  for (std::size_t i = 0; i < std::min<std::size_t>(coverage.uncovered.size(), 20); ++i)
    spots.push_back(
        {{"where", place(coverage.uncovered[i].where)}, {"distance_mm", coverage.uncovered[i].distance}});
  out.push_back(
      {{"ply", ply.name},
       {"band_mm", band},
       {"courses", courses.size()},
       {"segments", ply.segments.size()},
       {"length_mm", length},
       {"surface",
        {{"points", surface.points},
         {"distance", worst(surface.distance)},
         {"outside", worst(surface.outside)},
         {"normal_rad", worst(surface.normal)},
         {"tangent_rad", worst(surface.tangent)},
         {"arc_against_chord", worst(surface.arc)},
         {"sample_spacing", worst(surface.spacing)}}},
       {"ends",
        {{"error", worst(ends.error)},
         {"error_to_3d_curve", worst(ends.error_curve)},
         {"boundary", ends.boundary},
         {"seam", ends.seam},
         {"shared_edge", ends.shared},
         {"pole", ends.pole},
         {"corner", ends.corner},
         {"closed", ends.closed},
         {"inside", ends.inside}}},
       {"crossings", {{"self", crossings.self}, {"mutual", crossings.mutual}, {"first", crossings.where}}},
       {"spacing",
        {{"E", worst(spacing.error)},
         {"rms", spacing.rms},
         {"measured", spacing.measured},
         {"beyond_end", spacing.beyond_end},
         {"off_skin", spacing.off_skin},
         {"off_skin_error", worst(spacing.off_skin_error)},
         {"unresolved", spacing.unresolved},
         {"reported_mm", named.spacing_error}}},
       {"coverage",
        {{"share", coverage.share()},
         {"share_near_written_lines", coverage.near_line_share()},
         {"area_mm2", coverage.area},
         {"samples", coverage.samples},
         {"measured_by_geodesics", coverage.measured},
         {"uncovered_samples", coverage.uncovered.size()},
         {"worst", worst(coverage.distance)},
         {"reported_share", named.covered_share},
         {"explained", explained},
         {"spots", spots}}},
       {"failures", verdict.failures}});
  return verdict.failures.empty();
}

int run(const Arguments& a) {
  std::vector<TopoDS_Face> faces;
  const auto all = oracle::read_step_faces(a.files[0], a.text("unit", ""));
  for (const oracle::StepFace& f : oracle::choose_faces(all, a.text("faces", "all"))) faces.push_back(f.face);
  const oracle::Skin skin(faces, a.number("join", 0.05));
  std::vector<oracle::PlyPaths> plies = oracle::read_paths(a.files[1]);
  Json summary;
  if (const std::string file = a.text("summary", ""); !file.empty()) {
    std::ifstream in(file);
    summary = Json::parse(in);
  }
  Json report = Json::array();
  bool good = !plies.empty();
  for (oracle::PlyPaths& ply : plies) good = judge(skin, ply, a, summary, report) && good;
  if (const std::string file = a.text("json", ""); !file.empty())
    std::ofstream(file) << report.dump(2) << "\n";
  return good ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  const Arguments a = parse(argc, argv);
  if (a.files.size() != 2 || a.number("band", 0) <= 0) {
    std::fputs(usage, stderr);
    return 2;
  }
  try {
    return run(a);
  } catch (const Standard_Failure& failure) {
    std::fprintf(stderr, "check_paths: %s\n", failure.GetMessageString());
  } catch (const std::exception& failure) {
    std::fprintf(stderr, "check_paths: %s\n", failure.what());
  }
  return 3;
}
