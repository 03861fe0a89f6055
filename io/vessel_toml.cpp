#include "io/vessel_toml.h"

#include <filesystem>

#include "io/toml_file.h"

namespace afptraj {
namespace {

std::string beside(const std::string& path, const std::filesystem::path& given) {
  return (given.is_absolute() ? given : std::filesystem::path(path).parent_path() / given).string();
}

VesselLayer read_layer(TomlTable& table) {
  VesselLayer layer;
  table.word("type", {"helical"}, "helical");
  layer.angle_deg = table.number("angle", 0.1, 89.9);
  if (table.word("angle_from", {"axis", "hoop"}, "axis") == "hoop") layer.angle_deg = 90 - layer.angle_deg;
  layer.tolerance_deg = table.optional_number("tolerance", 0, 45).value_or(layer.tolerance_deg);
  if (const auto overlap = table.optional_number("overlap", 0, 100)) layer.most_overlap = *overlap / 100;
  layer.circuits = table.optional_count("circuits", 2, 1000000);
  layer.stride = table.optional_count("stride", 0, 1000000);
  table.finish();
  return layer;
}

}  // namespace

VesselFile read_vessel(const std::string& path) {
  const toml::value root = parse_toml_file(path);
  TomlTable file(path, root, "the file");
  VesselFile vessel;
  if (const auto machine = file.optional_text("machine")) vessel.machine = beside(path, *machine);
  vessel.feed_mm_per_min = file.number("feed", 1e-3, 1e7);
  TomlTable mandrel = file.table("mandrel");
  vessel.mandrel = beside(path, mandrel.text("file"));
  vessel.faces = mandrel.optional_text("faces").value_or("");
  mandrel.finish();
  TomlTable tow = file.table("tow");
  vessel.tow.width_mm = tow.number("width", 0.01, 1000);
  vessel.tow.thickness_mm = tow.number("thickness", 1e-4, 100);
  tow.finish();
  for (TomlTable& layer : file.tables("layer")) vessel.layers.push_back(read_layer(layer));
  file.finish();
  return vessel;
}

}  // namespace afptraj
