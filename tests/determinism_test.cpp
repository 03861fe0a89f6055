// Same input, same bytes: whatever the number of threads, and every time.
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/temporary_directory.h"

namespace afptraj {
namespace {

using test::content_of;
using test::TemporaryDirectory;

class Determinism : public testing::TestWithParam<const char*> {
 protected:
  /// Plans the sample into `name`; the answer is the program's status.
  int run(const std::string& name, int threads) const {
    const std::string sample = std::string(AFPTRAJ_SOURCE_DIR) + "/samples/" + GetParam();
    const std::string command = "'" AFPTRAJ_PROGRAM "' run '" + sample + "/part.step' '" + sample +
                                "/plies.csv' --job '" + sample + "/job.toml' -q --coverage --threads " +
                                std::to_string(threads) + " -o '" + (scratch_ / name).string() + "'";
    return std::system(command.c_str());
  }
  std::string file(const std::string& name, const std::string& which) const {
    return content_of(scratch_.path() / name / which);
  }
  TemporaryDirectory scratch_;
};

TEST_P(Determinism, OfThreadsAndRuns) {
  ASSERT_EQ(run("one", 1), 0);
  ASSERT_EQ(run("two", 2), 0);
  ASSERT_EQ(run("again", 2), 0);
  for (const char* which : {"paths.csv", "tows.csv", "coverage.csv", "paths.step"}) {
    const std::string one = file("one", which);
    EXPECT_GT(one.size(), 10000u) << which;
    // Not EXPECT_EQ: it would print both.
    EXPECT_TRUE(one == file("two", which)) << which << " depends on the number of threads";
    EXPECT_TRUE(file("two", which) == file("again", which)) << which << " depends on the run";
  }
  // And every figure of the summary but the times and the name of the directory.
  const auto summary = [&](const char* name) {
    auto json = nlohmann::json::parse(file(name, "summary.json"));
    EXPECT_EQ(json.erase("times"), 1u);
    EXPECT_EQ(json["options"].erase("output"), 1u);
    return json;
  };
  EXPECT_EQ(summary("one"), summary("two"));
  EXPECT_EQ(summary("two"), summary("again"));
}

// A panel with holes, where fronts split; a saddle, where rays part; and a duct, where they meet behind.
INSTANTIATE_TEST_SUITE_P(Samples, Determinism, testing::Values("hole", "saddle", "duct"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace afptraj
