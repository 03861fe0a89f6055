#include "io/job_toml.h"

#include <gtest/gtest.h>

#include <locale>

#include "geometry/error.h"
#include "tests/temporary_directory.h"

namespace afptraj {
namespace {

Job read(const std::string& content) {
  const test::TemporaryDirectory directory;
  return read_job(directory.write("job.toml", content));
}

TEST(JobToml, EmptyFileGivesTheDefaults) {
  const Job job = read("# nothing\n");
  EXPECT_EQ(job.plan.tow_width_mm, 6.35);
  EXPECT_EQ(job.plan.tows, 8);
  EXPECT_EQ(job.plan.step_mm, 2);
  EXPECT_EQ(job.plan.min_steering_radius_mm, 635);
  EXPECT_DOUBLE_EQ(job.plan.angle_limit_rad, 5 * pi / 180);
  EXPECT_TRUE(job.faces.numbers.empty());
}

TEST(JobToml, ReadsEveryKindOfValue) {
  const Job job = read(
      "[material]\ntow_width = 12.7\n"
      "[head]\ntows = 4\n"
      "[planning]\nstep = 1          # an integer is a number\n"
      "[limits]\nmax_angle_deviation = 90\nmin_coverage = 0.5\n"
      "[faces]\nlist = \"3, 5-7\"\n"
      "[input]\nunit = \"in\"\nsew_tolerance = 0\n"
      "[output]\ndirectory = 'out'\n");
  EXPECT_EQ(job.plan.tow_width_mm, 12.7);
  EXPECT_EQ(job.plan.tows, 4);
  EXPECT_EQ(job.plan.step_mm, 1);
  EXPECT_DOUBLE_EQ(job.plan.angle_limit_rad, pi / 2);
  EXPECT_EQ(job.min_coverage, 0.5);
  EXPECT_EQ(job.faces.numbers, (std::vector<int>{3, 5, 6, 7}));
  EXPECT_EQ(job.unit, "in");
  EXPECT_EQ(job.sew_tolerance_mm, 0);
  EXPECT_EQ(job.output_directory, "out");
  EXPECT_EQ(read("[faces]\nlist = [9, 2, 2]\n").faces.numbers, (std::vector<int>{2, 9}));
  EXPECT_EQ(read("[faces]\ntangent_from = 4\n").faces.tangent_from, (std::vector<int>{4}));
}

struct Defect {
  const char* name;
  std::string content;
  std::string where;
  std::string message;
};

class JobTomlDefect : public testing::TestWithParam<Defect> {};

TEST_P(JobTomlDefect, IsNamedWithItsPlace) {
  const test::TemporaryDirectory directory;
  const std::string path = directory.write("job.toml", GetParam().content);
  try {
    read_job(path);
    FAIL() << "accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::usage);
    EXPECT_EQ(e.where(), path + GetParam().where);
    EXPECT_NE(std::string(e.what()).find(GetParam().message), std::string::npos) << e.what();
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
  }
}

INSTANTIATE_TEST_SUITE_P(
    Table, JobTomlDefect,
    testing::Values(
        Defect{"UnknownKey", "[planning]\nstpe = 2\n", ":2:1",
               "unknown key 'stpe' in [planning]; did you mean 'step'?"},
        Defect{"FarOffKey", "[head]\ncolour = 2\n", ":2:1", "[head] knows tows"},
        Defect{"KeyOfAnotherTable", "[planning]\n  tow_width = 2\n", ":2:3", "it belongs into [material]"},
        Defect{"KeyWithoutTable", "step = 2\n", ":1:1", "it belongs into [planning]"},
        Defect{"UnknownTable", "[plannig]\nstep = 2\n", ":1:2",
               "unknown table [plannig]; did you mean 'planning'?"},
        Defect{"TableIsAValue", "planning = 3\n", ":1:12", "must be a table"},
        Defect{"TextForNumber", "[planning]\nstep = \"2\"\n", ":2:8",
               "planning.step must be a number, not text"},
        Defect{"FractionForCount", "[head]\ntows = 2.5\n", ":2:8", "head.tows must be a whole number"},
        Defect{"NumberForText", "[input]\nunit = 3\n", ":2:8", "input.unit must be text in quotes"},
        Defect{"OutOfRange", "[material]\ntow_width = -1\n", ":2:13",
               "material.tow_width = -1 is out of range; it must lie in 0.1 ... 1000 mm"},
        Defect{"NotANumber", "[material]\ntow_width = nan\n", ":2:13", "out of range"},
        Defect{"TooMany", "[head]\ntows = 9223372036854775807\n", ":2:8", "it must lie in 1 ... 256"},
        Defect{"UnknownUnit", "[input]\nunit = \"yd\"\n", ":2:8", "it is one of mm, cm, m, in, ft"},
        Defect{"FaceZero", "[faces]\nlist = [0]\n", ":2:8", "numbered from 1"},
        Defect{"NoFace", "[faces]\nlist = []\n", ":2:8", "is empty"},
        Defect{"FaceText", "[faces]\nlist = \"3-x\"\n", ":2:8", "not a list of faces"},
        Defect{"TwoChoices", "[faces]\nlist = [1]\nname = \"skin\"\n", "", "more than one way"},
        Defect{"TightSteering", "[material]\nmin_steering_radius = 5\n", "", "smaller than tow_width"},
        Defect{"FirstInTheFile", "[planning]\nzzz = 1\nstpe = 2\n", ":2:1", "'zzz'"}),
    [](const auto& info) { return info.param.name; });

class JobTomlSyntax : public testing::TestWithParam<const char*> {};

// Whatever is not TOML is an error of one line that names a line of the file.
TEST_P(JobTomlSyntax, IsRefused) {
  const test::TemporaryDirectory directory;
  const std::string path = directory.write("job.toml", GetParam());
  try {
    read_job(path);
    FAIL() << "accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::usage);
    EXPECT_EQ(e.where().rfind(path + ":", 0), 0u) << e.where();
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
  }
}

INSTANTIATE_TEST_SUITE_P(Table, JobTomlSyntax,
                         testing::Values("[planning\nstep = 2\n", "[planning]\nstep = \n",
                                         "[planning]\nstep 2\n", "[planning]\nstep = 2\nstep = 3\n",
                                         "[input]\nunit = \"m\n", "= 3\n", "[planning]\nstep = 1 2\n"));

TEST(JobToml, RefusesDeepNesting) {
  const std::string deep = "[faces]\nlist = " + std::string(100000, '[') + std::string(100000, ']') + "\n";
  try {
    read(deep);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::usage);
    EXPECT_NE(std::string(e.what()).find("nested"), std::string::npos);
  }
}

TEST(JobToml, MissingFileIsUsage) {
  try {
    read_job("/nonexistent/job.toml");
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::usage);
    EXPECT_EQ(e.where(), "/nonexistent/job.toml");
  }
}

// A flag and the file say the same thing in the same words.
TEST(JobKeys, FlagsObeyTheSameRanges) {
  Job job;
  set_job_key(job, "planning.step", "0.5", "--step");
  EXPECT_EQ(job.plan.step_mm, 0.5);
  set_job_key(job, "head.tows", "16", "--tows");
  EXPECT_EQ(job.plan.tows, 16);
  set_job_key(job, "faces.list", "3,5-6", "--face");
  EXPECT_EQ(job.faces.numbers, (std::vector<int>{3, 5, 6}));
  for (const auto& [key, text] : std::vector<std::pair<std::string, std::string>>{{"planning.step", "0"},
                                                                                  {"planning.step", "nan"},
                                                                                  {"planning.step", "1,5"},
                                                                                  {"head.tows", "2.5"},
                                                                                  {"head.tows", "1e300"},
                                                                                  {"input.unit", "inch"},
                                                                                  {"faces.list", "5-3"},
                                                                                  {"faces.list", "1-9999999"},
                                                                                  {"faces.list", ""}}) {
    try {
      set_job_key(job, key, text, "--flag");
      FAIL() << key << " " << text;
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::usage);
      EXPECT_EQ(e.where(), "--flag");
    }
  }
}

// Every key has a value to record, and the documentation lists every key.
TEST(JobKeys, AreAllRecordedAndDocumented) {
  const auto keys = job_keys();
  const auto values = job_values(Job{});
  ASSERT_EQ(keys.size(), values.size());
  const std::string files = test::content_of(std::string(AFPTRAJ_SOURCE_DIR) + "/docs/files.md");
  for (std::size_t i = 0; i < keys.size(); ++i) {
    EXPECT_EQ(keys[i].name, values[i].first);
    const std::string name = keys[i].name.substr(keys[i].name.find('.') + 1);
    EXPECT_NE(files.find("`" + name + "`"), std::string::npos) << keys[i].name << " is not in docs/files.md";
    EXPECT_NE(files.find(keys[i].range), std::string::npos)
        << keys[i].name << ": range " << keys[i].range << " is not in docs/files.md";
  }
}

}  // namespace
}  // namespace afptraj
