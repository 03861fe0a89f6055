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
  layer.hoop = table.word("type", {"helical", "hoop"}, "helical") == "hoop";
  if (layer.hoop) {
    table.finish();
    return layer;
  }
  layer.angle_deg = table.number("angle", 0.1, 89.9);
  if (table.word("angle_from", {"axis", "hoop"}, "axis") == "hoop") layer.angle_deg = 90 - layer.angle_deg;
  layer.tolerance_deg = table.optional_number("tolerance", 0, 45).value_or(layer.tolerance_deg);
  if (const auto overlap = table.optional_number("overlap", 0, 100)) layer.most_overlap = *overlap / 100;
  layer.circuits = table.optional_count("circuits", 2, 1000000);
  layer.stride = table.optional_count("stride", 0, 1000000);
  layer.steering.friction = table.optional_number("friction", 0, 1).value_or(0);
  layer.steering.opening_first_mm = table.optional_number("opening_first", 0.01, 1e6);
  layer.steering.opening_last_mm = table.optional_number("opening_last", 0.01, 1e6);
  for (const auto& [key, opening] : {std::pair{"opening_first", layer.steering.opening_first_mm},
                                     {"opening_last", layer.steering.opening_last_mm}}) {
    if (opening && layer.steering.friction == 0)
      table.fail(key, std::string("'") + key +
                          "' needs friction to steer the fibre there; give friction, such as 0.2");
  }
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
  vessel.growth = file.flag("growth", true);
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
