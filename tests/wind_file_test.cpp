// The two readings of `.wind` files.
#include "io/wind_file.h"

#include <gtest/gtest.h>

#include "geometry/error.h"
#include "tests/temporary_directory.h"

namespace afptraj {
namespace {

const std::string helical_keys =
    R"("windAngle":35,"patternNumber":2,"skipIndex":1,"lockDegrees":180,"leadInMM":5,"leadOutDegrees":15)";

std::string file_of(const std::string& layers, const std::string& more = "") {
  return R"({"mandrelParameters":{"diameter":70,"windLength":100},"towParameters":{"width":7,"thickness":0.5},)"
         "\"defaultFeedRate\":9000,\"layers\":[\n" +
         layers + "]" + more + "}";
}

class WindFile : public testing::Test {
 protected:
  WindDefinition read(const std::string& text, WindMode mode) const {
    return read_wind_file(scratch_.write("a.wind", text), mode);
  }
  // What is said, with the file's directory left out of it.
  std::string refusal(const std::string& text, WindMode mode) const {
    try {
      read(text, mode);
      return "(read)";
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::bad_input);
      std::string all = e.where() + ": " + e.what();
      const std::string folder = scratch_.path().string() + "/";
      for (std::size_t at = 0; (at = all.find(folder)) != std::string::npos;) all.erase(at, folder.size());
      return all;
    }
  }
  test::TemporaryDirectory scratch_;
};

constexpr WindMode fiberpath = WindMode::fiberpath, native = WindMode::native;

TEST_F(WindFile, BothReadAll) {
  const std::string text =
      file_of(R"({"windType":"hoop","terminal":false},{"windType":"skip","mandrelRotation":-4.5},)"
              R"({"windType":"helical",)" +
                  helical_keys + R"(,"skipInitialNearLock":true})",
              R"(,"schemaVersion":"1.1")");
  for (const WindMode mode : {native, fiberpath}) {
    const WindDefinition definition = read(text, mode);
    EXPECT_EQ(definition.schema_version, "1.1");
    EXPECT_EQ(definition.mandrel.diameter_mm, 70);
    EXPECT_EQ(definition.mandrel.length_mm, 100);
    EXPECT_FALSE(definition.mandrel.end_diameter_mm);
    EXPECT_EQ(definition.tow.width_mm, 7);
    EXPECT_EQ(definition.tow.thickness_mm, 0.5);
    EXPECT_EQ(definition.feed_mm_per_min, 9000);
    ASSERT_EQ(definition.layers.size(), 3u);
    EXPECT_FALSE(std::get<HoopLayer>(definition.layers[0]).terminal);
    EXPECT_EQ(std::get<SkipLayer>(definition.layers[1]).rotation_deg, -4.5);
    const auto& helical = std::get<HelicalLayer>(definition.layers[2]);
    EXPECT_EQ(helical.angle_deg, 35);
    EXPECT_EQ(helical.pattern, 2);
    EXPECT_EQ(helical.skip, 1);
    EXPECT_EQ(helical.lock_deg, 180);
    EXPECT_EQ(helical.lead_in_mm, 5);
    EXPECT_EQ(helical.lead_out_deg, 15);
    EXPECT_TRUE(helical.skip_initial_near_lock);
  }
}

// 55 degrees from the hoop direction are 35 from the axis, and are never taken for the other.
TEST_F(WindFile, AnglesFromTheHoopDirection) {
  const auto layer = [&](const std::string& keys) {
    return file_of(R"({"windType":"helical",)" + helical_keys + keys + "}");
  };
  const auto angle = [&](const std::string& keys, WindMode mode) {
    return std::get<HelicalLayer>(read(layer(keys), mode).layers[0]).angle_deg;
  };
  EXPECT_EQ(angle(R"(,"angleFrom":"hoop")", native), 55);
  EXPECT_EQ(angle(R"(,"angleFrom":"axis")", native), 35);
  EXPECT_EQ(angle(R"(,"angleFrom":"axis")", fiberpath), 35);
  EXPECT_NE(refusal(layer(R"(,"angleFrom":"hoop")"), fiberpath).find("measures windAngle from the axis"),
            std::string::npos);
  EXPECT_NE(refusal(layer(R"(,"angleFrom":"pole")"), native).find("must be \"axis\" or \"hoop\""),
            std::string::npos);
}

TEST_F(WindFile, FiberPathReadsLaxly) {
  const WindDefinition definition = read(
      R"({"mandrel_parameters":{"diameter":" 7_0.0e0 ","wind_length":true,"end_diameter":null,"bogus":1},)"
      R"("towParameters":{"width":1,"width":"9e3","thickness":1},"default_feed_rate":"+5",)"
      R"("schema_version":" 1.99 ","layers":[{"wind_type":"hoop","terminal":"Yes","foo":{}},)"
      R"({"windType":"helical","windAngle":"35","patternNumber":4.0,"skipIndex":"3.0","lockDegrees":180,)"
      R"("leadInMM":5,"lead_out_degrees":15,"skipInitialNearLock":"off"}]})",
      fiberpath);
  EXPECT_EQ(definition.mandrel.diameter_mm, 70);
  EXPECT_EQ(definition.mandrel.length_mm, 1);
  EXPECT_EQ(definition.tow.width_mm, 9000);
  EXPECT_EQ(definition.feed_mm_per_min, 5);
  EXPECT_EQ(definition.schema_version, "1.99");
  EXPECT_TRUE(std::get<HoopLayer>(definition.layers[0]).terminal);
  EXPECT_EQ(std::get<HelicalLayer>(definition.layers[1]).pattern, 4);
  EXPECT_EQ(std::get<HelicalLayer>(definition.layers[1]).skip, 3);
  EXPECT_FALSE(std::get<HelicalLayer>(definition.layers[1]).skip_initial_near_lock);
}

TEST_F(WindFile, FiberPathsWords) {
  const auto line = [&](const std::string& text) { return refusal(text, fiberpath); };
  const std::string failed = "a.wind: Wind definition at a.wind failed validation: ",
                    visit = "\n    For further information visit https://errors.pydantic.dev/2.10/v/";
  EXPECT_EQ(
      line(file_of(R"({"windType":"polar"})")),
      failed +
          "1 validation error for WindDefinition\nlayers.0\n  Input tag 'polar' found using 'wind_type' | "
          "'windType' does not match any of the expected tags: 'hoop', 'helical', 'skip' "
          "[type=union_tag_invalid, input_value={'windType': 'polar'}, input_type=dict]" +
          visit + "union_tag_invalid");
  EXPECT_EQ(
      line(file_of("{}")),
      failed +
          "1 validation error for WindDefinition\nlayers.0\n  Unable to extract tag using discriminator "
          "'wind_type' | 'windType' [type=union_tag_not_found, input_value={}, input_type=dict]" +
          visit + "union_tag_not_found");
  EXPECT_EQ(line("[]"), failed +
                            "1 validation error for WindDefinition\n  Input should be a valid dictionary or "
                            "instance of WindDefinition [type=model_type, input_value=[], input_type=list]" +
                            visit + "model_type");
  EXPECT_EQ(line(file_of("", R"(,"schemaVersion":1.0)")),
            failed +
                "1 validation error for WindDefinition\nschemaVersion\n  Input should be a valid string "
                "[type=string_type, input_value=1.0, input_type=float]" +
                visit + "string_type");
  EXPECT_EQ(line(file_of("", R"(,"schemaVersion":"2.0")")),
            failed +
                "1 validation error for WindDefinition\nschemaVersion\n  String should match pattern "
                "'^1\\.\\d+$' [type=string_pattern_mismatch, input_value='2.0', input_type=str]" +
                visit + "string_pattern_mismatch");
  EXPECT_EQ(line(file_of(R"({"windType":"skip"})", R"(,"defaultFeedRate":-1)")),
            failed +
                "2 validation errors for WindDefinition\ndefaultFeedRate\n  Input should be greater than 0 "
                "[type=greater_than, input_value=-1, input_type=int]" +
                visit +
                "greater_than\nlayers.0.skip.mandrelRotation\n  Field required [type=missing, "
                "input_value={'windType': 'skip'}, input_type=dict]" +
                visit + "missing");
  EXPECT_NE(
      line(file_of(R"({"windType":"helical","windAngle":35,"patternNumber":2.5,"skipIndex":1,)"
                   R"("lockDegrees":180,"leadInMM":5,"leadOutDegrees":15})"))
          .find("layers.0.helical.patternNumber\n  Input should be a valid integer, got a number with a "
                "fractional part [type=int_from_float, input_value=2.5, input_type=float]"),
      std::string::npos);
  EXPECT_EQ(
      line("{\"a\": 1,\n  oops}"),
      "a.wind: Invalid JSON in a.wind: Expecting property name enclosed in double quotes: line 2 column 3 "
      "(char 11)");
  EXPECT_EQ(line("{} x"), "a.wind: Invalid JSON in a.wind: Extra data: line 1 column 4 (char 3)");
}

TEST_F(WindFile, NativeNamesPlaceAndCure) {
  const auto line = [&](const std::string& text) { return refusal(text, native); };
  EXPECT_EQ(line("{\n \"layres\": []\n}"),
            "a.wind:2:2: unknown key 'layres' in the file; did you mean 'layers'?");
  EXPECT_EQ(line(file_of(R"({"windType":"hoop","wind_angle":3})")),
            "a.wind:2:20: unknown key 'wind_angle' in layer 1; known are windType, terminal");
  EXPECT_EQ(line(file_of(R"({"windType":"helical","wind_angle":35,)" + helical_keys.substr(15) + "}")),
            "a.wind:2:23: unknown key 'wind_angle' in layer 1; did you mean 'windAngle'?");
  EXPECT_EQ(line(file_of(R"({"windType":"polar"})")),
            "a.wind:2:13: unknown windType 'polar'; use hoop, helical or skip");
  EXPECT_EQ(line(file_of(R"({"windtype":"hoop"})")),
            "a.wind:2:2: unknown key 'windtype'; did you mean 'windType'?");
  EXPECT_EQ(line(file_of(R"({"windType":"skip"})")), "a.wind:2:1: layer 1 lacks 'mandrelRotation'; add it");
  EXPECT_NE(line(file_of(R"({"windType":"hoop","terminal":"yes"})")).find("is a text; write true or false"),
            std::string::npos);
  EXPECT_NE(line(file_of("", R"(,"defaultFeedRate":1)")).find("'defaultFeedRate' stands twice"),
            std::string::npos);
  const auto with_mandrel = [&](const std::string& mandrel) {
    return line(R"({"mandrelParameters":)" + mandrel +
                R"(,"towParameters":{"width":7,"thickness":0.5},"defaultFeedRate":9000,"layers":[]})");
  };
  EXPECT_NE(with_mandrel(R"({"diameter":"70","windLength":100})").find("write a number without quotes"),
            std::string::npos);
  EXPECT_NE(with_mandrel(R"({"diameter":NaN,"windLength":100})").find("is not finite"), std::string::npos);
  EXPECT_NE(with_mandrel(R"({"diameter":-5,"windLength":100})")
                .find("'diameter' is -5.0; it must be greater than 0"),
            std::string::npos);
  EXPECT_NE(with_mandrel("[]").find("mandrelParameters is a list; it must be an object"), std::string::npos);
  EXPECT_EQ(line("{\n\"layers\": [,]}"), "a.wind:2:12: is not JSON: Expecting value; correct the file there");
  EXPECT_NE(line(std::string(100000, '[')).find("Nested too deep"), std::string::npos);
  EXPECT_NE(line("").find("Expecting value"), std::string::npos);
}

}  // namespace
}  // namespace afptraj
