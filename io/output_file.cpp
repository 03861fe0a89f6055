#include "io/output_file.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

#include "io/output_place.h"

namespace afptraj {
namespace fs = std::filesystem;

fs::path check_output_file(const fs::path& target, bool replace, const std::vector<fs::path>& inputs) {
  const fs::path real = resolve_output(target);
  std::error_code problem;
  for (const fs::path& input : inputs) {
    if (fs::equivalent(input, real, problem))
      cannot_write(target, "is an input file; choose another place with -o");
  }
  const fs::file_status status = fs::status(real, problem);
  if (fs::is_directory(status)) cannot_write(target, "is a directory; name a file in it with -o");
  if (fs::exists(status)) {
    if (!fs::is_regular_file(status)) cannot_write(target, "is a device or pipe; name a file with -o");
    if (!replace) cannot_write(target, "exists; give --force to replace it");
  }
  if (::access(real.parent_path().c_str(), W_OK | X_OK) != 0) cannot_write(target, write_problem(errno));
  return real;
}

OutputFile::OutputFile(const fs::path& target, bool replace, const std::vector<fs::path>& inputs)
    : target_(check_output_file(target, replace, inputs)), replace_(replace) {
  const std::string name = "." + target_.filename().string().substr(0, 200) + ".afptraj-XXXXXX";
  std::string path = (target_.parent_path() / name).string();
  fd_ = ::mkostemp(path.data(), O_CLOEXEC);
  if (fd_ < 0) cannot_write(target_, write_problem(errno));
  staging_ = path;
  const mode_t mask = ::umask(0);
  ::umask(mask);
  ::fchmod(fd_, 0666 & ~mask);  // mkostemp makes it private; a result has the usual rights
}

OutputFile::~OutputFile() {
  if (fd_ >= 0) ::close(fd_);
  if (!staging_.empty()) ::unlink(staging_.c_str());
}

void OutputFile::write(std::string_view piece) {
  while (!piece.empty()) {
    const ssize_t done = ::write(fd_, piece.data(), piece.size());
    if (done >= 0) {
      piece.remove_prefix(static_cast<std::size_t>(done));
    } else if (errno != EINTR) {
      cannot_write(target_, write_problem(errno));
    }
  }
}

void OutputFile::commit() {
  if (::fsync(fd_) != 0 && errno != EINVAL) cannot_write(target_, write_problem(errno));
  const int closed = ::close(fd_);
  fd_ = -1;
  if (closed != 0) cannot_write(target_, write_problem(errno));
  // Without leave to replace, a file that has appeared meanwhile stays.
  const unsigned flags = replace_ ? 0 : RENAME_NOREPLACE;
  int problem = ::renameat2(AT_FDCWD, staging_.c_str(), AT_FDCWD, target_.c_str(), flags) == 0 ? 0 : errno;
  if (problem == EINVAL || problem == ENOSYS) {  // a file system that cannot refuse
    check_output_file(target_, replace_, {});
    problem = ::rename(staging_.c_str(), target_.c_str()) == 0 ? 0 : errno;
  }
  if (problem == EEXIST) cannot_write(target_, "exists; give --force to replace it");
  if (problem != 0) cannot_write(target_, write_problem(problem));
  staging_.clear();
  flush_directory(target_.parent_path());
}

}  // namespace afptraj
