#include "io/output_place.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "geometry/error.h"
#include "io/text_file.h"

namespace afptraj {
namespace fs = std::filesystem;

void cannot_write(const fs::path& path, const std::string& message) {
  throw Error(ErrorCode::cannot_write, path.string(), message);
}

std::string write_problem(int number) {
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

void flush_directory(const fs::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  ::fsync(fd);  // some file systems cannot flush a directory; the rename is atomic all the same
  ::close(fd);
}

// The target with links followed and without trailing slashes; its parent must exist.
fs::path resolve_output(const fs::path& target) {
  if (target.empty()) cannot_write("-o", "the output path is empty; name one");
  std::error_code problem;
  fs::path path = target;
  while (!path.has_filename() && path.has_relative_path()) path = path.parent_path();
  const fs::file_status link = fs::symlink_status(path, problem);
  if (fs::is_symlink(link) && !fs::exists(path, problem)) {
    cannot_write(target, "is a symbolic link to nothing; remove it or choose another place with -o");
  }
  const fs::path parent = path.has_parent_path() ? path.parent_path() : fs::path(".");
  const fs::file_status status = fs::status(parent, problem);
  if (problem.value() == ENAMETOOLONG) cannot_write(target, write_problem(ENAMETOOLONG));
  if (!fs::exists(status)) {
    cannot_write(target, "the directory '" + printable(parent.string(), 200) +
                             "' does not exist; create it first (mkdir -p)");
  }
  if (!fs::is_directory(status))
    cannot_write(
        target, "'" + printable(parent.string(), 200) + "' is not a directory; choose another place with -o");
  const fs::path real = fs::weakly_canonical(fs::absolute(path, problem), problem);
  if (problem) cannot_write(target, write_problem(problem.value()));
  if (real.filename().string().size() > 255) cannot_write(target, write_problem(ENAMETOOLONG));
  return real;
}

}  // namespace afptraj
