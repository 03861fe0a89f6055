#include "io/machine_toml.h"

#include <gtest/gtest.h>

#include "geometry/error.h"
#include "tests/temporary_directory.h"

namespace afptraj {
namespace {

const std::string four_axes =
    "name = 'bench'\nclearance = 30\n"
    "[carriage]\ntravel = [-100, 900]\nspeed = 400\nacceleration = 1500\n"
    "[mandrel]\nspeed = 720\nacceleration = 2000\n"
    "[cross_feed]\nspeed = 200\nacceleration = 1000\n"
    "[eye]\nspeed = 360\nacceleration = 3000\n";

MachineProfile read(const std::string& content) {
  const test::TemporaryDirectory directory;
  return read_machine(directory.write("winder.toml", content));
}

std::string refusal(const std::string& content) {
  try {
    read(content);
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::usage);
    return e.where().substr(e.where().find("winder.toml")) + ": " + e.what();
  }
  return "";
}

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  return text.replace(text.find(what), what.size(), with);
}

TEST(MachineToml, ReadsAMachine) {
  const MachineProfile machine = read(four_axes);
  EXPECT_EQ(machine.name, "bench");
  EXPECT_EQ(machine.dialect, Dialect::xab);
  EXPECT_FALSE(machine.inches);
  EXPECT_TRUE(machine.roll_over);
  EXPECT_EQ(machine.eye_room.clearance_mm, 30);
  EXPECT_FALSE(machine.eye_room.fixed_mm);
  std::string letters;
  for (const auto& axis : machine.axes) letters += axis->letter;
  EXPECT_EQ(letters, "XAYB");
  EXPECT_EQ(machine.axes[0]->lowest, -100);
  EXPECT_EQ(machine.axes[0]->highest, 900);
  EXPECT_EQ(machine.axes[1]->speed_per_s, 720);
  EXPECT_EQ(machine.axes[3]->acceleration_per_s2, 3000);
}

TEST(MachineToml, DialectsAndLetters) {
  std::string letters;
  for (const auto& axis : read("dialect = 'xyz'\n" + four_axes).axes) letters += axis->letter;
  EXPECT_EQ(letters, "XYAZ");
  const MachineProfile machine =
      read("dialect = 'rs274'\nunit = 'inch'\nroll_over = false\neye_distance = 200\n" +
           replaced(replaced(four_axes, "[eye]", "[eye]\nletter = 'C'"),
                    "[cross_feed]\nspeed = 200\nacceleration = 1000\n", ""));
  EXPECT_EQ(machine.dialect, Dialect::rs274);
  EXPECT_TRUE(machine.inches);
  EXPECT_FALSE(machine.roll_over);
  EXPECT_EQ(machine.axes[3]->letter, 'C');
  EXPECT_EQ(machine.eye_room.fixed_mm, 200);
}

TEST(MachineToml, Refuses) {
  EXPECT_EQ(refusal(replaced(four_axes, "travel", "travle")),
            "winder.toml:4:1: unknown key 'travle' in [carriage]; did you mean 'travel'?");
  EXPECT_EQ(refusal(replaced(four_axes, "speed = 400", "speed = -4")),
            "winder.toml:5:1: 'speed' in [carriage] is -4; it must lie in 0.001 ... 1e+06");
  EXPECT_EQ(refusal(replaced(four_axes, "speed = 400", "speed = '4'")),
            "winder.toml:5:1: 'speed' in [carriage] must be a number; write it without quotes");
  EXPECT_EQ(refusal(replaced(four_axes, "speed = 400\n", "")),
            "winder.toml: [carriage] lacks 'speed'; write it there");
  EXPECT_EQ(refusal(replaced(four_axes, "[-100, 900]", "[900, -100]")),
            "winder.toml:4:1: 'travel' in [carriage] runs backward; write [lowest, highest]");
  EXPECT_EQ(refusal("dialect = 'xac'\n" + four_axes),
            "winder.toml:1:1: 'dialect' in the file is 'xac'; did you mean 'xab'?");
  EXPECT_EQ(refusal(replaced(four_axes, "[eye]", "[eye]\nletter = 'X'")),
            "winder.toml: carriage and eye both have the letter X; give each its own");
  EXPECT_EQ(refusal(replaced(four_axes, "[eye]", "[eye]\nletter = 'F'")),
            "winder.toml:14:1: 'F' is no letter of an axis; use one of A B C E U V W X Y Z");
  EXPECT_EQ(refusal("eye_distance = 100\n" + four_axes),
            "winder.toml:1:1: 'eye_distance' is for machines without cross-feed; leave one of the two out");
  EXPECT_EQ(refusal(replaced(four_axes, "[cross_feed]\nspeed = 200\nacceleration = 1000\n", "")),
            "winder.toml: the file has no [cross_feed]; say with 'eye_distance' how far from the axis the "
            "eye stands");
  EXPECT_NE(refusal("clearance = \n"), "");
  EXPECT_NE(refusal(""), "");
}

}  // namespace
}  // namespace afptraj
