#include "io/coverage_csv.h"

#include "io/number_text.h"
#include "io/paths_csv.h"

namespace afptraj {

std::string tow_names(const TowSpot& spot) {
  std::string text;
  for (const auto& [course, tow] : spot.tows)
    text += (text.empty() ? "c" : " c") + std::to_string(course) + 't' + std::to_string(tow);
  return text;
}

std::string coverage_csv(const std::vector<Ply>& plies) {
  std::string text = "ply,kind,layers,area_mm2,length_mm,width_mm,x,y,z,face,boundary,tows\n";
  for (const Ply& ply : plies) {
    const std::string name = csv_field(ply.name);
    for (const TowSpot& spot : ply.report.tow_coverage.spots) {
      text += name + (spot.gap() ? ",gap," : ",overlap,") + std::to_string(spot.layers);
      for (const double x :
           {spot.area_mm2, spot.length_mm, spot.width_mm, spot.where.x(), spot.where.y(), spot.where.z()}) {
        text += ',';
        append_number(text, x);
      }
      text +=
          ',' + std::to_string(spot.face + 1) + (spot.at_boundary ? ",1," : ",0,") + tow_names(spot) + '\n';
    }
  }
  return text;
}

}  // namespace afptraj
