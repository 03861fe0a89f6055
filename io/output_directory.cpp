#include "io/output_directory.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "geometry/error.h"
#include "io/output_place.h"
#include "io/text_file.h"

namespace afptraj {
namespace fs = std::filesystem;
namespace {

// The prefix of sibling directories of `target`.
std::string staging_prefix(const fs::path& target) {
  // Long names are cut, so that the sibling's name stays within 255 bytes.
  return "." + target.filename().string().substr(0, 200) + ".afptraj-";
}

// A descriptor with the exclusive lock of a directory, -1 when another run holds it.
int lock_directory(const fs::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC | O_NOFOLLOW);
  if (fd < 0) return -1;
  if (::flock(fd, LOCK_EX | LOCK_NB) != 0) {
    ::close(fd);
    return -1;
  }
  return fd;
}

// A name in the directory that afptraj does not write; empty when there is none.
std::string foreign_entry(const fs::path& directory) {
  const auto& own = result_file_names();
  std::error_code problem;
  for (const auto& entry : fs::directory_iterator(directory, problem)) {
    const std::string name = entry.path().filename().string();
    if (std::find(own.begin(), own.end(), name) == own.end() || entry.is_directory()) return name;
  }
  if (problem) cannot_write(directory, write_problem(problem.value()));
  return {};
}

bool lies_in(const fs::path& file, const fs::path& directory) {
  std::error_code problem;
  const fs::path real = fs::weakly_canonical(fs::absolute(file, problem), problem);
  if (problem) return false;
  const auto [rest, end] = std::mismatch(directory.begin(), directory.end(), real.begin(), real.end());
  static_cast<void>(end);
  return rest == directory.end();
}

}  // namespace

const std::vector<std::string>& result_file_names() {
  static const std::vector<std::string> names{"paths.csv",    "tows.csv", "coverage.csv", "paths.step",
                                              "summary.json", "fill.svg", "paths.gcode",  "paths.vtp"};
  return names;
}

fs::path check_output(const fs::path& target, bool force, const std::vector<fs::path>& inputs) {
  const fs::path real = resolve_output(target);
  for (const fs::path& input : inputs) {
    std::error_code problem;
    if (fs::equivalent(input, real, problem))
      cannot_write(target, "is an input file; choose another place with -o");
    if (lies_in(input, real))
      cannot_write(target,
                   "holds the input '" + printable(input.string(), 200) + "'; choose another place with -o");
  }
  if (real == real.root_path()) cannot_write(target, "is the root directory; name a directory in it");
  std::error_code problem;
  const fs::file_status status = fs::status(real, problem);
  if (fs::exists(status)) {
    if (!fs::is_directory(status)) cannot_write(target, "is a file; choose another place with -o");
    if (fs::equivalent(real, fs::current_path(problem), problem)) {
      cannot_write(target, "is the current directory, which cannot be replaced; name a directory in it");
    }
    const std::string foreign = foreign_entry(real);
    if (!fs::is_empty(real, problem) && !force) {
      cannot_write(target, foreign.empty() ? "exists; give --force to replace it"
                                           : "exists and holds other files; choose another place with -o");
    }
    if (!foreign.empty()) {
      cannot_write(target, "holds '" + printable(foreign) +
                               "', which afptraj did not write; choose another place with -o");
    }
  }
  if (::access(real.parent_path().c_str(), W_OK | X_OK) != 0) cannot_write(target, write_problem(errno));
  return real;
}

OutputDirectory::OutputDirectory(fs::path target, bool force, const std::vector<fs::path>& inputs)
    : target_(check_output(target, force, inputs)), force_(force) {
  remove_leftovers();
  make_staging();
}

OutputDirectory::~OutputDirectory() {
  if (!committed_) {
    std::error_code ignored;
    fs::remove_all(staging_, ignored);
  }
  if (lock_ >= 0) ::close(lock_);
}

void OutputDirectory::remove_leftovers() const {
  const std::string prefix = staging_prefix(target_);
  std::error_code problem;
  std::vector<fs::path> left;
  for (const auto& entry : fs::directory_iterator(target_.parent_path(), problem)) {
    const std::string name = entry.path().filename().string();
    // mkdtemp adds six characters
    if (name.size() == prefix.size() + 6 && name.compare(0, prefix.size(), prefix) == 0)
      left.push_back(entry.path());
  }
  for (const fs::path& path : left) {
    const int fd = lock_directory(path);
    if (fd < 0) continue;  // another run is writing it
    try {
      if (foreign_entry(path).empty()) fs::remove_all(path, problem);
    } catch (const Error&) {
      // removed by another run in between
    }
    ::close(fd);
  }
}

void OutputDirectory::make_staging() {
  // Between making and locking, another run may take the directory for a leftover: then again.
  for (int attempt = 0; attempt < 100; ++attempt) {
    std::string path = (target_.parent_path() / (staging_prefix(target_) + "XXXXXX")).string();
    if (::mkdtemp(path.data()) == nullptr) cannot_write(target_, write_problem(errno));
    const int fd = lock_directory(path);
    struct stat locked {
    }, named{};
    if (fd >= 0 && ::fstat(fd, &locked) == 0 && ::stat(path.c_str(), &named) == 0 &&
        locked.st_ino == named.st_ino) {
      staging_ = path;
      lock_ = fd;
      const mode_t mask = ::umask(0);
      ::umask(mask);
      ::fchmod(fd, 0777 & ~mask);  // mkdtemp makes it private; a result has the usual rights
      return;
    }
    if (fd >= 0) ::close(fd);
  }
  cannot_write(target_, "other runs keep removing the temporary directory; try again");
}

void OutputDirectory::write(const std::string& name, std::string_view content) {
  write(name, [&](const TextSink& sink) { sink(content); });
}

void OutputDirectory::write(const std::string& name, const std::function<void(const TextSink&)>& produce) {
  const fs::path path = staging_ / name;
  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (fd < 0) cannot_write(target_ / name, write_problem(errno));
  int problem = 0;
  try {
    produce([&](std::string_view part) {
      while (!part.empty() && problem == 0) {
        const ssize_t done = ::write(fd, part.data(), part.size());
        if (done < 0) {
          if (errno != EINTR) problem = errno;
        } else {
          part.remove_prefix(static_cast<std::size_t>(done));
        }
      }
      if (problem != 0) cannot_write(target_ / name, write_problem(problem));
    });
  } catch (...) {
    ::close(fd);
    throw;
  }
  if (problem == 0 && ::fsync(fd) != 0 && errno != EINVAL) problem = errno;
  if (::close(fd) != 0 && problem == 0) problem = errno;
  if (problem != 0) cannot_write(target_ / name, write_problem(problem));
}

void OutputDirectory::adopt(const std::string& name) {
  const fs::path path = staging_ / name;
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) cannot_write(target_ / name, write_problem(errno));
  const int problem = ::fsync(fd) != 0 && errno != EINVAL ? errno : 0;
  ::close(fd);
  if (problem != 0) cannot_write(target_ / name, write_problem(problem));
}

void OutputDirectory::commit() {
  flush_directory(staging_);
  check_output(target_, force_, {});  // another run may have finished meanwhile
  bool exchanged = false;
  if (::rename(staging_.c_str(), target_.c_str()) != 0) {
    // A directory that holds something is not replaced by rename(2), but by an exchange.
    const bool occupied = errno == ENOTEMPTY || errno == EEXIST;
    if (!occupied) cannot_write(target_, write_problem(errno));
    if (!force_) cannot_write(target_, "exists; give --force to replace it");
    exchanged = ::renameat2(AT_FDCWD, staging_.c_str(), AT_FDCWD, target_.c_str(), RENAME_EXCHANGE) == 0;
    if (!exchanged) {
      // A file system without exchange: the old result steps aside, by a name that the next run cleans up.
      if (errno != EINVAL && errno != ENOSYS && errno != ENOTSUP) cannot_write(target_, write_problem(errno));
      std::string aside = (target_.parent_path() / (staging_prefix(target_) + "XXXXXX")).string();
      if (::mkdtemp(aside.data()) == nullptr) cannot_write(target_, write_problem(errno));
      if (::rename(target_.c_str(), aside.c_str()) != 0) cannot_write(target_, write_problem(errno));
      if (::rename(staging_.c_str(), target_.c_str()) != 0) {
        const int problem = errno;
        static_cast<void>(::rename(aside.c_str(), target_.c_str()));
        cannot_write(target_, write_problem(problem));
      }
      staging_ = aside;
      exchanged = true;
    }
  }
  committed_ = true;
  flush_directory(target_.parent_path());
  if (exchanged) {
    std::error_code ignored;
    fs::remove_all(staging_, ignored);  // the old result
  }
}

}  // namespace afptraj
