#pragma once

#include <optional>
#include <string>
#include <toml.hpp>
#include <utility>
#include <vector>

namespace afptraj {

/// A TOML file. Throws Error(usage, "file:line:column", what is wrong; what to do).
toml::value parse_toml_file(const std::string& path);

/// "file:line:column" of a value, and of the key that stands before it.
std::string toml_place(const std::string& path, const toml::source_location& at);
std::string toml_key_place(const std::string& path, const std::string& name,
                           const toml::source_location& value);

/// TOML tables are unordered; the entry that stands first in the file comes first.
std::vector<std::pair<std::string, toml::value>> in_file_order(const toml::table& table);

/// Takes the keys of a table one by one; what is left at the end is unknown. Each throws Error(usage,
/// "file:line:column", ...) for a wrong type, a value out of range, or a missing key.
class TomlTable {
 public:
  /// `name` as in messages: "[carriage]", or "the file".
  TomlTable(const std::string& path, const toml::value& table, std::string name);

  double number(const std::string& key, double lowest, double highest);
  std::optional<double> optional_number(const std::string& key, double lowest, double highest);
  std::optional<std::int64_t> optional_count(const std::string& key, std::int64_t lowest,
                                             std::int64_t highest);
  std::string text(const std::string& key);
  std::optional<std::string> optional_text(const std::string& key);
  /// One of `words`.
  std::string word(const std::string& key, const std::vector<std::string>& words,
                   const std::string& otherwise);
  bool flag(const std::string& key, bool otherwise);
  /// [lowest, highest], growing.
  std::optional<std::pair<double, double>> optional_range(const std::string& key);
  std::optional<TomlTable> optional_table(const std::string& key);
  TomlTable table(const std::string& key);
  /// [[key]], at least one.
  std::vector<TomlTable> tables(const std::string& key);

  /// Refuses keys that nobody asked for, with the nearest that is known.
  void finish() const;
  [[noreturn]] void fail(const std::string& key, const std::string& message) const;

 private:
  const toml::value* find(const std::string& key);
  const toml::value& required(const std::string& key);
  double as_number(const std::string& key, const toml::value& value, double lowest, double highest) const;

  const std::string& path_;
  const toml::value* table_;
  std::string name_;
  std::vector<std::string> known_;
};

}  // namespace afptraj
