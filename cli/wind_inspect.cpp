#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "cli/part_file.h"
#include "cli/terminal.h"
#include "cli/wind_commands.h"
#include "geometry/error.h"
#include "io/meridian_csv.h"
#include "io/text_file.h"
#include "io/wind_file.h"
#include "winding/frustum.h"
#include "winding/meridian_geodesic.h"
#include "winding/skin_mandrel.h"

namespace afptraj::cli {
namespace {

using Json = nlohmann::ordered_json;

Meridian meridian_of(const WindMandrel& mandrel) {
  return meridian_through({{0, mandrel.diameter_mm / 2},
                           {mandrel.length_mm, mandrel.end_diameter_mm.value_or(mandrel.diameter_mm) / 2}});
}

// What is known of a mandrel's origin, beside its meridian.
struct Mandrel {
  Meridian meridian;
  Json source = Json::object();
  std::string text;
};

// The faces of a part that make the mandrel: those named, or all that are not plane.
std::vector<int> mandrel_faces(const std::shared_ptr<const Part>& part, const std::string& list) {
  Job job;
  if (!list.empty()) {
    set_job_key(job, "faces.list", list, "--face");
    return choose_faces(part, job.faces, {}).faces;
  }
  std::vector<int> faces;
  for (std::size_t i = 0; i < part->faces.size(); ++i) {
    if (part->faces[i].surface.kind() != SurfaceKind::plane) faces.push_back(static_cast<int>(i));
  }
  if (faces.empty())
    throw Error(ErrorCode::bad_input, "part",
                "has only plane faces; give a part with a surface of revolution");
  return faces;
}

Json vector_json(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

Mandrel mandrel_of_part(const WindArguments& arguments) {
  const auto part = std::make_shared<const Part>(read_part(arguments.file, {}).part);
  const Skin skin(part, mandrel_faces(part, arguments.faces));
  // As good as a STEP file's own joints are.
  constexpr double tolerance_mm = 0.01;
  try {
    const SkinMandrel found = mandrel_from_skin(skin, tolerance_mm);
    return {found.meridian,
            {{"axis_origin", vector_json(found.origin)},
             {"axis_direction", vector_json(found.direction)},
             {"deviation_mm", found.deviation_mm}},
            "axis       deviation from a surface of revolution at most " +
                short_number(found.deviation_mm, 3) + " mm\n"};
  } catch (const Error& e) {
    throw Error(e.code(), arguments.file, e.what());
  }
}

Mandrel read_mandrel(const WindArguments& arguments) {
  const std::filesystem::path kind = std::filesystem::path(arguments.file).extension();
  if (kind != ".wind" && kind != ".csv") {
    require_readable_file(arguments.file);
    return mandrel_of_part(arguments);
  }
  if (!arguments.faces.empty())
    throw Error(ErrorCode::usage, "--face", "is for parts; leave it out with " + kind.string() + " files");
  if (kind == ".csv") return {read_meridian(arguments.file), Json::object(), {}};
  return {meridian_of(read_wind_file(arguments.file, WindMode::native).mandrel), Json::object(), {}};
}

Json place_json(const MeridianPoint& at) { return {{"z_mm", at.z_mm}, {"r_mm", at.r_mm}}; }

Json mandrel_json(const Meridian& meridian) {
  return {{"first_end", place_json(meridian.at(meridian.first()))},
          {"last_end", place_json(meridian.at(meridian.last()))},
          {"widest", place_json(meridian.at(meridian.widest()))},
          {"narrowest", place_json(meridian.at(meridian.narrowest()))},
          {"meridian_length_mm", meridian.length_mm()}};
}

Json end_json(const PassEnd& end) { return {{"z_mm", end.z_mm}, {"r_mm", end.r_mm}, {"turns", end.turns}}; }

Json geodesic_json(const MeridianGeodesic& geodesic, double angle_deg, int points) {
  Json out = {{"angle_deg", angle_deg},
              {"clairaut_mm", geodesic.clairaut_mm()},
              {"first_end", end_json(geodesic.first())},
              {"last_end", end_json(geodesic.last())},
              {"turn_deg", degrees(geodesic.turn_rad())},
              {"length_mm", geodesic.length_mm()}};
  if (points > 0) {
    Json path = Json::array();
    for (const FibrePoint& point : geodesic.points(points)) {
      path.push_back({{"z_mm", point.z_mm},
                      {"r_mm", point.r_mm},
                      {"turn_deg", degrees(point.turn_rad)},
                      {"length_mm", point.length_mm},
                      {"angle_deg", degrees(point.angle_rad)}});
    }
    out["path"] = path;
  }
  return out;
}

std::string place_text(const MeridianPoint& at) {
  return "r " + short_number(at.r_mm, 6) + " mm at z " + short_number(at.z_mm, 6) + " mm";
}

std::string end_text(const PassEnd& end) {
  return (end.turns ? "turns at " : "runs off at ") + place_text({end.z_mm, end.r_mm, 0, 0});
}

std::string mandrel_text(const Meridian& meridian) {
  return "mandrel    z " + short_number(meridian.at(meridian.first()).z_mm, 6) + " ... " +
         short_number(meridian.at(meridian.last()).z_mm, 6) + " mm, meridian " +
         short_number(meridian.length_mm(), 6) + " mm long\n" + "widest     " +
         place_text(meridian.at(meridian.widest())) + "\n" + "ends       " +
         place_text(meridian.at(meridian.first())) + "; " + place_text(meridian.at(meridian.last())) + "\n";
}

std::string geodesic_text(const MeridianGeodesic& geodesic, double angle_deg) {
  return "geodesic   " + short_number(angle_deg) +
         " deg from the axis at the widest place, r sin(angle) = " + short_number(geodesic.clairaut_mm(), 6) +
         " mm\n" + "first end  " + end_text(geodesic.first()) + "\n" + "last end   " +
         end_text(geodesic.last()) + "\n" + "pass       turns the mandrel by " +
         short_number(degrees(geodesic.turn_rad()), 8) + " deg, lays " +
         short_number(geodesic.length_mm(), 7) + " mm\n";
}

}  // namespace

int wind_inspect(const Arguments& arguments) {
  const WindArguments& wind = arguments.wind;
  const Mandrel mandrel = read_mandrel(wind);
  const Meridian& meridian = mandrel.meridian;
  Json json = mandrel_json(meridian);
  json.update(mandrel.source);
  std::string text = mandrel_text(meridian) + mandrel.text;
  if (wind.angle_deg) {
    const double K = meridian.at(meridian.widest()).r_mm * std::sin(radians(*wind.angle_deg));
    const MeridianGeodesic geodesic(meridian, K, meridian.widest());
    json["geodesic"] = geodesic_json(geodesic, *wind.angle_deg, wind.points);
    text += geodesic_text(geodesic, *wind.angle_deg);
  }
  print(arguments.json ? json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n" : text);
  return 0;
}

}  // namespace afptraj::cli
