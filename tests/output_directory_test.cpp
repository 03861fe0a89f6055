#include "io/output_directory.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <functional>
#include <set>
#include <thread>

#include "geometry/error.h"
#include "tests/temporary_directory.h"

namespace afptraj {
namespace {

namespace fs = std::filesystem;
using test::content_of;
using test::TemporaryDirectory;

void write_result(const fs::path& target, const std::string& content, bool force = false) {
  OutputDirectory output(target, force);
  for (const std::string& name : result_file_names()) output.write(name, content);
  output.commit();
}

// The one content of all files of a result; "mixed" when they differ.
std::string result_of(const fs::path& target) {
  std::set<std::string> contents;
  for (const std::string& name : result_file_names()) contents.insert(content_of(target / name));
  return contents.size() == 1 ? *contents.begin() : "mixed";
}

std::set<std::string> names_in(const fs::path& directory) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(directory)) names.insert(entry.path().filename().string());
  return names;
}

std::string refusal(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::cannot_write);
    return e.what();
  }
  return "accepted";
}

#define EXPECT_SAYS(text, words) EXPECT_NE((text).find(words), std::string::npos) << (text)

TEST(OutputDirectory, AppearsWithCommitAndNotBefore) {
  const TemporaryDirectory scratch;
  {
    OutputDirectory output(scratch / "out", false);
    output.write("paths.csv", "x");
    EXPECT_FALSE(fs::exists(scratch / "out"));
    output.commit();
    EXPECT_EQ(content_of(scratch / "out" / "paths.csv"), "x");
  }
  EXPECT_EQ(names_in(scratch.path()), (std::set<std::string>{"out"}));
}

TEST(OutputDirectory, TakesAFileInParts) {
  const TemporaryDirectory scratch;
  OutputDirectory output(scratch / "out", false);
  output.write("tows.csv", [](const TextSink& sink) {
    sink("a");
    sink("");
    sink("bc");
  });
  // What the producer throws comes through, and the directory can be left.
  EXPECT_THROW(output.write("paths.csv", [](const TextSink& sink) {
    sink("x");
    throw std::length_error("stop");
  }),
               std::length_error);
  output.commit();
  EXPECT_EQ(content_of(scratch / "out" / "tows.csv"), "abc");
}

TEST(OutputDirectory, LeavesNothingWithoutCommit) {
  const TemporaryDirectory scratch;
  {
    OutputDirectory output(scratch / "out", false);
    output.write("paths.csv", "x");
  }
  EXPECT_TRUE(fs::is_empty(scratch.path()));
}

TEST(OutputDirectory, ReplacesOnlyByForce) {
  const TemporaryDirectory scratch;
  write_result(scratch / "out", "old");
  EXPECT_SAYS(refusal([&] { write_result(scratch / "out", "new"); }), "--force");
  EXPECT_EQ(result_of(scratch / "out"), "old");
  write_result(scratch / "out", "new", true);
  EXPECT_EQ(result_of(scratch / "out"), "new");
  EXPECT_EQ(names_in(scratch.path()), (std::set<std::string>{"out"}));
}

TEST(OutputDirectory, TakesAnEmptyDirectory) {
  const TemporaryDirectory scratch;
  fs::create_directory(scratch / "out");
  write_result(scratch / "out", "new");
  EXPECT_EQ(result_of(scratch / "out"), "new");
}

TEST(OutputDirectory, NeverReplacesWhatItDidNotWrite) {
  const TemporaryDirectory scratch;
  write_result(scratch / "out", "old");
  scratch.write("out/thesis.tex", "years of work");
  EXPECT_SAYS(refusal([&] { write_result(scratch / "out", "new", true); }),
              "'thesis.tex', which afptraj did not write");
  EXPECT_EQ(content_of(scratch / "out" / "thesis.tex"), "years of work");
  EXPECT_EQ(result_of(scratch / "out"), "old");
}

TEST(OutputDirectory, RefusesBadTargets) {
  const TemporaryDirectory scratch;
  scratch.write("file", "x");
  fs::create_directory_symlink(scratch / "nowhere", scratch / "dangling");
  const auto check = [&](const fs::path& target, std::vector<fs::path> inputs = {}) {
    return refusal([&] { check_output(target, true, inputs); });
  };
  EXPECT_SAYS(check(scratch / "absent/out"), "does not exist; create it first");
  EXPECT_SAYS(check(scratch / "file"), "is a file");
  EXPECT_SAYS(check(scratch / "file/out"), "is not a directory");
  EXPECT_SAYS(check(scratch / "dangling"), "symbolic link to nothing");
  EXPECT_SAYS(check(scratch / std::string(300, 'a')), "too long");
  EXPECT_SAYS(check(std::string(5000, 'a')), "too long");
  EXPECT_SAYS(check(""), "empty");
  EXPECT_SAYS(check("/"), "root");
  EXPECT_SAYS(check(scratch / "file", {scratch / "file"}), "is an input file");
  write_result(scratch / "out", "old");
  scratch.write("out/paths.csv", "x");
  EXPECT_SAYS(check(scratch / "out", {scratch / "out/paths.csv"}), "holds the input");
  EXPECT_NE(refusal([] { OutputDirectory("/proc/out", true); }), "accepted");
}

TEST(OutputDirectory, RefusesTheCurrentDirectory) {
  const TemporaryDirectory scratch;
  const fs::path before = fs::current_path();
  fs::current_path(scratch.path());
  EXPECT_SAYS(refusal([&] { check_output(".", true, {}); }), "current directory");
  fs::current_path(before);
}

TEST(OutputDirectory, TakesRelativeNames) {
  const TemporaryDirectory scratch;
  const fs::path before = fs::current_path();
  fs::current_path(scratch.path());
  write_result("out", "new");
  write_result("./out/", "newer", true);
  fs::current_path(before);
  EXPECT_EQ(result_of(scratch / "out"), "newer");
}

TEST(OutputDirectory, FollowsLinks) {
  const TemporaryDirectory scratch;
  fs::create_directory(scratch / "real");
  fs::create_directory_symlink(scratch / "real", scratch / "link");
  write_result(scratch / "link", "new");
  EXPECT_TRUE(fs::is_symlink(scratch / "link"));
  EXPECT_EQ(result_of(scratch / "real"), "new");
}

TEST(OutputDirectory, CannotWriteWithoutRights) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  const TemporaryDirectory scratch;
  fs::create_directory(scratch / "locked");
  fs::permissions(scratch / "locked", fs::perms::owner_read | fs::perms::owner_exec);
  EXPECT_SAYS(refusal([&] { write_result(scratch / "locked/out", "new"); }), "permission denied");
}

// Runs `action` in a child; its exit code, or minus the signal that ended it.
int in_child(const std::function<int()>& action) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(action());
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

// A file larger than the process may write: the error says so, and the old result is whole.
TEST(OutputDirectory, KeepsTheOldResultWhenAFileGrowsTooLarge) {
  const TemporaryDirectory scratch;
  write_result(scratch / "out", "old");
  const int code = in_child([&] {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{4096, 4096};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    try {
      write_result(scratch / "out", std::string(100000, 'n'), true);
    } catch (const Error& e) {
      return std::string(e.what()).find("ulimit -f") != std::string::npos ? static_cast<int>(e.code()) : 99;
    }
    return 0;
  });
  EXPECT_EQ(code, 5);
  EXPECT_EQ(result_of(scratch / "out"), "old");
  EXPECT_EQ(names_in(scratch.path()), (std::set<std::string>{"out"}));
}

TEST(OutputDirectory, KeepsTheOldResultOnAFullDisk) {
  const TemporaryDirectory scratch;
  const fs::path disk = scratch / "disk";
  fs::create_directory(disk);
  if (::mount("tmpfs", disk.c_str(), "tmpfs", 0, "size=64k") != 0)
    GTEST_SKIP() << "may not mount a small disk";
  write_result(disk / "out", "old");
  EXPECT_SAYS(refusal([&] { write_result(disk / "out", std::string(200000, 'n'), true); }), "no space left");
  EXPECT_EQ(result_of(disk / "out"), "old");
  EXPECT_EQ(names_in(disk), (std::set<std::string>{"out"}));
  ::umount(disk.c_str());
}

// Killed at any moment, a run leaves the old result or a new one, never a mixture; the next run
// cleans up.
TEST(OutputDirectory, IsWholeAfterKill) {
  const TemporaryDirectory scratch;
  write_result(scratch / "out", "0");
  for (int round = 0; round < 60; ++round) {
    const pid_t child = ::fork();
    if (child == 0) {
      for (int i = 1;; ++i) write_result(scratch / "out", std::to_string(i), true);
    }
    ::usleep(static_cast<useconds_t>(500 + 137 * round));
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    ASSERT_NE(result_of(scratch / "out"), "mixed");
    ASSERT_NE(result_of(scratch / "out"), "");
  }
  write_result(scratch / "out", "last", true);
  EXPECT_EQ(result_of(scratch / "out"), "last");
  EXPECT_EQ(names_in(scratch.path()), (std::set<std::string>{"out"}));
}

TEST(OutputDirectory, LeavesTheLeftoversOfOthersAlone) {
  const TemporaryDirectory scratch;
  fs::create_directory(scratch / ".other.afptraj-abcdef");
  fs::create_directory(scratch / ".out.afptraj-abcdef");
  scratch.write(".out.afptraj-abcdef/precious", "x");  // looks like a leftover, but is none
  write_result(scratch / "out", "new");
  EXPECT_TRUE(fs::exists(scratch / ".other.afptraj-abcdef"));
  EXPECT_TRUE(fs::exists(scratch / ".out.afptraj-abcdef/precious"));
}

// Two runs to one place: each result is whole, and a running one is not taken for a leftover.
TEST(OutputDirectory, ServesTwoRunsAtOnce) {
  const TemporaryDirectory scratch;
  const auto many = [&](const std::string& content) {
    for (int i = 0; i < 100; ++i) write_result(scratch / "out", content, true);
    return 0;
  };
  const pid_t child = ::fork();
  if (child == 0) {
    try {
      ::_exit(many("child"));
    } catch (...) {
      ::_exit(1);
    }
  }
  many("parent");
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 0);
  const std::string result = result_of(scratch / "out");
  EXPECT_TRUE(result == "child" || result == "parent") << result;
  EXPECT_EQ(names_in(scratch.path()), (std::set<std::string>{"out"}));
}

}  // namespace
}  // namespace afptraj
