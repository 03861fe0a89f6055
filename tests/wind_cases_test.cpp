// Every stored case of FiberPath: the same program byte for byte, the same verdict in the same words.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "geometry/error.h"
#include "io/program_file.h"
#include "io/step/sha256.h"
#include "io/wind_file.h"
#include "tests/temporary_directory.h"
#include "tests/winding_text.h"
#include "winding/layer_rules.h"

namespace afptraj {
namespace {

const std::filesystem::path cases = std::string(AFPTRAJ_SHARED_DIR) + "/reference/winding_cases";

std::string with_file(std::string message, const std::string& file) {
  for (std::size_t at = 0; (at = message.find("<FILE>")) != std::string::npos;) message.replace(at, 6, file);
  return message;
}

// Empty when the definition can be wound.
std::string verdict(const std::string& file, std::optional<WindDefinition>& definition) {
  try {
    definition = read_wind_file(file, WindMode::fiberpath);
  } catch (const Error& e) {
    return e.what();
  }
  const auto fault = first_fault(*definition, WindMode::fiberpath);
  return fault ? "Layer " + std::to_string(fault->layer) + ": " + fault->message : "";
}

void expect_simulation(const std::string& text, const std::filesystem::path& stored,
                       const std::string& name) {
  if (!std::filesystem::exists(stored)) return;
  const auto expected = nlohmann::json::parse(test::content_of(stored));
  const SimulatedProgram found = simulate_text(name, text);
  EXPECT_EQ(found.commands, expected["commands_executed"]) << name;
  EXPECT_EQ(found.moves(), expected["moves"]) << name;
  const double time = expected["estimated_time_s"], length = expected["tow_length_mm"];
  EXPECT_NEAR(found.time_s(), time, 1e-9 * time) << name;
  EXPECT_NEAR(found.length_mm(), length, 1e-9 * length) << name;
}

TEST(WindCases, AreFiberPaths) {
  if (!std::filesystem::exists(cases / "index.json")) GTEST_SKIP() << "no stored cases in " << cases;
  const auto index = nlohmann::json::parse(test::content_of(cases / "index.json"));
  int programs = 0, refusals = 0;
  for (const auto& entry : index) {
    const std::string name = entry["case"];
    const std::string file = (cases / name / "input.wind").string();
    std::optional<WindDefinition> definition;
    const std::string message = verdict(file, definition);
    if (entry.value("result", "ok") == "error") {
      EXPECT_EQ(message, with_file(entry["error"]["message"], file)) << name;
      ++refusals;
      continue;
    }
    ASSERT_EQ(message, "") << name;
    std::string text;
    const ProgramReport report =
        write_program(*definition, WindMode::fiberpath, [&](std::string_view piece) { text += piece; });
    if (!entry.contains("gcode_sha256")) continue;
    EXPECT_EQ(sha256_hex(text), entry["gcode_sha256"]) << name;
    const auto& plan = entry["plan"];
    EXPECT_EQ(report.totals.lines, plan["commands"]) << name;
    const double time = plan["timeSeconds"], tow = plan["towMeters"];
    EXPECT_NEAR(report.time_s(report.totals), time, 1e-9 * time) << name;
    EXPECT_NEAR(report.totals.total_length_mm() / 1000, tow, 1e-9 * tow) << name;
    expect_simulation(text, cases / name / "simulate_summary.json", name);
    ++programs;
  }
  EXPECT_GT(programs, 0);
  EXPECT_GT(refusals, 0);
}

}  // namespace
}  // namespace afptraj
