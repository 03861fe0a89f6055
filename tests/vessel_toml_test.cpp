#include "io/vessel_toml.h"

#include <gtest/gtest.h>

#include "geometry/error.h"
#include "tests/temporary_directory.h"

namespace afptraj {
namespace {

const std::string two_layers =
    "machine = 'm/winder.toml'\nfeed = 9000\n"
    "[mandrel]\nfile = 'tank.csv'\n"
    "[tow]\nwidth = 8\nthickness = 0.3\n"
    "[[layer]]\nangle = 20\ntolerance = 2\n"
    "[[layer]]\ntype = 'helical'\nangle = 35\nangle_from = 'hoop'\noverlap = 4\ncircuits = 80\nstride = 7\n"
    "friction = 0.2\nopening_first = 30\nopening_last = 45\n";

VesselFile read(const std::string& content) {
  const test::TemporaryDirectory directory;
  return read_vessel(directory.write("vessel.toml", content));
}

TEST(VesselToml, ReadsAVessel) {
  const test::TemporaryDirectory directory;
  const VesselFile vessel = read_vessel(directory.write("vessel.toml", two_layers));
  EXPECT_EQ(vessel.mandrel, (directory.path() / "tank.csv").string());
  EXPECT_EQ(vessel.machine, (directory.path() / "m/winder.toml").string());
  EXPECT_EQ(vessel.faces, "");
  EXPECT_EQ(vessel.feed_mm_per_min, 9000);
  EXPECT_EQ(vessel.tow.width_mm, 8);
  EXPECT_EQ(vessel.tow.thickness_mm, 0.3);
  ASSERT_EQ(vessel.layers.size(), 2u);
  EXPECT_EQ(vessel.layers[0].angle_deg, 20);
  EXPECT_EQ(vessel.layers[0].tolerance_deg, 2);
  EXPECT_EQ(vessel.layers[0].most_overlap, 0.1);
  EXPECT_FALSE(vessel.layers[0].circuits);
  EXPECT_EQ(vessel.layers[1].angle_deg, 55);
  EXPECT_EQ(vessel.layers[1].tolerance_deg, 1);
  EXPECT_DOUBLE_EQ(vessel.layers[1].most_overlap, 0.04);
  EXPECT_EQ(vessel.layers[1].circuits, 80);
  EXPECT_EQ(vessel.layers[1].stride, 7);
  EXPECT_EQ(vessel.layers[0].steering.friction, 0);
  EXPECT_FALSE(vessel.layers[0].steering.opening_first_mm);
  EXPECT_EQ(vessel.layers[1].steering.friction, 0.2);
  EXPECT_EQ(vessel.layers[1].steering.opening_first_mm, 30);
  EXPECT_EQ(vessel.layers[1].steering.opening_last_mm, 45);
}

std::string refusal(const std::string& content) {
  try {
    read(content);
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::usage);
    return e.where().substr(e.where().find("vessel.toml")) + ": " + e.what();
  }
  return "";
}

TEST(VesselToml, ReadsHoopsAndGrowth) {
  const std::string hoops = two_layers + "[[layer]]\ntype = 'hoop'\n";
  EXPECT_TRUE(read(hoops).growth);
  EXPECT_FALSE(read("growth = false\n" + hoops).growth);
  EXPECT_FALSE(read(hoops).layers[1].hoop);
  EXPECT_TRUE(read(hoops).layers[2].hoop);
}

TEST(VesselToml, NamesEveryDefect) {
  const struct {
    std::string what, instead, message;
  } defects[] = {
      {"feed = 9000", "fede = 9000", "feed"},
      {"feed = 9000", "feed = 0", "vessel.toml:2:1: 'feed' in the file is 0; it must lie in"},
      {"width = 8", "width = -8", "vessel.toml:6:1: 'width' in [tow] is -8; it must lie in"},
      {"[mandrel]\nfile = 'tank.csv'\n", "", "the file lacks 'mandrel'"},
      {"tolerance = 2", "tolerence = 2", "did you mean 'tolerance'?"},
      {"'helical'", "'hoop'", "unknown key 'angle' in [[layer]] number 2"},
      {"feed = 9000", "growth = 1\nfeed = 9000", "'growth' in the file must be true or false"},
      {"'hoop'\n", "'pole'\n", "'pole'"},
      {"angle = 20", "angle = 90", "'angle' in [[layer]] number 1 is 90"},
      {"circuits = 80", "circuits = 1", "circuits"},
      {"stride = 7", "stride = 7.5", "stride"},
      {"friction = 0.2", "friction = 2", "'friction' in [[layer]] number 2 is 2; it must lie in"},
      {"friction = 0.2\n", "", "vessel.toml:18:1: 'opening_first' needs friction to steer the fibre there"},
  };
  for (const auto& [what, instead, message] : defects) {
    std::string text = two_layers;
    text.replace(text.find(what), what.size(), instead);
    EXPECT_NE(refusal(text).find(message), std::string::npos) << refusal(text);
  }
  EXPECT_NE(refusal(two_layers.substr(0, two_layers.find("[[layer]]"))).find("layer"), std::string::npos);
}

}  // namespace
}  // namespace afptraj
