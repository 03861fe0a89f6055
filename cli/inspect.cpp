#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "cli/part_file.h"
#include "cli/signals.h"
#include "cli/terminal.h"
#include "geometry/face_facts.h"
#include "geometry/revolution.h"
#include "io/number_text.h"
#include "io/text_file.h"

namespace afptraj::cli {
namespace {

using Json = nlohmann::ordered_json;

struct InspectedFace {
  FaceFacts facts;
  std::optional<Revolution> revolution;
  int group = 0;  // of tangent-connected faces, from 1
  Vec3 size() const { return facts.box_max - facts.box_min; }
};

struct Inspection {
  StepModel model;
  std::vector<InspectedFace> faces;
  int groups = 0;
  Vec3 box_min, box_max;
  std::vector<std::string> warnings;
};

// A B-spline counts as turned when it is so to this share of its size, and at least to 0.01 mm.
double revolution_tolerance(const InspectedFace& face) { return std::max(0.01, 1e-5 * face.size().norm()); }

Inspection inspect_part(const Arguments& arguments) {
  Job job;
  for (const JobFlag& flag : arguments.job_flags) set_job_key(job, flag.key, flag.text, flag.flag);
  Inspection out;
  out.model = read_part(arguments.part, job);
  const Part& part = out.model.part;
  const auto trim = trim_regions(part);
  out.box_min.setConstant(std::numeric_limits<double>::infinity());
  out.box_max = -out.box_min;
  out.faces.resize(part.faces.size());
  for (std::size_t i = 0; i < part.faces.size(); ++i) {
    check_stop();
    InspectedFace& face = out.faces[i];
    face.facts = face_facts(part, static_cast<int>(i), *trim[i]);
    face.revolution = find_revolution(part, static_cast<int>(i), *trim[i], revolution_tolerance(face));
    out.box_min = out.box_min.cwiseMin(face.facts.box_min);
    out.box_max = out.box_max.cwiseMax(face.facts.box_max);
  }
  for (std::size_t i = 0; i < part.faces.size(); ++i) {
    if (out.faces[i].group != 0) continue;
    ++out.groups;
    for (const int member :
         grow_tangent(part, {static_cast<int>(i)}, arguments.tangent_angle_deg * pi / 180)) {
      out.faces[static_cast<std::size_t>(member)].group = out.groups;
    }
  }
  out.warnings = out.model.warnings;
  return out;
}

std::string degree_text(const Surface& surface) {
  const BSplineSurface* spline = surface.spline();
  if (spline == nullptr) return "";
  return std::to_string(spline->degree_u) + "x" + std::to_string(spline->degree_v) +
         (spline->weights.empty() ? "" : " rat.");
}

std::string poles_text(const Surface& surface) {
  const BSplineSurface* spline = surface.spline();
  return spline == nullptr ? "" : std::to_string(spline->count_u()) + "x" + std::to_string(spline->count_v());
}

std::string numbers_text(const std::vector<int>& faces) {
  constexpr std::size_t most = 8;
  std::string text;
  for (std::size_t i = 0; i < std::min(most, faces.size()); ++i)
    text += (i == 0 ? "" : ",") + std::to_string(faces[i] + 1);
  if (faces.size() > most) text += ",+" + std::to_string(faces.size() - most);
  return text;
}

std::string size_text(const Vec3& size) {
  return short_number(size.x()) + " x " + short_number(size.y()) + " x " + short_number(size.z());
}

std::string vector_text(const Vec3& v) {
  return "(" + short_number(std::abs(v.x()) < 1e-9 ? 0 : v.x()) + " " +
         short_number(std::abs(v.y()) < 1e-9 ? 0 : v.y()) + " " +
         short_number(std::abs(v.z()) < 1e-9 ? 0 : v.z()) + ")";
}

std::string revolution_text(const Revolution& r) {
  return "axis " + vector_text(r.direction) + " through " + vector_text(r.point) + ", radius " +
         short_number(r.radius_min_mm) + " ... " + short_number(r.radius_max_mm) + " over " +
         short_number(r.profile.back().x() - r.profile.front().x()) +
         (r.deviation_mm > 0 ? ", to " + short_number(r.deviation_mm, 2) : "");
}

std::string human_text(const Arguments& arguments, const Inspection& inspection) {
  const StepModel& model = inspection.model;
  const std::string unit = model.declared_unit.empty() ? "no unit declared" : model.declared_unit;
  std::string out = printable(arguments.part, 200) + ": " + std::to_string(inspection.faces.size()) +
                    " faces in " + std::to_string(inspection.groups) + " smooth groups, " +
                    std::to_string(model.solids) + " solids, " + std::to_string(model.shells) + " shells; " +
                    size_text(inspection.box_max - inspection.box_min) + " mm; schema " +
                    printable(model.schema) + ", " + printable(unit) +
                    " (1 unit = " + short_number(model.unit_scale_to_mm, 7) + " mm)\n";
  if (model.sewn_edges > 0) {
    out += "sewn: " + std::to_string(model.sewn_edges) + " edges within " +
           short_number(model.sew_tolerance_mm) + " mm, greatest gap " +
           short_number(model.greatest_sewn_gap_mm, 3) + " mm\n";
  }
  Table table({"face", "id", "name", "kind", "degree", "poles", "area mm2", "size mm", "min R mm", "holes",
               "group", "neighbours", "revolution"},
              {true, true, false, false, false, false, true, false, true, true, true, false, false});
  for (std::size_t i = 0; i < inspection.faces.size(); ++i) {
    const Face& face = model.part.faces[i];
    const InspectedFace& seen = inspection.faces[i];
    table.add(
        {std::to_string(i + 1), face.step_id > 0 ? "#" + std::to_string(face.step_id) : "",
         printable(face.name, 24), to_string(face.surface.kind()), degree_text(face.surface),
         poles_text(face.surface), short_number(seen.facts.area_mm2), size_text(seen.size()),
         std::isinf(seen.facts.smallest_radius_mm) ? "flat" : short_number(seen.facts.smallest_radius_mm),
         std::to_string(seen.facts.holes), std::to_string(seen.group), numbers_text(seen.facts.neighbours),
         seen.revolution ? revolution_text(*seen.revolution) : ""});
  }
  return out + table.text();
}

Json vector_json(const Vec3& v) {
  return Json::array({rounded_number(v.x()), rounded_number(v.y()), rounded_number(v.z())});
}

Json face_json(const Face& face, const InspectedFace& seen, std::size_t index) {
  Json neighbours = Json::array();
  for (const int n : seen.facts.neighbours) neighbours.push_back(n + 1);
  Json out = {{"face", index + 1},
              {"step_id", face.step_id},
              {"name", face.name},
              {"instance", face.instance},
              {"kind", to_string(face.surface.kind())}};
  if (const BSplineSurface* spline = face.surface.spline()) {
    out["degree"] = {spline->degree_u, spline->degree_v};
    out["poles"] = {spline->count_u(), spline->count_v()};
    out["rational"] = !spline->weights.empty();
  }
  out["area_mm2"] = rounded_number(seen.facts.area_mm2, 3);
  out["box_min"] = vector_json(seen.facts.box_min);
  out["box_max"] = vector_json(seen.facts.box_max);
  out["smallest_radius_mm"] = std::isinf(seen.facts.smallest_radius_mm)
                                  ? Json()
                                  : Json(rounded_number(seen.facts.smallest_radius_mm, 6));
  out["holes"] = seen.facts.holes;
  out["neighbours"] = neighbours;
  out["group"] = seen.group;
  if (seen.revolution) {
    Json profile = Json::array();
    for (const auto& point : seen.revolution->profile) {
      profile.push_back(Json::array({rounded_number(point.x()), rounded_number(point.y())}));
    }
    out["revolution"] = {{"axis_point", vector_json(seen.revolution->point)},
                         {"axis_direction", vector_json(seen.revolution->direction)},
                         {"deviation_mm", rounded_number(seen.revolution->deviation_mm)},
                         {"radius_min_mm", rounded_number(seen.revolution->radius_min_mm)},
                         {"radius_max_mm", rounded_number(seen.revolution->radius_max_mm)},
                         {"profile", profile}};
  } else {
    out["revolution"] = nullptr;
  }
  return out;
}

std::string json_text(const Arguments& arguments, const Inspection& inspection) {
  const StepModel& model = inspection.model;
  Json out = {{"part", arguments.part},
              {"sha256", model.sha256},
              {"schema", model.schema},
              {"declared_unit", model.declared_unit},
              {"unit_scale_to_mm", model.unit_scale_to_mm},
              {"solids", model.solids},
              {"shells", model.shells},
              {"sewn_edges", model.sewn_edges},
              {"box_min", vector_json(inspection.box_min)},
              {"box_max", vector_json(inspection.box_max)},
              {"groups", inspection.groups}};
  Json faces = Json::array();
  for (std::size_t i = 0; i < inspection.faces.size(); ++i) {
    faces.push_back(face_json(model.part.faces[i], inspection.faces[i], i));
  }
  out["faces"] = faces;
  out["warnings"] = inspection.warnings;
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

int inspect(const Arguments& arguments) {
  const Inspection inspection = inspect_part(arguments);
  for (const std::string& warning : inspection.warnings) print_warning(arguments.part, warning);
  print(arguments.json ? json_text(arguments, inspection) : human_text(arguments, inspection));
  return 0;
}

}  // namespace afptraj::cli
