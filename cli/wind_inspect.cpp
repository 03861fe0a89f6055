#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/mandrel_file.h"
#include "cli/terminal.h"
#include "cli/wind_commands.h"
#include "winding/frustum.h"
#include "winding/meridian_geodesic.h"

namespace afptraj::cli {
namespace {

using Json = nlohmann::ordered_json;

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
  const MandrelFile mandrel = read_mandrel(wind);
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
