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
#include "io/text_file.h"

namespace afptraj {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void cannot(const fs::path& path, const std::string& message) {
  throw Error(ErrorCode::cannot_write, path.string(), message);
}

std::string reason_for(int number) {
  switch (number) {
    case ENOSPC:
      return "no space left on the device; free some or choose another place with -o";
    case EDQUOT:
      return "the disk quota is used up; free some space or choose another place with -o";
    case EFBIG:
      return "the file would be larger than the system allows; raise the limit (ulimit -f)";
    case EROFS:
      return "the file system is read-only; choose another place with -o";
    case EACCES:
    case EPERM:
      return "permission denied; choose another place with -o";
    case ENAMETOOLONG:
      return "the path is too long; use a shorter one";
    case EBUSY:
      return "is in use as a mount point; choose a directory inside it";
    case ENOENT:
      return "no such directory; create it first";
    default:
      return std::string(std::strerror(number)) + "; choose another place with -o";
  }
}

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

void flush_directory(const fs::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  ::fsync(fd);  // some file systems cannot flush a directory; the rename is atomic all the same
  ::close(fd);
}

// A name in the directory that afptraj does not write; empty when there is none.
std::string foreign_entry(const fs::path& directory) {
  const auto& own = result_file_names();
  std::error_code problem;
  for (const auto& entry : fs::directory_iterator(directory, problem)) {
    const std::string name = entry.path().filename().string();
    if (std::find(own.begin(), own.end(), name) == own.end() || entry.is_directory()) return name;
  }
  if (problem) cannot(directory, reason_for(problem.value()));
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

// The target with links followed and without trailing slashes; its parent must exist.
fs::path resolve(const fs::path& target) {
  if (target.empty()) cannot("-o", "the output directory is empty; name one");
  std::error_code problem;
  fs::path path = target;
  while (!path.has_filename() && path.has_relative_path()) path = path.parent_path();
  const fs::file_status link = fs::symlink_status(path, problem);
  if (fs::is_symlink(link) && !fs::exists(path, problem)) {
    cannot(target, "is a symbolic link to nothing; remove it or choose another place with -o");
  }
  const fs::path parent = path.has_parent_path() ? path.parent_path() : fs::path(".");
  const fs::file_status status = fs::status(parent, problem);
  if (problem.value() == ENAMETOOLONG) cannot(target, reason_for(ENAMETOOLONG));
  if (!fs::exists(status)) {
    cannot(target, "the directory '" + printable(parent.string(), 200) +
                       "' does not exist; create it first (mkdir -p)");
  }
  if (!fs::is_directory(status))
    cannot(target,
           "'" + printable(parent.string(), 200) + "' is not a directory; choose another place with -o");
  const fs::path real = fs::weakly_canonical(fs::absolute(path, problem), problem);
  if (problem) cannot(target, reason_for(problem.value()));
  if (real.filename().string().size() > 255) cannot(target, reason_for(ENAMETOOLONG));
  return real;
}

}  // namespace

const std::vector<std::string>& result_file_names() {
  static const std::vector<std::string> names{"paths.csv", "paths.step", "summary.json"};
  return names;
}

fs::path check_output(const fs::path& target, bool force, const std::vector<fs::path>& inputs) {
  const fs::path real = resolve(target);
  for (const fs::path& input : inputs) {
    std::error_code problem;
    if (fs::equivalent(input, real, problem))
      cannot(target, "is an input file; choose another place with -o");
    if (lies_in(input, real))
      cannot(target,
             "holds the input '" + printable(input.string(), 200) + "'; choose another place with -o");
  }
  if (real == real.root_path()) cannot(target, "is the root directory; name a directory in it");
  std::error_code problem;
  const fs::file_status status = fs::status(real, problem);
  if (fs::exists(status)) {
    if (!fs::is_directory(status)) cannot(target, "is a file; choose another place with -o");
    if (fs::equivalent(real, fs::current_path(problem), problem)) {
      cannot(target, "is the current directory, which cannot be replaced; name a directory in it");
    }
    const std::string foreign = foreign_entry(real);
    if (!fs::is_empty(real, problem) && !force) {
      cannot(target, foreign.empty() ? "exists; give --force to replace it"
                                     : "exists and holds other files; choose another place with -o");
    }
    if (!foreign.empty()) {
      cannot(target,
             "holds '" + printable(foreign) + "', which afptraj did not write; choose another place with -o");
    }
  }
  if (::access(real.parent_path().c_str(), W_OK | X_OK) != 0) cannot(target, reason_for(errno));
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
    if (::mkdtemp(path.data()) == nullptr) cannot(target_, reason_for(errno));
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
  cannot(target_, "other runs keep removing the temporary directory; try again");
}

void OutputDirectory::write(const std::string& name, std::string_view content) {
  const fs::path path = staging_ / name;
  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (fd < 0) cannot(target_ / name, reason_for(errno));
  int problem = 0;
  while (!content.empty() && problem == 0) {
    const ssize_t done = ::write(fd, content.data(), content.size());
    if (done < 0) {
      if (errno != EINTR) problem = errno;
    } else {
      content.remove_prefix(static_cast<std::size_t>(done));
    }
  }
  if (problem == 0 && ::fsync(fd) != 0 && errno != EINVAL) problem = errno;
  if (::close(fd) != 0 && problem == 0) problem = errno;
  if (problem != 0) cannot(target_ / name, reason_for(problem));
}

void OutputDirectory::adopt(const std::string& name) {
  const fs::path path = staging_ / name;
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) cannot(target_ / name, reason_for(errno));
  const int problem = ::fsync(fd) != 0 && errno != EINVAL ? errno : 0;
  ::close(fd);
  if (problem != 0) cannot(target_ / name, reason_for(problem));
}

void OutputDirectory::commit() {
  flush_directory(staging_);
  check_output(target_, force_, {});  // another run may have finished meanwhile
  bool exchanged = false;
  if (::rename(staging_.c_str(), target_.c_str()) != 0) {
    // A directory that holds something is not replaced by rename(2), but by an exchange.
    const bool occupied = errno == ENOTEMPTY || errno == EEXIST;
    if (!occupied) cannot(target_, reason_for(errno));
    if (!force_) cannot(target_, "exists; give --force to replace it");
    exchanged = ::renameat2(AT_FDCWD, staging_.c_str(), AT_FDCWD, target_.c_str(), RENAME_EXCHANGE) == 0;
    if (!exchanged) {
      // A file system without exchange: the old result steps aside, by a name that the next run cleans up.
      if (errno != EINVAL && errno != ENOSYS && errno != ENOTSUP) cannot(target_, reason_for(errno));
      std::string aside = (target_.parent_path() / (staging_prefix(target_) + "XXXXXX")).string();
      if (::mkdtemp(aside.data()) == nullptr) cannot(target_, reason_for(errno));
      if (::rename(target_.c_str(), aside.c_str()) != 0) cannot(target_, reason_for(errno));
      if (::rename(staging_.c_str(), target_.c_str()) != 0) {
        const int problem = errno;
        static_cast<void>(::rename(aside.c_str(), target_.c_str()));
        cannot(target_, reason_for(problem));
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
