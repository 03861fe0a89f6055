// What read_step refuses, with which code, and for the stated reason.

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "geometry/error.h"
#include "io/step/isolate.h"
#include "io/step/read_step.h"
#include "io/step/step_text.h"
#include "tests/temporary_directory.h"

namespace afptraj {
namespace {

const std::filesystem::path steps = std::filesystem::path(AFPTRAJ_SHARED_DIR) / "data" / "steps";
const std::filesystem::path sample =
    std::filesystem::path(AFPTRAJ_SOURCE_DIR) / "samples" / "panel" / "part.step";

/// The error that reading gives, as "code where: message"; "" when it reads.
std::string outcome(const std::filesystem::path& path, const StepReadOptions& options = {}) {
  try {
    read_step(path, options);
    return "";
  } catch (const Error& error) {
    return std::to_string(static_cast<int>(error.code())) + " " + error.where() + ": " + error.what();
  }
}

void expect_refused(const std::string& result, int code, const std::vector<std::string>& words) {
  EXPECT_EQ(result.substr(0, result.find(' ')), std::to_string(code)) << result;
  for (const std::string& word : words)
    EXPECT_NE(result.find(word), std::string::npos) << word << " in: " << result;
  EXPECT_EQ(result.find('\n'), std::string::npos) << "one line: " << result;
  EXPECT_NE(result.find(';'), std::string::npos) << "says what to do: " << result;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  if (at != std::string::npos) text.replace(at, from.size(), to);
  return text;
}

/// A file made of the text of the panel sample.
class Refusals : public testing::Test {
 protected:
  std::string panel() const { return test::content_of(sample); }
  std::string result(const std::string& content, const StepReadOptions& options = {}) const {
    return outcome(directory_.write("part.step", content), options);
  }
  test::TemporaryDirectory directory_;
};

TEST_F(Refusals, ThePanelItselfReads) { EXPECT_EQ(result(panel()), ""); }

TEST_F(Refusals, PathsThatAreNotFiles) {
  expect_refused(outcome(directory_ / "none.step"), 3, {"no such file"});
  expect_refused(outcome(directory_.path()), 3, {"directory"});
  const std::string pipe = directory_ / "pipe.step";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  expect_refused(outcome(pipe), 3, {"pipe"});
  expect_refused(outcome("/dev/null"), 3, {"device"});
  if (::geteuid() != 0) {
    const std::string closed = directory_.write("closed.step", panel());
    ASSERT_EQ(::chmod(closed.c_str(), 0), 0);
    expect_refused(outcome(closed), 3, {"permission"});
  }
}

TEST_F(Refusals, OtherContent) {
  using namespace std::string_literals;
  expect_refused(result(""), 3, {"empty"});
  expect_refused(result(" \n\t\r\n"), 3, {"blanks"});
  expect_refused(result(std::string(100, '\0')), 3, {"blanks"});
  expect_refused(result("\x89PNG\r\n\x1a\n0000"), 3, {"PNG"});
  expect_refused(result("%PDF-1.7"), 3, {"PDF"});
  expect_refused(result("PK\x03\x04zzzz"), 3, {"ZIP"});
  expect_refused(result("solid cube\nfacet normal 0 0 1\n"), 3, {"STL"});
  std::string binary(84 + 50, 'x');
  binary[80] = 1, binary[81] = binary[82] = binary[83] = 0;
  expect_refused(result(binary), 3, {"binary STL"});
  expect_refused(result("version https://git-lfs.github.com/spec/v1\noid sha256:00\n"), 3,
                 {"Git LFS", "git lfs pull"});
  expect_refused(result(std::string(72, ' ') + "S      1\n"), 3, {"IGES"});
  expect_refused(result("hello world"), 3, {"ISO-10303-21"});
  expect_refused(result("\xff\xfeI\0S\0O\0"s), 3, {"UTF-16", "iconv"});
  expect_refused(result("I\0S\0O\0-\0"s), 3, {"UTF-16"});
}

TEST_F(Refusals, EncodingsThatAreFine) {
  EXPECT_EQ(result("\xef\xbb\xbf" + panel()), "");
  std::string crlf;
  for (const char c : panel()) crlf += c == '\n' ? "\r\n" : std::string(1, c);
  EXPECT_EQ(result(crlf), "");
  EXPECT_EQ(result("/* made by hand */\n" + panel()), "");
}

TEST_F(Refusals, BrokenText) {
  const std::string text = panel();
  expect_refused(result(text.substr(0, text.size() * 6 / 10)), 3, {"cut off"});
  expect_refused(result(text.substr(0, text.rfind("END-ISO"))), 3, {"END-ISO-10303-21"});
  expect_refused(result(text.substr(0, text.find("DATA;")) + "END-ISO-10303-21;\n"), 3, {"DATA"});
  expect_refused(result(text.substr(0, text.find("DATA;")) + "DATA;\nENDSEC;\nEND-ISO-10303-21;\n"), 3,
                 {"empty DATA"});
  expect_refused(result(replaced(text, "PRODUCT('panel 1'", "PRODUCT('panel 1")), 3, {":"});
  expect_refused(result(replaced(text, "#17 = ", "/* #17 = ")), 3, {"comment"});
  expect_refused(result(replaced(text, "(0.,0.,0.)", "(0.,NaN,0.)")), 3, {"part.step:", "NaN"});
  expect_refused(result(replaced(text, "(0.,0.,0.)", "(0.,1.E+400,0.)")), 3, {"1.E+400", "out of range"});
  expect_refused(result(replaced(text, "#12 = ", "#99999999999 = ")), 3, {"2147483647"});
}

TEST_F(Refusals, DeepNesting) {
  const std::string deep = std::string(200000, '(') + std::string(200000, ')');
  expect_refused(result(replaced(panel(), "('',#2,'mechanical')", deep)), 3, {"nested"});
}

TEST_F(Refusals, CoordinatesWithoutSense) {
  std::string text = panel();
  std::string far;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::string corner = "5.767163458401";
    if (text.compare(i, corner.size(), corner) == 0) {
      far += "1.E+90";
      i += corner.size() - 1;
    } else {
      far += text[i];
    }
  }
  expect_refused(result(far), 3, {"part.step"});
  // Every coordinate zero: all points are one.
  std::string flat;
  for (std::size_t i = 0; i < text.size();) {
    const std::string key = "CARTESIAN_POINT('',(";
    if (text.compare(i, key.size(), key) == 0) {
      flat += key + "0.,0.,0.";
      i = text.find(')', i + key.size());
    } else {
      flat += text[i++];
    }
  }
  const std::string result_flat = result(flat);
  EXPECT_TRUE(result_flat.starts_with("3 ") || result_flat.starts_with("6 ")) << result_flat;
}

TEST_F(Refusals, TooLarge) {
  StepReadOptions options;
  options.max_file_bytes = 1000;
  expect_refused(result(panel(), options), 3, {"limit"});
}

TEST_F(Refusals, AnUnknownUnit) {
  StepReadOptions options;
  options.unit_override = "furlong";
  expect_refused(result(panel(), options), 2, {"furlong", "mm, cm, m, in or ft"});
}

TEST_F(Refusals, MissingUnitIsAssumedAndSaid) {
  // The context without its units is still a context; OpenCASCADE reads it as millimetres.
  std::string text = panel();
  const std::size_t units = text.find("GLOBAL_UNIT_ASSIGNED_CONTEXT");
  ASSERT_NE(units, std::string::npos);
  const std::size_t first = text.find('#', units);
  const std::size_t comma = text.find(',', first);
  text.erase(first, comma + 1 - first);  // the length unit stands first
  const StepModel model = read_step(directory_.write("nounit.step", text));
  ASSERT_FALSE(model.warnings.empty());
  EXPECT_NE(model.warnings[0].find("no length unit"), std::string::npos);
  StepReadOptions options;
  options.unit_override = "m";
  const StepModel metres = read_step(directory_ / "nounit.step", options);
  const Face &a = model.part.faces[0], &b = metres.part.faces[0];
  const Uv uv(0.5 * (a.surface.domain_u().lo + a.surface.domain_u().hi),
              0.5 * (a.surface.domain_v().lo + a.surface.domain_v().hi));
  EXPECT_LE((1000 * a.surface.point(uv) - b.surface.point(uv)).norm(), 1e-6);
}

TEST_F(Refusals, DanglingReferencesAreNamed) {
  const std::string text = replaced(panel(), "PRODUCT_CONTEXT('',#2", "PRODUCT_CONTEXT('',#987654");
  const std::string refused = result(text);
  if (refused.empty()) {
    const StepModel model = read_step(directory_ / "part.step");
    bool said = false;
    for (const std::string& warning : model.warnings)
      said = said || warning.find("#987654") != std::string::npos;
    EXPECT_TRUE(said);
  } else {
    expect_refused(refused, 3, {"#987654"});
  }
}

/// OpenCASCADE 7.6 recurses without end on an oriented edge that is its own element.
TEST_F(Refusals, ACrashOfTheImporterIsAnError) {
  const std::string text =
      replaced(panel(), "#20 = ORIENTED_EDGE('',*,*,#21,.F.)", "#20 = ORIENTED_EDGE('',*,*,#20,.F.)");
  expect_refused(result(text), 6, {"died with signal 11", "#20 = ORIENTED_EDGE", "refers to itself"});
  // And nothing is left behind: the next file reads, no child waits to be collected.
  EXPECT_EQ(result(panel()), "");
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1);
}

/// Damage at random: the program survives, and answers with a part, code 3 or code 6, in one line.
TEST_F(Refusals, RandomDamage) {
  const std::string text = panel();
  std::mt19937 random(5);
  const auto pick = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  const std::size_t data = text.find("DATA;");
  StepReadOptions options;
  options.timeout_s = 20;
  for (int trial = 0; trial < 60; ++trial) {
    std::string damaged = text;
    for (int k = 0; k < 3; ++k) {
      const std::size_t line = damaged.rfind('\n', data + pick(damaged.size() - data - 100));
      const std::size_t end = damaged.find('\n', line + 1);
      const std::size_t hash = damaged.find('#', line + 2),
                        digit = damaged.find_first_of("0123456789", line + 4);
      switch (pick(5)) {
        case 0:
          damaged.erase(line, end - line);
          break;
        case 1:
          damaged.insert(line, damaged.substr(line, end - line));
          break;
        case 2:
          damaged.replace(hash, 3, "#" + std::to_string(1 + pick(99)));
          break;
        case 3:
          damaged.replace(digit, 1, std::to_string(pick(1000000)));
          break;
        default:
          damaged[line + 1 + pick(end - line)] = static_cast<char>(32 + pick(95));
          break;
      }
    }
    const std::string answer = result(damaged, options);
    if (!answer.empty()) {
      EXPECT_TRUE(answer.starts_with("3 ") || answer.starts_with("6 ")) << answer;
      EXPECT_EQ(answer.find('\n'), std::string::npos) << answer;
    }
  }
}

TEST(Isolation, HandsOverBytesAndErrors) {
  using step::run_isolated;
  const std::string large(5000000, 'x');
  EXPECT_EQ(run_isolated("f", {}, [&] { return large; }), large);
  try {
    run_isolated("f", {},
                 []() -> std::string { throw Error(ErrorCode::bad_input, "f:#12", "is wrong; mend it"); });
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    EXPECT_EQ(error.where(), "f:#12");
    EXPECT_STREQ(error.what(), "is wrong; mend it");
  }
}

std::string isolated_outcome(const step::IsolationLimits& limits, const std::function<std::string()>& work) {
  try {
    return step::run_isolated("f", limits, work);
  } catch (const Error& error) {
    return std::to_string(static_cast<int>(error.code())) + " " + error.what();
  }
}

TEST(Isolation, TimeIsUp) {
  step::IsolationLimits limits;
  limits.timeout_s = 0.3;
  const auto begin = std::chrono::steady_clock::now();
  const std::string sleeping = isolated_outcome(limits, []() -> std::string {
    while (true) ::pause();
  });
  expect_refused(sleeping, 6, {"0.3 s"});
  EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(), 5);
}

TEST(Isolation, ToldToStop) {
  step::IsolationLimits limits;
  limits.stop = [] { return true; };
  const std::string stopped = isolated_outcome(limits, []() -> std::string {
    while (true) ::pause();
  });
  EXPECT_NE(stopped.find("interrupted"), std::string::npos);
}

#if !defined(__SANITIZE_ADDRESS__)
TEST(Isolation, MemoryRunsOut) {
  step::IsolationLimits limits;
  limits.memory_bytes = std::uint64_t{256} << 20;
  expect_refused(isolated_outcome(limits, [] { return std::string(std::size_t{1} << 30, 'x'); }), 6,
                 {"256 MiB", "memory"});
}

TEST(Isolation, Abort) {
  expect_refused(isolated_outcome({}, []() -> std::string { ::abort(); }), 6, {"signal 6", "abort"});
}
#endif

TEST(Isolation, AnEndWithoutAnAnswer) {
  expect_refused(isolated_outcome({}, []() -> std::string { ::_exit(3); }), 6, {"without an answer", "3"});
}

/// Nothing that the importer prints reaches the program's own output.
TEST(Isolation, TheChildIsMute) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  step::run_isolated("f", {}, [] {
    std::printf("noise\n");
    std::fprintf(stderr, "noise\n");
    std::fflush(nullptr);
    return std::string("x");
  });
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(RealRefusals, TheMalformedFilesGiveTheirReasons) {
  if (!std::filesystem::exists(steps)) GTEST_SKIP() << "the real parts are not on this machine";
  const auto bad = steps / "malformed";
  expect_refused(outcome(bad / "gitlfs_pointer.step"), 3, {"Git LFS"});
  expect_refused(outcome(bad / "empty.step"), 3, {"empty"});
  expect_refused(outcome(bad / "iges_renamed.stp"), 3, {"IGES"});
  expect_refused(outcome(bad / "truncated_60pct_nacelle.stp"), 3,
                 {"truncated_60pct_nacelle.stp:3870", "ENDSEC"});
  expect_refused(outcome(bad / "ap209_fem_only.stp"), 3, {"no faces", "FEA_MODEL_3D"});
  expect_refused(outcome(bad / "assembly_missing_external_parts.stp"), 3,
                 {"other files", "mainbody_asm.stp"});
}

TEST(StepTextScan, CountsLinesAndFindsCycles) {
  const std::string text =
      "ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('X'));\nENDSEC;\nDATA;\n#1=A(#2);\n#2=B(#3,'it''s #9 (');\n/* #4 "
      "*/\n#3=(C(#1)D());\nENDSEC;\n"
      "END-ISO-10303-21;\n";
  const step::StepText scanned = step::check_step_text(text, "f");
  EXPECT_EQ(scanned.schema, "X");
  ASSERT_EQ(scanned.instances.size(), 3u);
  EXPECT_EQ(scanned.instances[2].line, 9);
  EXPECT_EQ(scanned.instances[2].type, "C");
  EXPECT_EQ(scanned.count("D"), 1);
  EXPECT_EQ(step::find_cycle(scanned).value_or(""), "#1 = A (line 6) refers to itself over #3 = C (line 9)");
  EXPECT_TRUE(step::find_broken_references(scanned).empty());
}

}  // namespace
}  // namespace afptraj
