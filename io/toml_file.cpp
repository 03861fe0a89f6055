#include "io/toml_file.h"

#include <algorithm>
#include <sstream>

#include "geometry/error.h"
#include "io/nearest_name.h"
#include "io/text_file.h"

namespace afptraj {
namespace {

[[noreturn]] void wrong(const std::string& where, const std::string& message) {
  throw Error(ErrorCode::usage, where, message);
}

// toml11 recurses into nested arrays; a file that nests absurdly deep is refused before.
void refuse_deep_nesting(const std::string& path, const std::string& text) {
  int depth = 0, line = 1;
  for (const char c : text) {
    if (c == '\n') ++line;
    if (c == '[' || c == '{') ++depth;
    if ((c == ']' || c == '}') && depth > 0) --depth;
    if (depth > 32)
      wrong(file_line(path, line), "brackets are nested more than 32 deep; a job file needs two");
  }
}

// The first line of toml11's message, without its "[error] toml::parse_...:" heading.
std::string syntax_message(const std::string& what) {
  std::string line = what.substr(0, what.find('\n'));
  if (line.rfind("[error] ", 0) == 0) line.erase(0, 8);
  if (line.rfind("toml::", 0) == 0 && line.find(": ") != std::string::npos)
    line.erase(0, line.find(": ") + 2);
  return line;
}

std::string short_text(double x) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out << x;
  return out.str();
}

std::string list(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

}  // namespace

toml::value parse_toml_file(const std::string& path) {
  const std::string text = read_text_file(path, 1000000, ErrorCode::usage);
  refuse_deep_nesting(path, text);
  std::istringstream stream(text);
  try {
    return toml::parse(stream, path);
  } catch (const toml::exception& e) {
    wrong(toml_place(path, e.location()),
          "is not valid TOML: " + printable(syntax_message(e.what()), 160) + "; correct the line");
  } catch (const std::exception& e) {
    wrong(path, "is not valid TOML: " + printable(syntax_message(e.what()), 160) + "; correct the file");
  }
}

std::string toml_place(const std::string& path, const toml::source_location& at) {
  return file_line(path, static_cast<int>(at.line())) + ":" + std::to_string(at.column());
}

// toml11 knows where a key's value begins, the key stands before it on the line.
std::string toml_key_place(const std::string& path, const std::string& name,
                           const toml::source_location& value) {
  const std::size_t at = value.line_str().find(name);
  const std::size_t column = at == std::string::npos ? value.column() : at + 1;
  return file_line(path, static_cast<int>(value.line())) + ":" + std::to_string(column);
}

std::vector<std::pair<std::string, toml::value>> in_file_order(const toml::table& table) {
  std::vector<std::pair<std::string, toml::value>> entries(table.begin(), table.end());
  std::sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) {
    const auto la = a.second.location(), lb = b.second.location();
    return std::make_tuple(la.line(), la.column(), a.first) <
           std::make_tuple(lb.line(), lb.column(), b.first);
  });
  return entries;
}

TomlTable::TomlTable(const std::string& path, const toml::value& table, std::string name)
    : path_(path), table_(&table), name_(std::move(name)) {
  if (!table.is_table())
    wrong(toml_place(path, table.location()), name_ + " must be a table; write it on a line of its own");
}

const toml::value* TomlTable::find(const std::string& key) {
  known_.push_back(key);
  const auto& entries = table_->as_table();
  const auto at = entries.find(key);
  return at == entries.end() ? nullptr : &at->second;
}

const toml::value& TomlTable::required(const std::string& key) {
  const toml::value* value = find(key);
  if (value != nullptr) return *value;
  // A slip of the pen is told as such.
  for (const auto& [name, unused] : in_file_order(table_->as_table())) {
    const std::string hint = did_you_mean(name, {key});
    if (!hint.empty()) fail(name, "unknown key '" + printable(name) + "' in " + name_ + hint);
  }
  wrong(path_, name_ + " lacks '" + key + "'; write it there");
}

void TomlTable::fail(const std::string& key, const std::string& message) const {
  const auto& entries = table_->as_table();
  const auto at = entries.find(key);
  wrong(at == entries.end() ? path_ : toml_key_place(path_, key, at->second.location()), message);
}

double TomlTable::as_number(const std::string& key, const toml::value& value, double lowest,
                            double highest) const {
  if (!value.is_integer() && !value.is_floating())
    fail(key, "'" + key + "' in " + name_ + " must be a number; write it without quotes");
  const double x =
      value.is_integer() ? static_cast<double>(value.as_integer()) : static_cast<double>(value.as_floating());
  if (!(x >= lowest && x <= highest))
    fail(key, "'" + key + "' in " + name_ + " is " + short_text(x) + "; it must lie in " +
                  short_text(lowest) + " ... " + short_text(highest));
  return x;
}

double TomlTable::number(const std::string& key, double lowest, double highest) {
  return as_number(key, required(key), lowest, highest);
}

std::optional<double> TomlTable::optional_number(const std::string& key, double lowest, double highest) {
  const toml::value* value = find(key);
  if (value == nullptr) return std::nullopt;
  return as_number(key, *value, lowest, highest);
}

std::optional<std::int64_t> TomlTable::optional_count(const std::string& key, std::int64_t lowest,
                                                      std::int64_t highest) {
  const toml::value* value = find(key);
  if (value == nullptr) return std::nullopt;
  if (!value->is_integer()) fail(key, "'" + key + "' in " + name_ + " must be a whole number");
  as_number(key, *value, static_cast<double>(lowest), static_cast<double>(highest));
  return value->as_integer();
}

std::optional<std::string> TomlTable::optional_text(const std::string& key) {
  const toml::value* value = find(key);
  if (value == nullptr) return std::nullopt;
  if (!value->is_string()) fail(key, "'" + key + "' in " + name_ + " must be text; write it in quotes");
  return value->as_string().str;
}

std::string TomlTable::text(const std::string& key) {
  required(key);
  return *optional_text(key);
}

std::string TomlTable::word(const std::string& key, const std::vector<std::string>& words,
                            const std::string& otherwise) {
  const std::string word = optional_text(key).value_or(otherwise);
  if (std::find(words.begin(), words.end(), word) == words.end()) {
    const std::string hint = did_you_mean(word, words);
    fail(key, "'" + key + "' in " + name_ + " is '" + printable(word) + "'" +
                  (hint.empty() ? "; use one of " + list(words) : hint));
  }
  return word;
}

bool TomlTable::flag(const std::string& key, bool otherwise) {
  const toml::value* value = find(key);
  if (value == nullptr) return otherwise;
  if (!value->is_boolean()) fail(key, "'" + key + "' in " + name_ + " must be true or false");
  return value->as_boolean();
}

std::optional<std::pair<double, double>> TomlTable::optional_range(const std::string& key) {
  constexpr double farthest = 1e9;
  const toml::value* value = find(key);
  if (value == nullptr) return std::nullopt;
  if (!value->is_array() || value->as_array().size() != 2)
    fail(key, "'" + key + "' in " + name_ + " must be two numbers; write [lowest, highest]");
  const double low = as_number(key, value->as_array()[0], -farthest, farthest);
  const double high = as_number(key, value->as_array()[1], -farthest, farthest);
  if (!(low < high)) fail(key, "'" + key + "' in " + name_ + " runs backward; write [lowest, highest]");
  return std::pair(low, high);
}

std::optional<TomlTable> TomlTable::optional_table(const std::string& key) {
  const toml::value* value = find(key);
  if (value == nullptr) return std::nullopt;
  return TomlTable(path_, *value, "[" + key + "]");
}

TomlTable TomlTable::table(const std::string& key) {
  required(key);
  return *optional_table(key);
}

std::vector<TomlTable> TomlTable::tables(const std::string& key) {
  const toml::value& value = required(key);
  if (!value.is_array() || value.as_array().empty())
    fail(key, "'" + key + "' must be a list of tables; write [[" + key + "]] before each");
  std::vector<TomlTable> out;
  for (const toml::value& item : value.as_array())
    out.emplace_back(path_, item, "[[" + key + "]] number " + std::to_string(out.size() + 1));
  return out;
}

void TomlTable::finish() const {
  for (const auto& [name, value] : in_file_order(table_->as_table())) {
    if (std::find(known_.begin(), known_.end(), name) != known_.end()) continue;
    const std::string hint = did_you_mean(name, known_);
    fail(name, "unknown key '" + printable(name) + "' in " + name_ +
                   (hint.empty() ? "; it knows " + list(known_) : hint));
  }
}

}  // namespace afptraj
