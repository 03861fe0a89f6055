#include "io/step/step_text.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <limits>
#include <unordered_map>
#include <utility>

#include "geometry/error.h"

namespace afptraj::step {
namespace {

[[noreturn]] void refuse(const std::string& where, const std::string& message) {
  throw Error(ErrorCode::bad_input, where, message);
}

struct Magic {
  std::string_view bytes;
  const char* what;
};
constexpr std::array<Magic, 17> magics = {{{"\x89PNG", "a PNG picture"},
                                           {"\xff\xd8\xff", "a JPEG picture"},
                                           {"GIF8", "a GIF picture"},
                                           {"%PDF", "a PDF document"},
                                           {"PK\x03\x04", "a ZIP archive (or an Office or 3MF file)"},
                                           {"\x1f\x8b", "a gzip archive"},
                                           {"7z\xbc\xaf", "a 7z archive"},
                                           {"\x7f"
                                            "ELF",
                                            "a program"},
                                           {"<!DOCTYPE", "an HTML page"},
                                           {"<!doctype", "an HTML page"},
                                           {"<html", "an HTML page"},
                                           {"<?xml", "an XML file"},
                                           {"DBRep_DrawableShape", "an OpenCASCADE BREP file"},
                                           {"CASCADE Topology", "an OpenCASCADE BREP file"},
                                           {"# vtk", "a VTK file"},
                                           {"glTF", "a glTF file"},
                                           {"\x89HDF", "an HDF5 file"}}};

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\f' || c == '\v' || c == '\0';
}

bool is_iges(std::string_view bytes) {
  const std::string_view line = bytes.substr(0, bytes.find_first_of("\r\n"));
  return line.size() >= 73 && line.size() <= 81 && line[72] == 'S';
}

/// Tells what a file that is not STEP is; never returns.
[[noreturn]] void refuse_other_format(std::string_view bytes, const std::string& where) {
  const std::string fix = "; export the part as STEP (AP203, AP214 or AP242)";
  for (const Magic& magic : magics) {
    if (bytes.substr(0, magic.bytes.size()) == magic.bytes)
      refuse(where, std::string("is ") + magic.what + ", not STEP" + fix);
  }
  if (bytes.starts_with("version https://git-lfs")) {
    refuse(where, "is a Git LFS pointer, not the STEP file itself; run `git lfs pull` to fetch it");
  }
  if (bytes.starts_with("solid"))
    refuse(where, "is an STL mesh, not STEP; a mesh has no surfaces to plan on" + fix);
  if (bytes.size() > 84) {
    std::uint32_t triangles = 0;
    std::memcpy(&triangles, bytes.data() + 80, 4);
    if (bytes.size() == 84 + std::uint64_t{50} * triangles) {
      refuse(where, "is a binary STL mesh, not STEP; a mesh has no surfaces to plan on" + fix);
    }
  }
  if (is_iges(bytes)) refuse(where, "is an IGES file, not STEP" + fix);
  refuse(where, "is not a STEP file: it does not begin with ISO-10303-21" + fix);
}

void check_encoding(std::string_view bytes, const std::string& where) {
  const bool utf16_mark = bytes.starts_with("\xff\xfe") || bytes.starts_with("\xfe\xff");
  using namespace std::string_view_literals;
  const bool utf16_text = bytes.starts_with("I\0S\0O\0"sv) || bytes.starts_with("\0I\0S\0O"sv);
  if (utf16_mark || utf16_text)
    refuse(where,
           "is encoded in UTF-16; STEP is ASCII: convert it, for example with `iconv -f UTF-16 -t ASCII`");
}

/// One pass over the text: strings, comments, nesting, instances.
class Scanner {
 public:
  Scanner(std::string_view bytes, const std::string& where) : s_(bytes), where_(where) {}

  StepText scan() {
    if (!word_here("ISO-10303-21")) refuse_other_format(s_.substr(i_), where_);
    i_ += std::strlen("ISO-10303-21");
    while (i_ < s_.size() && !ended_) step();
    check_end();
    return std::move(text_);
  }

  void skip_mark_and_blanks() {
    if (s_.starts_with("\xef\xbb\xbf")) i_ = 3;
    while (i_ < s_.size()) {
      if (s_[i_] == '/' && i_ + 1 < s_.size() && s_[i_ + 1] == '*') {
        skip_comment();
      } else if (is_blank(s_[i_])) {
        line_ += s_[i_] == '\n';
        ++i_;
      } else {
        return;
      }
    }
    refuse(where_, "holds only blanks; export the part again");
  }

 private:
  enum class Section { none, header, data };

  bool word_here(std::string_view word) const { return s_.substr(i_, word.size()) == word; }

  [[noreturn]] void refuse_here(const std::string& message) const {
    refuse(where_ + ":" + std::to_string(line_), message);
  }

  void step() {
    const char c = s_[i_];
    if (c == '\n') {
      ++line_, ++i_;
    } else if (is_blank(c)) {
      ++i_;
    } else if (c == '\'') {
      read_string();
    } else if (c == '"') {
      skip_binary();
    } else if (c == '/' && i_ + 1 < s_.size() && s_[i_ + 1] == '*') {
      skip_comment();
    } else if (c == '#') {
      read_reference();
    } else if (c == '.' && i_ + 1 < s_.size() && std::isalpha(static_cast<unsigned char>(s_[i_ + 1]))) {
      skip_enumeration();
    } else if (std::isalpha(static_cast<unsigned char>(c)) || c == '!' || c == '_') {
      read_word();
    } else if (std::isdigit(static_cast<unsigned char>(c)) || c == '-' || c == '+' || c == '.') {
      read_number();
    } else {
      read_mark(c);
    }
  }

  void read_mark(char c) {
    if (c == '(') {
      if (++depth_ > nesting_limit) {
        refuse_here("lists are nested deeper than " + std::to_string(nesting_limit) +
                    "; the file is damaged, export it again");
      }
    } else if (c == ')') {
      --depth_;
    } else if (c == ';') {
      if (section_ == Section::data && depth_ != 0)
        refuse_here("brackets do not match; the file is damaged, export it again");
      depth_ = 0;
      in_instance_ = false;
    } else if (c == '=' && depth_ == 0) {
      begin_instance();
    }
    ++i_;
  }

  void read_string() {
    const std::size_t begin = ++i_;
    const int begin_line = line_;
    while (true) {
      const void* quote = std::memchr(s_.data() + i_, '\'', s_.size() - i_);
      if (!quote)
        refuse(where_ + ":" + std::to_string(begin_line),
               "a string does not end; the file is cut off or damaged, export it again");
      const auto end = static_cast<std::size_t>(static_cast<const char*>(quote) - s_.data());
      line_ += static_cast<int>(std::count(s_.begin() + static_cast<std::ptrdiff_t>(i_),
                                           s_.begin() + static_cast<std::ptrdiff_t>(end), '\n'));
      i_ = end + 1;
      if (i_ < s_.size() && s_[i_] == '\'') {
        ++i_;
        continue;
      }
      take_string(s_.substr(begin, end - begin));
      return;
    }
  }

  void take_string(std::string_view value) {
    if (section_ == Section::header && last_word_ == "FILE_SCHEMA" && text_.schema.empty())
      text_.schema = value;
    if (section_ == Section::data && in_instance_ && text_.instances.back().type == "DOCUMENT_FILE" &&
        !took_document_) {
      took_document_ = true;
      text_.external_files.push_back(value);
    }
  }

  void skip_comment() {
    const std::size_t end = s_.find("*/", i_ + 2);
    if (end == std::string_view::npos)
      refuse_here("a comment does not end; the file is cut off or damaged, export it again");
    line_ += static_cast<int>(std::count(s_.begin() + static_cast<std::ptrdiff_t>(i_),
                                         s_.begin() + static_cast<std::ptrdiff_t>(end), '\n'));
    i_ = end + 2;
  }

  void skip_binary() {
    const std::size_t end = s_.find('"', i_ + 1);
    if (end == std::string_view::npos)
      refuse_here("a binary value does not end; the file is cut off or damaged, export it again");
    i_ = end + 1;
  }

  void skip_enumeration() {
    ++i_;
    while (i_ < s_.size() && (std::isalnum(static_cast<unsigned char>(s_[i_])) || s_[i_] == '_')) ++i_;
    if (i_ < s_.size() && s_[i_] == '.') ++i_;
  }

  void read_reference() {
    const std::size_t begin = ++i_;
    int id = 0;
    const auto [end, fault] = std::from_chars(s_.data() + begin, s_.data() + s_.size(), id);
    i_ = static_cast<std::size_t>(end - s_.data());
    if (fault == std::errc::result_out_of_range)
      refuse_here("an instance number is larger than 2147483647; export the file again");
    if (fault != std::errc() || section_ != Section::data) return;
    if (in_instance_) {
      text_.references.push_back(id);
      ++text_.instances.back().references;
    } else {
      pending_id_ = id;
    }
  }

  void begin_instance() {
    if (section_ != Section::data || in_instance_ || pending_id_ == 0) return;
    in_instance_ = true;
    took_document_ = false;
    text_.instances.push_back({pending_id_, line_, {}, text_.references.size(), 0});
    pending_id_ = 0;
  }

  void read_word() {
    const std::size_t begin = i_++;
    while (i_ < s_.size() &&
           (std::isalnum(static_cast<unsigned char>(s_[i_])) || s_[i_] == '_' || s_[i_] == '-'))
      ++i_;
    const std::string_view word = s_.substr(begin, i_ - begin);
    if (!in_instance_ && depth_ == 0) {
      read_section_word(word);
    } else if (in_instance_) {
      std::size_t next = i_;
      while (next < s_.size() && is_blank(s_[next])) ++next;
      if (next < s_.size() && s_[next] == '(') {
        if (text_.instances.back().type.empty()) text_.instances.back().type = word;
        if (depth_ <= 1) ++text_.keywords[word];
      } else if (next < s_.size()) {  // at the end of the file the end is what is wrong
        refuse_here("\"" + std::string(word.substr(0, 40)) +
                    "\" stands where a number or a reference belongs; export the file again");
      }
    }
  }

  void read_section_word(std::string_view word) {
    last_word_ = word;
    if (word == "HEADER") section_ = Section::header;
    if (word == "DATA") section_ = Section::data, data_seen_ = true, data_open_ = true;
    if (word == "ENDSEC") {
      if (section_ == Section::data) data_open_ = false;
      section_ = Section::none;
    }
    if (word == "END-ISO-10303-21") ended_ = true;
  }

  void read_number() {
    const std::size_t begin = i_++;
    std::size_t exponent = 0;
    while (i_ < s_.size()) {
      const char c = s_[i_];
      if (c == 'E' || c == 'e') {
        exponent = i_ + 1;
      } else if (!std::isdigit(static_cast<unsigned char>(c)) && c != '.' &&
                 !((c == '-' || c == '+') && exponent == i_)) {
        break;
      }
      ++i_;
    }
    if (section_ != Section::data || exponent == 0) return;
    int power = 0;
    const char* first = s_.data() + exponent + (s_[exponent] == '+' ? 1 : 0);
    const auto [end, fault] = std::from_chars(first, s_.data() + i_, power);
    if ((fault == std::errc() && power > 99) ||
        (fault == std::errc::result_out_of_range && s_[exponent] != '-')) {
      refuse_here("the number " + std::string(s_.substr(begin, std::min<std::size_t>(i_ - begin, 40))) +
                  " is out of range; export the file again");
    }
  }

  void check_end() const {
    const std::string again =
        "; the file is cut off (a broken download or a full disk), export or copy it again";
    if (!data_seen_)
      refuse(where_, ended_ ? "has a header but no DATA section; export the part again"
                            : "ends within its header" + again);
    if (data_open_)
      refuse(where_ + ":" + std::to_string(line_), "ends within its DATA section, without ENDSEC" + again);
    if (!ended_) refuse(where_ + ":" + std::to_string(line_), "ends without END-ISO-10303-21" + again);
    if (text_.instances.empty()) refuse(where_, "has an empty DATA section; export the part again");
  }

  std::string_view s_;
  const std::string& where_;
  std::size_t i_ = 0;
  int line_ = 1;
  int depth_ = 0;
  int pending_id_ = 0;
  Section section_ = Section::none;
  bool in_instance_ = false, took_document_ = false, ended_ = false, data_seen_ = false, data_open_ = false;
  std::string_view last_word_;
  StepText text_;
};

std::unordered_map<int, std::size_t> index_by_id(const StepText& text) {
  std::unordered_map<int, std::size_t> index;
  index.reserve(text.instances.size());
  for (std::size_t i = 0; i < text.instances.size(); ++i) index.emplace(text.instances[i].id, i);
  return index;
}

std::string describe(const StepText::Instance& instance) {
  return "#" + std::to_string(instance.id) + " = " + std::string(instance.type) + " (line " +
         std::to_string(instance.line) + ")";
}

/// Closes a descriptor at the end of a scope.
struct FileDescriptor {
  int fd;
  ~FileDescriptor() {
    if (fd >= 0) ::close(fd);
  }
};

}  // namespace

int StepText::count(std::string_view keyword) const {
  const auto found = keywords.find(keyword);
  return found == keywords.end() ? 0 : found->second;
}

std::string read_file(const std::filesystem::path& path, std::uintmax_t max_bytes) {
  const std::string where = path.string();
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) {
    if (errno == ENOENT || errno == ENOTDIR) refuse(where, "no such file; check the path");
    refuse(where, std::string("cannot be looked at (") + std::strerror(errno) +
                      "); check the path and its permissions");
  }
  if (S_ISDIR(status.st_mode)) refuse(where, "is a directory; give the STEP file inside it");
  if (!S_ISREG(status.st_mode))
    refuse(where, "is a pipe or a device, not a regular file; save the part to a file first");
  if (status.st_size == 0) refuse(where, "is empty (0 bytes); export the part again");
  const auto size = static_cast<std::uintmax_t>(status.st_size);
  if (size > max_bytes) {
    refuse(where, "has " + std::to_string(size / 1000000) + " MB, more than the limit of " +
                      std::to_string(max_bytes / 1000000) + " MB; export only the faces to lay on");
  }
  const FileDescriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  if (file.fd < 0)
    refuse(where, std::string("cannot be opened (") + std::strerror(errno) + "); check its permissions");
  std::string bytes(size, '\0');
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t got = ::read(file.fd, bytes.data() + done, bytes.size() - done);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) refuse(where, std::string("cannot be read (") + std::strerror(errno) + "); check the disk");
    if (got == 0) refuse(where, "became shorter while it was read; wait until it is written and try again");
    done += static_cast<std::size_t>(got);
  }
  return bytes;
}

StepText check_step_text(const std::string& bytes, const std::string& where) {
  check_encoding(bytes, where);
  if (is_iges(bytes)) refuse_other_format(bytes, where);
  Scanner scanner(bytes, where);
  scanner.skip_mark_and_blanks();
  return scanner.scan();
}

std::optional<std::string> find_cycle(const StepText& text) {
  const auto index = index_by_id(text);
  enum : unsigned char { unseen, open, done };
  std::vector<unsigned char> state(text.instances.size(), unseen);
  std::vector<std::pair<std::size_t, std::size_t>> stack;  // instance, next reference
  for (std::size_t root = 0; root < text.instances.size(); ++root) {
    if (state[root] != unseen) continue;
    state[root] = open;
    stack.assign(1, {root, 0});
    while (!stack.empty()) {
      auto& [at, next] = stack.back();
      const StepText::Instance& instance = text.instances[at];
      if (next == instance.references) {
        state[at] = done;
        stack.pop_back();
        continue;
      }
      const auto target = index.find(text.references[instance.first_reference + next++]);
      if (target == index.end()) continue;
      if (state[target->second] == open) {
        const bool direct = target->second == at;
        return describe(text.instances[target->second]) + " refers to itself" +
               (direct ? "" : " over " + describe(instance));
      }
      if (state[target->second] == unseen) {
        state[target->second] = open;
        stack.push_back({target->second, 0});
      }
    }
  }
  return std::nullopt;
}

std::vector<std::string> find_broken_references(const StepText& text) {
  constexpr std::size_t most = 3;
  std::vector<std::string> lines;
  const auto index = index_by_id(text);
  for (std::size_t i = 0; i < text.instances.size() && lines.size() < most; ++i) {
    const StepText::Instance& instance = text.instances[i];
    if (index.at(instance.id) != i)
      lines.push_back(describe(instance) + " uses a number that is already taken");
    for (std::size_t k = 0; k < instance.references && lines.size() < most; ++k) {
      const int id = text.references[instance.first_reference + k];
      if (!index.contains(id))
        lines.push_back(describe(instance) + " refers to #" + std::to_string(id) +
                        ", which is not in the file");
    }
  }
  return lines;
}

std::string describe_contents(const StepText& text) {
  constexpr std::array<std::string_view, 18> telling = {"MANIFOLD_SOLID_BREP",
                                                        "SHELL_BASED_SURFACE_MODEL",
                                                        "FACETED_BREP",
                                                        "FACE_SURFACE",
                                                        "CSG_SOLID",
                                                        "TESSELLATED_SOLID",
                                                        "TESSELLATED_SHELL",
                                                        "TRIANGULATED_FACE",
                                                        "COMPLEX_TRIANGULATED_FACE",
                                                        "GEOMETRIC_CURVE_SET",
                                                        "B_SPLINE_CURVE_WITH_KNOTS",
                                                        "POLYLINE",
                                                        "FEA_MODEL_3D",
                                                        "NODE",
                                                        "VOLUME_3D_ELEMENT_REPRESENTATION",
                                                        "SURFACE_3D_ELEMENT_REPRESENTATION",
                                                        "DOCUMENT_FILE",
                                                        "NEXT_ASSEMBLY_USAGE_OCCURRENCE"};
  std::string list;
  for (const std::string_view keyword : telling) {
    if (const int n = text.count(keyword); n > 0)
      list += (list.empty() ? "" : ", ") + std::to_string(n) + " " + std::string(keyword);
  }
  return list.empty() ? std::to_string(text.instances.size()) + " instances without geometry" : list;
}

}  // namespace afptraj::step
