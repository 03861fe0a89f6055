#include <cctype>
#include <chrono>
#include <cmath>
#include <ctime>
#include <filesystem>

#include "analysis/judge_fill.h"
#include "cli/build_facts.h"
#include "cli/commands.h"
#include "cli/part_file.h"
#include "cli/terminal.h"
#include "fill/connect.h"
#include "fill/contour_parallel.h"
#include "fill/line_fill.h"
#include "geometry/error.h"
#include "io/fill_files.h"
#include "io/fill_programs.h"
#include "io/number_text.h"
#include "io/output_directory.h"
#include "io/slice_csv.h"
#include "io/slice_dxf.h"
#include "io/slice_svg.h"
#include "io/step/sha256.h"
#include "io/text_file.h"

namespace afptraj::cli {
namespace {

using Pattern = FillArguments::Pattern;

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  ::gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

SliceFile read_any_slice(const FillArguments& arguments) {
  std::string extension = std::filesystem::path(arguments.file).extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (extension == ".svg") return read_slice_svg(arguments.file, arguments.tolerance_mm);
  if (extension == ".dxf") return read_slice_dxf(arguments.file, arguments.tolerance_mm);
  return read_slice(arguments.file);
}

Fill outline_only(const Slice& slice, const FillArguments& arguments) {
  Fill fill;
  for (const ArcRing& ring : offset_rings(slice, -arguments.compensate_mm, arguments.tolerance_mm)) {
    Polyline line = flattened(ring, arguments.tolerance_mm);
    if (line.points.size() >= 3) fill.paths.push_back({std::move(line), PathKind::outline, 0});
  }
  return fill;
}

Fill make_fill(const Slice& slice, const FillArguments& arguments) {
  const double void_share = arguments.least_void_mm2 / (arguments.spacing_mm * arguments.spacing_mm);
  switch (arguments.pattern) {
    case Pattern::contour: {
      const Fill rings =
          contour_parallel(slice, {arguments.spacing_mm, -arguments.compensate_mm, arguments.tolerance_mm,
                                   arguments.corner_radius_mm, void_share});
      if (arguments.connect == FillArguments::Connect::none) return rings;
      return connected(
          rings, slice, arguments.spacing_mm,
          arguments.connect == FillArguments::Connect::spiral ? Connection::spiral : Connection::nested);
    }
    case Pattern::outline:
      return outline_only(slice, arguments);
    case Pattern::raster:
    case Pattern::zigzag: {
      LineOptions options;
      options.spacing_mm = arguments.spacing_mm;
      options.angle_rad = arguments.angle_deg * pi / 180;
      options.first_mm = -arguments.compensate_mm;
      options.tolerance_mm = arguments.tolerance_mm;
      options.outline = arguments.outline;
      options.zigzag = arguments.pattern == Pattern::zigzag;
      options.most_link_mm = arguments.max_link_mm;
      options.least_void_share = void_share;
      return line_fill(slice, options);
    }
  }
  return {};
}

std::vector<std::pair<std::string, std::string>> options_of(const FillArguments& arguments) {
  std::vector<std::pair<std::string, std::string>> options{
      {"pattern", arguments.pattern_text.empty() ? "contour" : arguments.pattern_text},
      {"spacing_mm", number_text(arguments.spacing_mm)},
      {"compensate_mm", number_text(arguments.compensate_mm)},
      {"tolerance_mm", number_text(arguments.tolerance_mm)}};
  if (arguments.pattern == Pattern::contour)
    options.emplace_back("corner_radius_mm", number_text(arguments.corner_radius_mm));
  if (arguments.gcode) {
    options.emplace_back("feed_mm_per_min", number_text(arguments.feed_mm_per_min));
    options.emplace_back("extrusion_mm_per_mm", number_text(arguments.extrusion_mm_per_mm));
  }
  if (arguments.connect != FillArguments::Connect::none)
    options.emplace_back("connect", arguments.connect_text);
  if (arguments.pattern == Pattern::contour || arguments.outline)
    options.emplace_back("least_void_mm2", number_text(arguments.least_void_mm2));
  if (arguments.pattern == Pattern::raster || arguments.pattern == Pattern::zigzag) {
    options.emplace_back("angle_deg", number_text(arguments.angle_deg));
    options.emplace_back("outline", arguments.outline ? "yes" : "no");
  }
  if (arguments.pattern == Pattern::zigzag)
    options.emplace_back("max_link_mm", number_text(arguments.max_link_mm));
  return options;
}

std::string table(const FillReport& report, const Fill& fill) {
  const auto row = [](const std::string& name, const std::string& value) {
    return name + std::string(18 - name.size(), ' ') + value + "\n";
  };
  double left = 0;
  for (const Leftover& place : fill.leftovers) left += place.area_mm2;
  return row("slice", short_number(report.slice_mm2, 7) + " mm2") +
         row("paths", std::to_string(report.paths) + ", " + short_number(report.length_mm, 7) +
                          " mm, travel " + short_number(report.travel_mm, 6) + " mm") +
         (fill.links.count == 0
              ? std::string()
              : row("links", std::to_string(fill.links.count) + ", " + short_number(fill.links.length_mm, 6) +
                                 " mm, the longest " + short_number(fill.links.longest_mm) + " mm")) +
         row("underfill", short_number(100 * report.underfill) + " %, of which no bead reaches " +
                              short_number(100 * report.unreachable) + " %") +
         row("overfill", short_number(100 * report.overfill) + " %, with the round ends of beads " +
                             short_number(100 * report.overfill_with_ends) + " %") +
         row("outside", short_number(100 * report.outside) + " %") +
         row("sharp corners", std::to_string(report.sharp_corners)) +
         row("turning radius", std::isfinite(report.min_turning_radius_mm)
                                   ? short_number(report.min_turning_radius_mm) + " mm at least"
                                   : "none turns") +
         (fill.leftovers.empty() ? std::string()
                                 : row("left out", std::to_string(fill.leftovers.size()) + " places, " +
                                                       short_number(left) + " mm2 in all"));
}

}  // namespace

int fill(const Arguments& arguments) {
  using Clock = std::chrono::steady_clock;
  const FillArguments& asked = arguments.fill;
  FillRecord record;
  record.started = utc_now();
  record.versions = versions();
  record.options = options_of(asked);
  auto last = Clock::now();
  const auto done = [&](const std::string& stage) {
    const auto now = Clock::now();
    record.times.push_back({stage, std::chrono::duration<double>(now - last).count()});
    last = now;
    check_stop();
  };
  const std::string target =
      asked.output.empty() ? std::filesystem::path(asked.file).stem().string() + "-afptraj" : asked.output;
  require_readable_file(asked.file);
  check_output(target, arguments.force, {asked.file});
  const SliceFile file = read_any_slice(asked);
  constexpr std::size_t any_size = std::size_t{1} << 40;
  record.inputs = {{"slice", asked.file, sha256_hex(read_file(asked.file, any_size))}};
  for (const std::string& warning : file.warnings) record.warnings.push_back(asked.file + ": " + warning);
  done("read slice");

  const Fill fill = make_fill(file.slice, asked);
  if (fill.paths.empty()) {
    throw Error(ErrorCode::no_path, asked.file,
                "no path fits: nowhere is the slice wide enough for a bead of " +
                    short_number(asked.spacing_mm, 6) + " mm; use a smaller --spacing or --compensate 0");
  }
  done("plan");
  const FillReport report = judge_fill(file.slice, fill.paths, asked.spacing_mm);
  done("judge");

  OutputDirectory output(target, arguments.force, {asked.file});
  output.write("paths.csv", fill_paths_csv(fill, file.z_mm));
  output.write("fill.svg", fill_svg(file.slice, fill, asked.spacing_mm));
  record.files = {"paths.csv", "summary.json", "fill.svg"};
  if (asked.gcode) {
    output.write("paths.gcode",
                 fill_gcode(fill, {asked.feed_mm_per_min, asked.extrusion_mm_per_mm, file.z_mm}));
    record.files.push_back("paths.gcode");
  }
  if (asked.vtp) {
    output.write("paths.vtp", fill_vtp(fill, file.z_mm));
    record.files.push_back("paths.vtp");
  }
  done("write");
  const std::string summary = fill_summary_json(record, file.slice, fill, report);
  output.write("summary.json", summary);
  output.commit();
  if (arguments.json) {
    print(summary);
  } else if (!arguments.quiet) {
    for (const std::string& warning : record.warnings) print_note("afptraj: warning: " + warning);
    std::string names;
    for (const std::string& name : record.files) names += (names.empty() ? "" : ",") + name;
    print(table(report, fill) + "wrote " + target + "/{" + names + "}\n");
  }
  return 0;
}

}  // namespace afptraj::cli
