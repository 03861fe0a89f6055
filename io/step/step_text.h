#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace afptraj::step {

/// The instances of a STEP file as text: what can be known before OpenCASCADE looks at it.
struct StepText {
  struct Instance {
    int id = 0;
    int line = 0;
    std::string_view type;  ///< "ADVANCED_FACE"; the first of a complex instance
    std::size_t first_reference = 0, references = 0;
  };
  std::string schema;
  std::vector<Instance> instances;               ///< in the order of the file
  std::vector<int> references;                   ///< ids, grouped by instance
  std::map<std::string_view, int> keywords;      ///< how often each entity keyword occurs
  std::vector<std::string_view> external_files;  ///< names in DOCUMENT_FILE instances

  int count(std::string_view keyword) const;
};

/// Reads a regular file whole. Throws Error(bad_input) with the reason and the fix.
std::string read_file(const std::filesystem::path& path, std::uintmax_t max_bytes);

/// Checks that `bytes` (which must outlive the result) is a whole STEP file and lists its
/// instances. A UTF-8 byte order mark is passed over.
///
/// Refused, as Error(bad_input), each with its own line: empty or blank files, other formats by
/// their first bytes (PNG, PDF, ZIP, STL, IGES, Git LFS, UTF-16 ...), no ISO-10303-21, strings,
/// comments or sections that do not end, lists nested deeper than `nesting_limit`, words such as
/// NaN where a number belongs, numbers and ids that overflow, no instances.
StepText check_step_text(const std::string& bytes, const std::string& where);
inline constexpr int nesting_limit = 200;

/// Why OpenCASCADE may have crashed or refused: an instance that refers to itself, directly or
/// over others ("#15 = ORIENTED_EDGE (line 20) refers to itself").
std::optional<std::string> find_cycle(const StepText& text);

/// References to instances that are not there, and ids used twice: one line each, at most a few.
std::vector<std::string> find_broken_references(const StepText& text);

/// The geometry-bearing kinds of instances the file has, for messages: "12 TETRAHEDRA ...".
std::string describe_contents(const StepText& text);

}  // namespace afptraj::step
