#include "io/machine_toml.h"

#include "geometry/error.h"
#include "io/text_file.h"
#include "io/toml_file.h"

namespace afptraj {
namespace {

constexpr double fastest = 1e6, largest = 1e7;
constexpr std::array<const char*, 3> dialects{"xab", "xyz", "rs274"};
// Of each dialect: carriage, mandrel, cross-feed, eye.
constexpr std::array<const char*, 3> letters{"XAYB", "XYAZ", "XAYB"};
constexpr const char* taken = "DFGHIJKLMNOPQRST";  // words of RS-274 that are no axes

Dialect dialect_of(const std::string& word) {
  std::size_t i = 0;
  while (word != dialects[i]) ++i;
  return static_cast<Dialect>(i);
}

MachineAxis read_axis(TomlTable table, char standard) {
  MachineAxis axis;
  const std::string letter = table.optional_text("letter").value_or(std::string(1, standard));
  if (letter.size() != 1 || letter[0] < 'A' || letter[0] > 'Z' ||
      std::string(taken).find(letter[0]) != std::string::npos) {
    table.fail("letter",
               "'" + printable(letter) + "' is no letter of an axis; use one of A B C E U V W X Y Z");
  }
  axis.letter = letter[0];
  if (const auto travel = table.optional_range("travel"))
    axis.lowest = travel->first, axis.highest = travel->second;
  axis.speed_per_s = table.number("speed", 1e-3, fastest);
  axis.acceleration_per_s2 = table.number("acceleration", 1e-3, largest);
  table.finish();
  return axis;
}

void refuse_shared_letters(const std::string& path, const MachineProfile& profile) {
  for (std::size_t i = 0; i < winder_axes; ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (!profile.axes[i] || !profile.axes[k] || profile.axes[i]->letter != profile.axes[k]->letter)
        continue;
      throw Error(ErrorCode::usage, path,
                  std::string(axis_names[k]) + " and " + axis_names[i] + " both have the letter " +
                      profile.axes[i]->letter + "; give each its own");
    }
  }
}

}  // namespace

MachineProfile read_machine(const std::string& path) {
  const toml::value root = parse_toml_file(path);
  TomlTable file(path, root, "the file");
  MachineProfile profile;
  profile.name = file.optional_text("name").value_or("");
  profile.dialect = dialect_of(file.word("dialect", {dialects.begin(), dialects.end()}, "xab"));
  profile.inches = file.word("unit", {"mm", "inch"}, "mm") == "inch";
  profile.roll_over = file.flag("roll_over", true);
  profile.eye_room.clearance_mm = file.number("clearance", 0.1, 10000);
  const char* standard = letters[static_cast<std::size_t>(profile.dialect)];
  profile.axes[0] = read_axis(file.table("carriage"), standard[0]);
  profile.axes[1] = read_axis(file.table("mandrel"), standard[1]);
  for (const std::size_t i : {2, 3}) {
    if (const auto table = file.optional_table(axis_names[i]))
      profile.axes[i] = read_axis(*table, standard[i]);
  }
  profile.eye_room.fixed_mm = file.optional_number("eye_distance", 0.1, 100000);
  const bool cross_feed = profile.axis(WinderAxis::cross_feed).has_value();
  if (cross_feed && profile.eye_room.fixed_mm)
    file.fail("eye_distance", "'eye_distance' is for machines without cross-feed; leave one of the two out");
  if (!cross_feed && !profile.eye_room.fixed_mm)
    throw Error(ErrorCode::usage, path,
                "the file has no [cross_feed]; say with 'eye_distance' how far from the axis the eye stands");
  file.finish();
  refuse_shared_letters(path, profile);
  return profile;
}

}  // namespace afptraj
