#include "cli/run_report.h"

#include <algorithm>
#include <cmath>

#include "cli/terminal.h"
#include "io/text_file.h"

namespace afptraj::cli {
namespace {

std::string degrees(double angle_rad) { return short_number(angle_rad * 180 / pi, 3); }

std::string percent(double share) {
  // never rounded up to 100 %
  return short_number(std::floor(share * 1e6) / 1e4, 6) + " %";
}

std::string place(const Vec3& p) {
  return "(" + short_number(p.x(), 5) + ", " + short_number(p.y(), 5) + ", " + short_number(p.z(), 5) + ")";
}

std::string line(const char* name, const std::string& text) {
  std::string head = std::string("  ") + name;
  head.resize(16, ' ');
  return head + text + "\n";
}

std::string metres(double mm) { return short_number(mm / 1000, 5) + " m"; }

std::size_t segment_count(const Ply& ply) {
  std::size_t count = 0;
  for (const Course& course : ply.courses) count += course.segments.size();
  return count;
}

}  // namespace

std::vector<std::string> limit_violations(const Ply& ply, const Job& job) {
  const PlyReport& r = ply.report;
  std::vector<std::string> out = r.violations;
  if (r.reached_share < job.min_coverage) {
    out.push_back("coverage " + percent(r.reached_share) + " is below " + percent(job.min_coverage));
  }
  if (r.spacing_error_mm > job.max_spacing_error_mm) {
    out.push_back("spacing error " + short_number(r.spacing_error_mm, 3) + " mm is above " +
                  short_number(job.max_spacing_error_mm) + " mm");
  }
  return out;
}

std::string ply_table(const Ply& ply, const Job& job, const std::vector<std::string>& violations) {
  const PlyReport& r = ply.report;
  std::string out = "ply " + printable(ply.name) + ": " + std::to_string(ply.courses.size()) + " courses (" +
                    std::to_string(r.courses_left) + " left, " + std::to_string(r.courses_right) +
                    " right) in " + std::to_string(segment_count(ply)) + " segments, " +
                    metres(r.total_length_mm) + "\n";
  out += line("reference", metres(r.reference_length_mm) + ", fitted to " + short_number(r.fit_rms_mm, 2) +
                               " mm rms, " + short_number(r.fit_max_mm, 2) + " mm at most");
  out += line("bands needed", "N1 = " + std::to_string(r.N1) + " left (L1 = " + short_number(r.L1_mm, 5) +
                                  " mm), N2 = " + std::to_string(r.N2) +
                                  " right (L2 = " + short_number(r.L2_mm, 5) + " mm)" +
                                  (r.courses_reason.empty() ? "" : "; " + printable(r.courses_reason, 300)));
  out += line("coverage", percent(r.covered_share) + " of " + short_number(r.skin_area_mm2 / 1e6, 4) +
                              " m2 within " + short_number(r.band_width_mm / 2) + " mm of a centre line; " +
                              percent(r.reached_share) +
                              " with the bands at the boundary whose centre line runs off the skin");
  constexpr std::size_t most_spots = 3;
  for (std::size_t i = 0; i < std::min(most_spots, r.uncovered.size()); ++i) {
    const UncoveredSpot& spot = r.uncovered[i];
    out += line("", short_number(spot.area_mm2, 3) + " mm2 up to " + short_number(spot.distance_mm, 4) +
                        " mm away at " + place(spot.where) + ": " + printable(spot.reason, 200));
  }
  if (r.uncovered.size() > most_spots) {
    out += line("", "and " + std::to_string(r.uncovered.size() - most_spots) + " more, see summary.json");
  }
  out += line("spacing", "error at most " + short_number(r.spacing_error_mm, 2) + " mm of " +
                             short_number(r.band_width_mm) + " mm");
  constexpr double straight_mm = 1e9;
  out += line("steering", (r.min_steering_radius_mm < straight_mm
                               ? "radius at least " + short_number(r.min_steering_radius_mm, 4) + " mm"
                               : std::string("none")) +
                              " (limit " + short_number(job.plan.min_steering_radius_mm) + " mm)");
  const TowReport& tows = r.tows;
  out += line("tows", std::to_string(tows.tows) + " in " + std::to_string(tows.pieces) + " pieces, " +
                          metres(tows.length_mm) + ", " + short_number(tows.shortest_mm, 4) + " to " +
                          short_number(tows.longest_mm, 5) + " mm long; " + std::to_string(tows.extended) +
                          " extended, " + std::to_string(tows.dropped) + " dropped, " + std::to_string(tows.bridged) +
                          " gaps laid through");
  if (r.tow_coverage.measured) {
    const TowCoverage& c = r.tow_coverage;
    const auto share = [&](double area) { return short_number(100 * area / c.skin_mm2, 4) + " %"; };
    const auto gaps = std::count_if(c.spots.begin(), c.spots.end(), [](const TowSpot& s) { return s.gap(); });
    out += line("tow coverage", share(c.covered_mm2) + " of the skin, gaps " + share(c.gap_mm2) + " in " +
                                    std::to_string(gaps) + " places, overlap " + share(c.overlap_mm2) + " in " +
                                    std::to_string(c.spots.size() - static_cast<std::size_t>(gaps)) +
                                    ", each within " + short_number(100 * c.error_mm2 / c.skin_mm2, 2) + " %");
  }
  out += line("deviation", "at most " + degrees(r.max_deviation_rad) + " deg (limit " +
                               degrees(job.plan.angle_limit_rad) + " deg)");
  for (const std::string& violation : violations) out += line("VIOLATED", printable(violation, 300));
  return out;
}

}  // namespace afptraj::cli
