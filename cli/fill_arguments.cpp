#include "cli/fill_arguments.h"

#include <map>

#include "geometry/error.h"
#include "io/nearest_name.h"
#include "io/text_file.h"

namespace afptraj::cli {
namespace {

const char* const fill_examples = R"(Examples:
  afptraj fill slice.csv --spacing 1
  afptraj fill slice.csv --spacing 0.8 --compensate -0.5 -o result --force
  afptraj fill slice.csv --pattern outline --compensate 1.5
  afptraj fill slice.csv --connect spiral
  afptraj fill slice.csv --pattern zigzag --angle 60 --outline

A slice is closed rings: outlines, holes, islands in holes, any sense. A table path,i,x,y (.csv), or the closed
shapes of a drawing (.svg, .dxf). Writes paths.csv, summary.json and fill.svg; paths.gcode and paths.vtp if asked.)";

const std::map<std::string, FillArguments::Pattern> patterns{{"contour", FillArguments::Pattern::contour},
                                                             {"outline", FillArguments::Pattern::outline},
                                                             {"raster", FillArguments::Pattern::raster},
                                                             {"zigzag", FillArguments::Pattern::zigzag}};

}  // namespace

CLI::App* add_fill_command(CLI::App& app, FillArguments& arguments, const WindFlags& flags) {
  CLI::App* fill = app.add_subcommand("fill", "Fills a planar slice with paths.");
  fill->footer(fill_examples);
  fill->add_option("slice", arguments.file, "the slice: closed rings")->type_name("slice.csv|svg|dxf");
  fill->add_option("-o,--output", arguments.output, "result directory [<slice>-afptraj]")->type_name("DIR");
  fill->add_option(
          "--pattern", arguments.pattern_text,
          "contour (rings), outline (the outermost only), raster (lines) or zigzag (lines joined along the "
          "boundary) [contour]")
      ->type_name("PATTERN");
  fill->add_option("--spacing", arguments.spacing, "from path to path, and width of a bead [1]")
      ->type_name("MM");
  fill->add_option("--compensate", arguments.compensate,
                   "where the outermost path lies: offset of the outline, negative inside [-spacing/2]")
      ->type_name("MM");
  fill->add_option("--corner-radius", arguments.corner_radius,
                   "contour: radius of the rings' convex corners, at most spacing/2 [spacing/4]")
      ->type_name("MM");
  fill->add_option("--angle", arguments.angle, "raster, zigzag: of the lines, from x towards y [0]")
      ->type_name("DEG");
  fill->add_flag("--outline", arguments.outline,
                 "raster, zigzag: rings round the lines, and paths in what stays bare");
  fill->add_option("--max-link", arguments.max_link, "zigzag: longest link from line to line [10 spacing]")
      ->type_name("MM");
  fill->add_option(
          "--connect", arguments.connect_text,
          "contour: rings become one path, nested (links out and back) or spiral (connected Fermat spirals)")
      ->type_name("HOW");
  fill->add_option("--least-void", arguments.least_void,
                   "contour, --outline: larger bare places get a path [0.05 spacing^2; with --connect 0.28]")
      ->type_name("MM2");
  fill->add_option("--tolerance", arguments.tolerance,
                   "a path's chords lie this near to the exact arcs [0.001]")
      ->type_name("MM");
  fill->add_flag("--gcode", arguments.gcode, "write paths.gcode as well");
  fill->add_option("--feed", arguments.feed, "of --gcode, along the paths [1200]")->type_name("MM/MIN");
  fill->add_option("--extrusion", arguments.extrusion,
                   "of --gcode: material fed per mm of path; 0: no E words [0]")
      ->type_name("MM/MM");
  fill->add_flag("--vtp", arguments.vtp, "write paths.vtp as well");
  fill->add_flag("--force", *flags.force, "replace an earlier result");
  fill->add_flag("--json", *flags.json, "print summary.json instead of a table");
  fill->add_flag("-q,--quiet", *flags.quiet, "print errors only");
  return fill;
}

void finish_fill(FillArguments& arguments) {
  if (arguments.file.empty())
    throw Error(ErrorCode::usage, "afptraj fill", "needs a slice; see afptraj fill --help");
  if (!arguments.pattern_text.empty()) {
    const auto found = patterns.find(arguments.pattern_text);
    if (found == patterns.end()) {
      std::vector<std::string> names;
      for (const auto& [name, pattern] : patterns) names.push_back(name);
      const std::string hint = did_you_mean(arguments.pattern_text, names);
      throw Error(ErrorCode::usage, "--pattern",
                  "'" + printable(arguments.pattern_text) + "' is unknown" +
                      (hint.empty() ? "; this version has contour, outline, raster and zigzag" : hint));
    }
    arguments.pattern = found->second;
  }
  constexpr double greatest = 1e5, least = 1e-3;
  if (!arguments.spacing.empty())
    arguments.spacing_mm = bounded("--spacing", arguments.spacing, least, greatest, false);
  arguments.compensate_mm = arguments.compensate.empty()
                                ? -arguments.spacing_mm / 2
                                : bounded("--compensate", arguments.compensate, -greatest, greatest, false);
  if (!arguments.corner_radius.empty() && arguments.pattern != FillArguments::Pattern::contour)
    throw Error(ErrorCode::usage, "--corner-radius", "is of the contour pattern only; leave it out");
  arguments.corner_radius_mm =
      arguments.corner_radius.empty()
          ? arguments.spacing_mm / 4
          : bounded("--corner-radius", arguments.corner_radius, 0, arguments.spacing_mm / 2, false);
  const bool lines = arguments.pattern == FillArguments::Pattern::raster ||
                     arguments.pattern == FillArguments::Pattern::zigzag;
  if (!arguments.angle.empty()) {
    if (!lines)
      throw Error(ErrorCode::usage, "--angle", "is of the raster and zigzag patterns only; leave it out");
    arguments.angle_deg = bounded("--angle", arguments.angle, -360, 360, false);
  }
  if (arguments.outline && !lines)
    throw Error(ErrorCode::usage, "--outline", "is of the raster and zigzag patterns only; leave it out");
  if (!arguments.max_link.empty() && arguments.pattern != FillArguments::Pattern::zigzag)
    throw Error(ErrorCode::usage, "--max-link", "is of the zigzag pattern only; leave it out");
  arguments.max_link_mm = arguments.max_link.empty()
                              ? 10 * arguments.spacing_mm
                              : bounded("--max-link", arguments.max_link, 0, 10 * greatest, false);
  if (!arguments.gcode && !(arguments.feed.empty() && arguments.extrusion.empty()))
    throw Error(ErrorCode::usage, arguments.feed.empty() ? "--extrusion" : "--feed",
                "is of --gcode only; give that as well");
  if (!arguments.feed.empty())
    arguments.feed_mm_per_min = bounded("--feed", arguments.feed, 1e-3, 1e6, false);
  if (!arguments.extrusion.empty())
    arguments.extrusion_mm_per_mm = bounded("--extrusion", arguments.extrusion, 0, 1e3, false);
  if (!arguments.connect_text.empty()) {
    if (arguments.pattern != FillArguments::Pattern::contour)
      throw Error(ErrorCode::usage, "--connect", "is of the contour pattern only; leave it out");
    if (arguments.connect_text != "nested" && arguments.connect_text != "spiral")
      throw Error(ErrorCode::usage, "--connect",
                  "'" + printable(arguments.connect_text) + "' is unknown; give nested or spiral");
    arguments.connect =
        arguments.connect_text == "spiral" ? FillArguments::Connect::spiral : FillArguments::Connect::nested;
  }
  if (!arguments.least_void.empty() && arguments.pattern != FillArguments::Pattern::contour &&
      !arguments.outline)
    throw Error(ErrorCode::usage, "--least-void",
                "is of the contour pattern and --outline only; leave it out");
  const double share = arguments.connect == FillArguments::Connect::none ? 0.05 : 0.28;
  arguments.least_void_mm2 =
      arguments.least_void.empty()
          ? share * arguments.spacing_mm * arguments.spacing_mm
          : bounded("--least-void", arguments.least_void, 0, greatest * greatest, false);
  if (!arguments.tolerance.empty())
    arguments.tolerance_mm = bounded("--tolerance", arguments.tolerance, 1e-6, arguments.spacing_mm, false);
}

}  // namespace afptraj::cli
