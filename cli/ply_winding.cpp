#include "cli/ply_winding.h"

#include "cli/mandrel_file.h"
#include "cli/terminal.h"
#include "geometry/error.h"
#include "io/plies_csv.h"
#include "winding/ply_angles.h"

namespace afptraj::cli {
namespace {

PlyAngle angle_of(const SkinMandrel& mandrel, const PlyOrientation& ply, const std::string& file) {
  std::vector<FibreDirection> points;
  for (const PlyPoint& point : ply.points) points.push_back({point.position, point.direction});
  try {
    return ply_angle(mandrel, points);
  } catch (const Error& e) {
    throw Error(e.code(), file, "ply " + ply.name + " " + e.what());
  }
}

void require_flags(const WindArguments& arguments) {
  if (!arguments.tow_width_mm)
    throw Error(ErrorCode::usage, "--tow-width", "is missing; give the width of the tow");
  if (arguments.thickness.empty())
    throw Error(ErrorCode::usage, "--thickness", "is missing; give the thickness of the tow");
  if (arguments.feed.empty())
    throw Error(ErrorCode::usage, "--feed", "is missing; give mm of fibre by minute");
}

}  // namespace

PlyWinding read_ply_winding(const WindArguments& arguments) {
  require_flags(arguments);
  const PliesFile file = read_plies_file(arguments.plies);
  const SkinMandrel mandrel = read_part_mandrel(arguments.file, arguments.faces);
  std::vector<PlyAngle> angles;
  for (const PlyOrientation& ply : file.plies) angles.push_back(angle_of(mandrel, ply, arguments.plies));
  PlyWinding out{
      {mandrel.meridian, {*arguments.tow_width_mm, arguments.thickness_mm}, arguments.feed_mm_per_min, {}},
      {},
      {}};
  for (const std::string& warning : file.warnings) out.notes += arguments.plies + ": " + warning + "\n";
  for (const PlyLayer& found : layers_of_plies(angles, arguments.tolerance_deg)) {
    VesselLayer layer;
    layer.angle_deg = found.angle_deg;
    layer.tolerance_deg = arguments.tolerance_deg;
    layer.most_overlap = arguments.most_overlap;
    layer.steering.friction = arguments.friction_ratio;
    out.winding.layers.push_back(layer);
    std::vector<std::string> names;
    for (const std::size_t i : found.plies) {
      names.push_back(file.plies[i].name);
      out.notes += "ply " + file.plies[i].name + ": layer " + std::to_string(out.winding.layers.size()) +
                   ", " + short_number(angles[i].angle_deg, 6) +
                   " deg from the axis at the widest place, asked within " +
                   short_number(angles[i].spread_deg, 3) + " deg\n";
    }
    out.plies.push_back(names);
  }
  return out;
}

}  // namespace afptraj::cli
