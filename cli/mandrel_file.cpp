#include "cli/mandrel_file.h"

#include <filesystem>

#include "cli/part_file.h"
#include "cli/terminal.h"
#include "geometry/error.h"
#include "io/meridian_csv.h"
#include "io/text_file.h"
#include "io/wind_file.h"

namespace afptraj::cli {
namespace {

using Json = nlohmann::ordered_json;

Meridian meridian_of(const WindMandrel& mandrel) {
  return meridian_through({{0, mandrel.diameter_mm / 2},
                           {mandrel.length_mm, mandrel.end_diameter_mm.value_or(mandrel.diameter_mm) / 2}});
}

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

MandrelFile mandrel_of_part(const WindArguments& arguments) {
  const SkinMandrel found = read_part_mandrel(arguments.file, arguments.faces);
  return {found.meridian,
          {{"axis_origin", vector_json(found.origin)},
           {"axis_direction", vector_json(found.direction)},
           {"deviation_mm", found.deviation_mm}},
          "axis       deviation from a surface of revolution at most " + short_number(found.deviation_mm, 3) +
              " mm\n"};
}

}  // namespace

SkinMandrel read_part_mandrel(const std::string& path, const std::string& list) {
  require_readable_file(path);
  const auto part = std::make_shared<const Part>(read_part(path, {}).part);
  const Skin skin(part, mandrel_faces(part, list));
  // As good as a STEP file's own joints are.
  constexpr double tolerance_mm = 0.01;
  try {
    return mandrel_from_skin(skin, tolerance_mm);
  } catch (const Error& e) {
    throw Error(e.code(), path, e.what());
  }
}

MandrelFile read_mandrel(const VesselFile& vessel) {
  WindArguments mandrel;
  mandrel.file = vessel.mandrel;
  mandrel.faces = vessel.faces;
  return read_mandrel(mandrel);
}

MandrelFile read_mandrel(const WindArguments& arguments) {
  const std::filesystem::path kind = std::filesystem::path(arguments.file).extension();
  if (kind == ".toml") {
    if (!arguments.faces.empty())
      throw Error(ErrorCode::usage, "--face", "is for parts; give the faces in the file's [mandrel]");
    return read_mandrel(read_vessel(arguments.file));
  }
  if (kind != ".wind" && kind != ".csv") {
    return mandrel_of_part(arguments);
  }
  if (!arguments.faces.empty())
    throw Error(ErrorCode::usage, "--face", "is for parts; leave it out with " + kind.string() + " files");
  if (kind == ".csv") return {read_meridian(arguments.file), Json::object(), {}};
  return {meridian_of(read_wind_file(arguments.file, WindMode::native).mandrel), Json::object(), {}};
}

}  // namespace afptraj::cli
