#include "cli/part_file.h"

#include <algorithm>

#include "cli/signals.h"
#include "cli/terminal.h"
#include "geometry/error.h"
#include "geometry/face_facts.h"
#include "io/nearest_name.h"
#include "io/text_file.h"

namespace afptraj::cli {
namespace {

std::string one_based(const std::vector<int>& faces) {
  std::string text;
  for (std::size_t i = 0; i < faces.size();) {
    std::size_t j = i;
    while (j + 1 < faces.size() && faces[j + 1] == faces[j] + 1) ++j;
    if (!text.empty()) text += ",";
    text += std::to_string(faces[i] + 1);
    if (j > i) text += (j == i + 1 ? "," : "-") + std::to_string(faces[j] + 1);
    i = j + 1;
  }
  return text;
}

std::vector<int> to_indices(const Part& part, const std::vector<int>& numbers, const char* flag) {
  std::vector<int> faces;
  for (const int n : numbers) {
    if (n > static_cast<int>(part.faces.size())) {
      throw Error(ErrorCode::usage, flag,
                  "face " + std::to_string(n) + " does not exist; the part has faces 1 to " +
                      std::to_string(part.faces.size()) + " (afptraj inspect)");
    }
    faces.push_back(n - 1);
  }
  return faces;
}

std::vector<int> faces_of_name(const Part& part, const std::string& name) {
  std::vector<int> faces;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < part.faces.size(); ++i) {
    if (part.faces[i].name == name) faces.push_back(static_cast<int>(i));
    if (!part.faces[i].name.empty()) names.push_back(part.faces[i].name);
  }
  if (faces.empty()) {
    const std::string hint = did_you_mean(name, names);
    throw Error(ErrorCode::usage, "--face-name",
                "no face is named '" + printable(name) + "'" +
                    (!hint.empty()   ? hint
                     : names.empty() ? "; the file names no faces, choose by number with --face"
                                     : "; afptraj inspect lists the names"));
  }
  return faces;
}

}  // namespace

void check_stop() {
  if (stop_signal() != 0) throw Stopped{};
}

StepModel read_part(const std::string& path, const Job& job) {
  StepReadOptions options;
  options.unit_override = job.unit;
  options.sew_tolerance_mm = job.sew_tolerance_mm;
  options.stop = [] { return stop_signal() != 0; };
  try {
    StepModel model = read_step(path, options);
    check_stop();
    return model;
  } catch (const Error&) {
    check_stop();
    throw;
  }
}

std::vector<std::shared_ptr<const TrimRegion>> trim_regions(const Part& part) {
  std::vector<std::shared_ptr<const TrimRegion>> regions;
  for (const Face& face : part.faces) {
    check_stop();
    regions.push_back(std::make_shared<const TrimRegion>(face));
  }
  return regions;
}

ChosenFaces choose_faces(const std::shared_ptr<const Part>& part, const FaceChoice& choice,
                         const std::vector<PlyOrientation>& plies) {
  if (!choice.numbers.empty()) {
    return {to_indices(*part, choice.numbers, "--face"), "by number"};
  }
  if (!choice.name.empty()) {
    return {faces_of_name(*part, choice.name), "by name '" + printable(choice.name) + "'"};
  }
  const std::string smooth =
      " over edges smoother than " + short_number(choice.tangent_angle_rad * 180 / pi) + " deg";
  if (!choice.tangent_from.empty()) {
    const std::vector<int> seeds = to_indices(*part, choice.tangent_from, "--tangent-from");
    return {grow_tangent(*part, seeds, choice.tangent_angle_rad), "grown from " + one_based(seeds) + smooth};
  }
  if (part->faces.size() == 1) return {{0}, "the only face"};
  std::vector<Vec3> points;
  for (const PlyOrientation& ply : plies) {
    for (const PlyPoint& point : ply.points) points.push_back(point.position);
  }
  const auto group = nearest_tangent_group(part, trim_regions(*part), points, choice.tangent_angle_rad);
  if (group.empty())
    throw Error(ErrorCode::bad_input, "part", "has no face near the ply points; choose faces with --face");
  return {group, "tangent-connected group nearest to the ply points," + smooth};
}

}  // namespace afptraj::cli
