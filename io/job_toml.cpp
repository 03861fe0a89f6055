#include "io/job_toml.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <sstream>
#include <variant>

#include "geometry/error.h"
#include "io/nearest_name.h"
#include "io/number_text.h"
#include "io/text_file.h"
#include "io/toml_file.h"

namespace afptraj {
namespace {

constexpr int greatest_face = 10000000;

// The kinds of value a key can hold; each sets and tells one member of Job.
struct NumberValue {
  double lo, hi;
  double unit;  // what one of the key's units is inside (degrees: pi / 180)
  double& (*member)(Job&);
};
struct IntegerValue {
  int lo, hi;
  int& (*member)(Job&);
};
struct TextValue {
  std::vector<std::string> allowed;  // any text when empty
  std::string& (*member)(Job&);
};
struct FacesValue {
  std::vector<int>& (*member)(Job&);
};

struct Key {
  const char* table;
  const char* name;
  const char* unit;
  const char* meaning;
  std::variant<NumberValue, IntegerValue, TextValue, FacesValue> value;

  std::string full_name() const { return std::string(table) + "." + name; }
};

constexpr double degree = pi / 180;

const std::vector<Key>& keys() {
  static const std::vector<Key> all{
      {"material", "tow_width", "mm", "width of one tow",
       NumberValue{0.1, 1000, 1, [](Job& j) -> double& { return j.plan.tow_width_mm; }}},
      {"material", "min_steering_radius", "mm", "limit: a course may not turn tighter on the surface",
       NumberValue{0.1, 1e7, 1, [](Job& j) -> double& { return j.plan.min_steering_radius_mm; }}},
      {"head", "tows", "", "tows side by side; the band is tows x tow_width wide",
       IntegerValue{1, 256, [](Job& j) -> int& { return j.plan.tows; }}},
      {"head", "min_cut_length", "mm", "shortest piece of a tow that the head can lay; 0: any",
       NumberValue{0, 1e5, 1, [](Job& j) -> double& { return j.plan.cut.min_cut_length_mm; }}},
      {"head", "short_tows", "", "what is done with shorter pieces: extended in that direction, or dropped",
       TextValue{short_tow_words(), [](Job& j) -> std::string& { return j.short_tows; }}},
      {"head", "min_gap", "mm", "shortest gap between two pieces of a tow; shorter ones are laid through",
       NumberValue{0, 1e5, 1, [](Job& j) -> double& { return j.plan.cut.min_gap_mm; }}},
      {"planning", "step", "mm", "greatest step of the reference path",
       NumberValue{0.01, 100, 1, [](Job& j) -> double& { return j.plan.step_mm; }}},
      {"planning", "chord_error", "mm", "greatest distance of a step's chord from its arc",
       NumberValue{1e-6, 10, 1, [](Job& j) -> double& { return j.plan.chord_error_mm; }}},
      {"planning", "range", "mm", "reach of a ply point in the direction field; 0: one band width",
       NumberValue{0, 1e6, 1, [](Job& j) -> double& { return j.plan.range_mm; }}},
      {"planning", "fairness", "", "weight of fairness against the stepped points in the fit; 0: none",
       NumberValue{0, 1e6, 1, [](Job& j) -> double& { return j.plan.fairness; }}},
      {"planning", "extension_step", "mm", "step of a path's extension past its ends",
       NumberValue{0.01, 1000, 1, [](Job& j) -> double& { return j.plan.extension_step_mm; }}},
      {"planning", "sample", "mm", "greatest distance of output samples; 0: a twelfth of the band width",
       NumberValue{0, 100, 1, [](Job& j) -> double& { return j.plan.sample_mm; }}},
      {"planning", "coverage_rule", "%", "a tow is cut when so much of its width has left the skin; 0: gaps, 100: overlap",
       NumberValue{0, 100, 0.01, [](Job& j) -> double& { return j.plan.cut.coverage_rule; }}},
      {"planning", "max_courses", "", "greatest number of courses on each side",
       IntegerValue{1, 100000, [](Job& j) -> int& { return j.plan.max_courses; }}},
      {"planning", "point_distance_limit", "mm", "a ply point farther from the skin is an error",
       NumberValue{1e-6, 1e5, 1, [](Job& j) -> double& { return j.plan.point_distance_limit_mm; }}},
      {"limits", "max_angle_deviation", "deg", "limit: deviation of a course from the asked direction",
       NumberValue{0.001, 90, degree, [](Job& j) -> double& { return j.plan.angle_limit_rad; }}},
      {"limits", "min_coverage", "", "limit: share of the skin within half a band of a centre line",
       NumberValue{0, 1, 1, [](Job& j) -> double& { return j.min_coverage; }}},
      {"limits", "max_spacing_error", "mm", "limit: distance of neighbouring courses less one band",
       NumberValue{1e-9, 1000, 1, [](Job& j) -> double& { return j.max_spacing_error_mm; }}},
      {"faces", "list", "", "faces to lay on, by number: \"3,5-9\" or [3, 5]",
       FacesValue{[](Job& j) -> std::vector<int>& { return j.faces.numbers; }}},
      {"faces", "name", "", "faces to lay on, by name",
       TextValue{{}, [](Job& j) -> std::string& { return j.faces.name; }}},
      {"faces", "tangent_from", "", "faces to begin from; smooth neighbours join",
       FacesValue{[](Job& j) -> std::vector<int>& { return j.faces.tangent_from; }}},
      {"faces", "tangent_angle", "deg", "an edge is smooth below this angle between its sides",
       NumberValue{0, 180, degree, [](Job& j) -> double& { return j.faces.tangent_angle_rad; }}},
      {"input", "unit", "", "length unit of the STEP file, whatever it declares",
       TextValue{{"mm", "cm", "m", "in", "ft"}, [](Job& j) -> std::string& { return j.unit; }}},
      {"input", "sew_tolerance", "mm",
       "loose edges nearer than this are joined; 0: none; left out: 1e-4 of the part",
       NumberValue{0, 10, 1, [](Job& j) -> double& { return j.sew_tolerance_mm; }}},
      {"output", "directory", "", "where the result goes",
       TextValue{{}, [](Job& j) -> std::string& { return j.output_directory; }}},
  };
  return all;
}

[[noreturn]] void wrong(const std::string& where, const std::string& message) {
  throw Error(ErrorCode::usage, where, message);
}

// Shortest text of a limit, which may be large or small.
std::string limit_text(double x) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out << x;
  return out.str();
}

std::string quoted_list(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

struct RangeText {
  std::string operator()(const NumberValue& v) const { return limit_text(v.lo) + " ... " + limit_text(v.hi); }
  std::string operator()(const IntegerValue& v) const {
    return std::to_string(v.lo) + " ... " + std::to_string(v.hi);
  }
  std::string operator()(const TextValue& v) const {
    return v.allowed.empty() ? "text" : quoted_list(v.allowed);
  }
  std::string operator()(const FacesValue&) const { return "face numbers"; }
};

std::string with_unit(const Key& key) {
  const std::string range = std::visit(RangeText{}, key.value);
  return key.unit[0] == '\0' ? range : range + " " + key.unit;
}

void set_number(Job& job, const Key& key, const NumberValue& value, double x, const std::string& where) {
  if (!(x >= value.lo && x <= value.hi)) {
    wrong(where,
          key.full_name() + " = " + limit_text(x) + " is out of range; it must lie in " + with_unit(key));
  }
  value.member(job) = x * value.unit;
}

void set_integer(Job& job, const Key& key, const IntegerValue& value, std::int64_t x,
                 const std::string& where) {
  if (x < value.lo || x > value.hi) {
    wrong(where,
          key.full_name() + " = " + std::to_string(x) + " is out of range; it must lie in " + with_unit(key));
  }
  value.member(job) = static_cast<int>(x);
}

void set_text(Job& job, const Key& key, const TextValue& value, const std::string& text,
              const std::string& where) {
  if (text.empty()) wrong(where, key.full_name() + " is empty; give a value or leave it out");
  if (!value.allowed.empty() &&
      std::find(value.allowed.begin(), value.allowed.end(), text) == value.allowed.end()) {
    wrong(where, key.full_name() + " = '" + printable(text) + "' is not known; it is one of " +
                     quoted_list(value.allowed));
  }
  value.member(job) = text;
}

// Sets a key from a TOML value.
struct FromToml {
  Job& job;
  const Key& key;
  const toml::value& given;
  std::string where;

  [[noreturn]] void wrong_type(const char* expected) const {
    wrong(where, key.full_name() + " must be " + expected + ", not " + type_name());
  }
  std::string type_name() const {
    std::ostringstream out;
    out << given.type();
    return out.str() == "string" ? "text" : "a value of type " + out.str();
  }
  double number() const {
    if (given.is_integer()) return static_cast<double>(given.as_integer());
    if (given.is_floating()) return given.as_floating();
    wrong_type("a number");
  }
  void operator()(const NumberValue& v) const { set_number(job, key, v, number(), where); }
  void operator()(const IntegerValue& v) const {
    if (!given.is_integer()) wrong_type("a whole number");
    set_integer(job, key, v, given.as_integer(), where);
  }
  void operator()(const TextValue& v) const {
    if (!given.is_string()) wrong_type("text in quotes");
    set_text(job, key, v, given.as_string().str, where);
  }
  void operator()(const FacesValue& v) const {
    if (given.is_string()) {
      v.member(job) = parse_face_list(given.as_string().str, where);
      return;
    }
    std::set<int> numbers;
    if (given.is_integer()) {
      numbers.insert(face_number(given));
    } else if (given.is_array()) {
      for (const toml::value& item : given.as_array()) numbers.insert(face_number(item));
    } else {
      wrong_type("face numbers like \"3,5-9\" or [3, 5]");
    }
    if (numbers.empty()) wrong(where, key.full_name() + " is empty; name a face or leave it out");
    v.member(job).assign(numbers.begin(), numbers.end());
  }
  int face_number(const toml::value& item) const {
    if (!item.is_integer()) wrong_type("face numbers like \"3,5-9\" or [3, 5]");
    const std::int64_t n = item.as_integer();
    if (n < 1 || n > greatest_face)
      wrong(where, key.full_name() + ": faces are numbered from 1; see 'afptraj inspect'");
    return static_cast<int>(n);
  }
};

// Sets a key from the text of a flag.
struct FromText {
  Job& job;
  const Key& key;
  const std::string& text;
  const std::string& where;

  double number() const {
    const auto x = parse_number(text);
    if (!x) wrong(where, "'" + printable(text) + "' is not a number; it must lie in " + with_unit(key));
    return *x;
  }
  void operator()(const NumberValue& v) const { set_number(job, key, v, number(), where); }
  void operator()(const IntegerValue& v) const {
    const double x = number();
    if (x != std::floor(x))
      wrong(where, "'" + printable(text) + "' is not a whole number; it must lie in " + with_unit(key));
    if (std::abs(x) > 1e9) set_number(job, key, {double(v.lo), double(v.hi), 1, nullptr}, x, where);
    set_integer(job, key, v, static_cast<std::int64_t>(x), where);
  }
  void operator()(const TextValue& v) const { set_text(job, key, v, text, where); }
  void operator()(const FacesValue& v) const { v.member(job) = parse_face_list(text, where); }
};

struct ValueText {
  Job& job;
  std::string operator()(const NumberValue& v) const {
    return v.member(job) < v.lo * v.unit ? "automatic" : number_text(v.member(job) / v.unit);
  }
  std::string operator()(const IntegerValue& v) const { return std::to_string(v.member(job)); }
  std::string operator()(const TextValue& v) const { return v.member(job); }
  std::string operator()(const FacesValue& v) const {
    std::string text;
    for (const int n : v.member(job)) text += (text.empty() ? "" : ",") + std::to_string(n);
    return text;
  }
};

std::vector<std::string> table_names() {
  std::vector<std::string> names;
  for (const Key& key : keys()) {
    if (std::find(names.begin(), names.end(), key.table) == names.end()) names.emplace_back(key.table);
  }
  return names;
}

std::vector<std::string> key_names(const std::string& table) {
  std::vector<std::string> names;
  for (const Key& key : keys()) {
    if (key.table == table) names.emplace_back(key.name);
  }
  return names;
}

const Key* find_key(const std::string& table, const std::string& name) {
  for (const Key& key : keys()) {
    if (key.table == table && key.name == name) return &key;
  }
  return nullptr;
}

// An unknown name inside a table: the nearest of that table, or the same name in another one.
std::string unknown_key(const std::string& table, const std::string& name) {
  std::string message = "unknown key '" + printable(name) + "' in [" + table + "]";
  for (const Key& key : keys()) {
    if (key.name == name) return message + "; it belongs into [" + key.table + "]";
  }
  const std::string hint = did_you_mean(name, key_names(table));
  return message + (hint.empty() ? "; [" + table + "] knows " + quoted_list(key_names(table)) : hint);
}

std::string unknown_table(const std::string& name, bool is_table) {
  if (!is_table) {
    for (const Key& key : keys()) {
      if (key.name == name)
        return "unknown key '" + name + "' outside of a table; it belongs into [" + key.table + "]";
    }
  }
  const std::string hint = did_you_mean(name, table_names());
  return std::string("unknown ") + (is_table ? "table [" : "key '") + printable(name) +
         (is_table ? "]" : "'") + (hint.empty() ? "; the tables are " + quoted_list(table_names()) : hint);
}

}  // namespace

PlanOptions plan_options(const Job& job) {
  PlanOptions out = job.plan;
  out.cut.short_tows = short_tows_of(job.short_tows);
  return out;
}

Job read_job(const std::string& path) {
  const toml::value root = parse_toml_file(path);
  Job job;
  for (const auto& [table, content] : in_file_order(root.as_table())) {
    const auto names = table_names();
    if (std::find(names.begin(), names.end(), table) == names.end()) {
      wrong(toml_key_place(path, table, content.location()), unknown_table(table, content.is_table()));
    }
    if (!content.is_table()) {
      wrong(toml_place(path, content.location()),
            "'" + table + "' must be a table; write [" + table + "] on a line of its own");
    }
    for (const auto& [name, value] : in_file_order(content.as_table())) {
      const Key* key = find_key(table, name);
      if (key == nullptr) wrong(toml_key_place(path, name, value.location()), unknown_key(table, name));
      std::visit(FromToml{job, *key, value, toml_place(path, value.location())}, key->value);
    }
  }
  check_job(job, path);
  return job;
}

void set_job_key(Job& job, const std::string& key, const std::string& text, const std::string& where) {
  const std::size_t dot = key.find('.');
  const Key* found = dot == std::string::npos ? nullptr : find_key(key.substr(0, dot), key.substr(dot + 1));
  if (found == nullptr)
    throw Error(ErrorCode::internal, where, "job key '" + key + "' does not exist; please report this");
  std::visit(FromText{job, *found, text, where}, found->value);
}

void check_job(const Job& job, const std::string& where) {
  if (job.plan.min_steering_radius_mm < job.plan.tow_width_mm) {
    wrong(where, "min_steering_radius " + limit_text(job.plan.min_steering_radius_mm) +
                     " mm is smaller than tow_width " + limit_text(job.plan.tow_width_mm) +
                     " mm; no tow can turn inside its own width");
  }
  const int choices = static_cast<int>(!job.faces.numbers.empty()) +
                      static_cast<int>(!job.faces.name.empty()) +
                      static_cast<int>(!job.faces.tangent_from.empty());
  if (choices > 1) {
    wrong(where,
          "faces are chosen in more than one way; keep one of list (--face), name (--face-name), "
          "tangent_from (--tangent-from)");
  }
}

std::vector<int> parse_face_list(const std::string& text, const std::string& where) {
  const auto number = [&](const std::string& part) {
    std::string digits = part;
    std::erase(digits, ' ');
    if (digits.empty() || digits.size() > 8 || digits.find_first_not_of("0123456789") != std::string::npos) {
      wrong(where, "'" + printable(text) + "' is not a list of faces; write it like 3,5-9");
    }
    const int n = std::stoi(digits);
    if (n < 1 || n > greatest_face) wrong(where, "faces are numbered from 1; see 'afptraj inspect'");
    return n;
  };
  std::set<int> numbers;
  std::istringstream parts(text + ",");
  std::string part;
  while (std::getline(parts, part, ',')) {
    const std::size_t dash = part.find('-');
    const int first = number(part.substr(0, dash));
    const int last = dash == std::string::npos ? first : number(part.substr(dash + 1));
    if (last < first)
      wrong(where, "'" + printable(part) + "' runs backward; write " + std::to_string(last) + "-" +
                       std::to_string(first));
    if (last - first > 1000000)
      wrong(where, "'" + printable(part) + "' names more than a million faces; name those to lay on");
    for (int n = first; n <= last; ++n) numbers.insert(n);
  }
  return {numbers.begin(), numbers.end()};
}

std::vector<JobKeyInfo> job_keys() {
  std::vector<JobKeyInfo> infos;
  for (const Key& key : keys()) {
    infos.push_back({key.full_name(), std::visit(RangeText{}, key.value), key.unit, key.meaning});
  }
  return infos;
}

std::vector<std::pair<std::string, std::string>> job_values(const Job& job) {
  Job copy = job;
  std::vector<std::pair<std::string, std::string>> values;
  for (const Key& key : keys()) values.emplace_back(key.full_name(), std::visit(ValueText{copy}, key.value));
  return values;
}

}  // namespace afptraj
