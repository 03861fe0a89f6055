#include "io/text_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>

namespace afptraj {
namespace {

class OpenFile {
 public:
  explicit OpenFile(const std::string& path) : fd_(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {}
  ~OpenFile() {
    if (fd_ >= 0) ::close(fd_);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  int fd() const { return fd_; }

 private:
  int fd_;
};

std::string reason_for(int number) {
  switch (number) {
    case ENOENT:
      return "no such file; check the path";
    case EACCES:
      return "permission denied; make the file readable";
    case ENOTDIR:
      return "a part of the path is not a directory; check the path";
    case ENAMETOOLONG:
      return "the path is too long; use a shorter one";
    case ELOOP:
      return "too many symbolic links; check the path";
    default:
      return std::string(std::strerror(number)) + "; check the file";
  }
}

// Opens a regular file and gives its size.
std::size_t require_regular(const std::string& path, const OpenFile& file, ErrorCode code) {
  if (path.empty()) throw Error(code, "''", "the file name is empty; name a file");
  if (file.fd() < 0) throw Error(code, path, reason_for(errno));
  struct stat status {};
  if (::fstat(file.fd(), &status) != 0) throw Error(code, path, reason_for(errno));
  if (S_ISDIR(status.st_mode)) throw Error(code, path, "is a directory; name a file in it");
  if (!S_ISREG(status.st_mode)) {
    throw Error(code, path, "is a device or pipe, not a file; save the data to a file first");
  }
  return static_cast<std::size_t>(status.st_size);
}

int line_of(std::string_view text, std::size_t at) {
  return 1 + static_cast<int>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
}

void refuse_known_binary(const std::string& path, std::string_view text, ErrorCode code) {
  static constexpr std::array<std::pair<std::string_view, const char*>, 7> known{{
      {"\x89PNG", "a PNG picture"},
      {"\xff\xd8\xff", "a JPEG picture"},
      {"%PDF", "a PDF document"},
      {"PK\x03\x04", "a zip archive or spreadsheet (save it as CSV, UTF-8)"},
      {"\xd0\xcf\x11\xe0", "an old spreadsheet (save it as CSV, UTF-8)"},
      {"ISO-10303-21", "a STEP file"},
      {"\x7f"
       "ELF",
       "a program"},
  }};
  for (const auto& [magic, what] : known) {
    if (text.substr(0, magic.size()) == magic) {
      throw Error(code, path, std::string("looks like ") + what + ", not a text table; give the right file");
    }
  }
}

// Length of the valid UTF-8 sequence at `at`, 0 when there is none. Source: Unicode 15, table 3-7.
std::size_t utf8_length(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) -> unsigned {
    return at + i < text.size() ? static_cast<unsigned char>(text[at + i]) : 0U;
  };
  const auto tail = [&](std::size_t i) { return (byte(i) & 0xC0U) == 0x80U; };
  const unsigned b0 = byte(0), b1 = byte(1);
  if (b0 < 0x80) return 1;
  if (b0 >= 0xC2 && b0 <= 0xDF) return tail(1) ? 2 : 0;
  if (b0 >= 0xE0 && b0 <= 0xEF) {
    const bool overlong = b0 == 0xE0 && b1 < 0xA0, surrogate = b0 == 0xED && b1 > 0x9F;
    return tail(1) && tail(2) && !overlong && !surrogate ? 3 : 0;
  }
  if (b0 >= 0xF0 && b0 <= 0xF4) {
    const bool overlong = b0 == 0xF0 && b1 < 0x90, beyond = b0 == 0xF4 && b1 > 0x8F;
    return tail(1) && tail(2) && tail(3) && !overlong && !beyond ? 4 : 0;
  }
  return 0;
}

void require_utf8(const std::string& path, std::string_view text, ErrorCode code) {
  for (std::size_t at = 0; at < text.size();) {
    if (text[at] == '\0') {
      throw Error(code, file_line(path, line_of(text, at)),
                  "holds a NUL byte: not a text file; save it as UTF-8 text");
    }
    const std::size_t length = utf8_length(text, at);
    if (length == 0) {
      throw Error(code, file_line(path, line_of(text, at)), "is not valid UTF-8; save the file as UTF-8");
    }
    at += length;
  }
}

}  // namespace

std::string file_line(const std::string& path, int line) { return path + ":" + std::to_string(line); }

std::string printable(const std::string& text, std::size_t longest) {
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '\n') {
      out += "\\n";
    } else if (c == '\r') {
      out += "\\r";
    } else if (c == '\t') {
      out += "\\t";
    } else if (byte < 0x20 || byte == 0x7f) {
      out += '?';
    } else {
      out += c;
    }
  }
  if (out.size() > longest) {
    std::size_t cut = longest;
    while (cut > 0 && (static_cast<unsigned char>(out[cut]) & 0xC0U) == 0x80U) --cut;
    out = out.substr(0, cut) + "...";
  }
  return out;
}

void require_readable_file(const std::string& path, ErrorCode code) {
  const OpenFile file(path);
  require_regular(path, file, code);
}

std::string read_file(const std::string& path, std::size_t limit_bytes, ErrorCode code) {
  const OpenFile file(path);
  const std::size_t size = require_regular(path, file, code);
  if (size > limit_bytes) {
    throw Error(ErrorCode::resource_limit, path,
                "is " + std::to_string(size / 1000000) + " MB, more than the limit of " +
                    std::to_string(limit_bytes / 1000000) + " MB; split it");
  }
  std::string text(size, '\0');
  std::size_t filled = 0;
  while (filled < text.size()) {
    const ssize_t got = ::read(file.fd(), text.data() + filled, text.size() - filled);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw Error(code, path, reason_for(errno));
    if (got == 0) break;
    filled += static_cast<std::size_t>(got);
  }
  char more = 0;
  if (filled < size || ::read(file.fd(), &more, 1) == 1) {
    throw Error(code, path, "changes while it is being read; wait until it is complete");
  }
  return text;
}

std::string read_text_file(const std::string& path, std::size_t limit_bytes, ErrorCode code) {
  std::string text = read_file(path, limit_bytes, code);
  const auto starts = [&](std::string_view magic) {
    return std::string_view(text).substr(0, magic.size()) == magic;
  };
  if (starts("\xff\xfe") || starts("\xfe\xff")) {
    throw Error(code, path, "is UTF-16 text; save it as UTF-8");
  }
  if (starts("\xef\xbb\xbf")) text.erase(0, 3);
  refuse_known_binary(path, text, code);
  require_utf8(path, text, code);
  return text;
}

}  // namespace afptraj
