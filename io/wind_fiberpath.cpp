// The lax reading of `.wind` files: what a validator that coerces its input accepts, and how it words what
// it does not. Sources: FiberPath's messages as measured; the conversion table of pydantic 2.10.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <limits>

#include "geometry/error.h"
#include "io/json_reader.h"
#include "io/python_words.h"
#include "io/text_file.h"
#include "io/wind_schema.h"

namespace afptraj {
namespace {

using Kind = JsonValue::Kind;

// A code and a text of the validator, or a value.
struct Complaint {
  const char* code;
  std::string text;
};
constexpr const char* finite_code = "finite_number";

Complaint not_finite() { return {finite_code, "Input should be a finite number"}; }
Complaint not_positive() { return {"greater_than", "Input should be greater than 0"}; }

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blanks = " \t\n\r\f\v";
  const std::size_t first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

// Digits may be grouped by single underscores: nothing where they are not between digits.
std::optional<std::string> without_underscores(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '_') {
      out += text[i];
      continue;
    }
    const auto digit = [&](std::size_t k) { return k < text.size() && text[k] >= '0' && text[k] <= '9'; };
    if (i == 0 || !digit(i - 1) || !digit(i + 1)) return std::nullopt;
  }
  return out;
}

std::optional<double> number_in(const std::string& raw) {
  const auto plain = without_underscores(trimmed(raw));
  if (!plain) return std::nullopt;
  std::string_view text = *plain;
  const bool minus = !text.empty() && text.front() == '-';
  if (!text.empty() && (minus || text.front() == '+')) text.remove_prefix(1);
  if (text.empty() || text.front() == '-' || text.front() == '+') return std::nullopt;
  double x = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), x);
  if (end != text.data() + text.size() || problem == std::errc::invalid_argument) return std::nullopt;
  if (problem == std::errc::result_out_of_range)
    x = text.find("e-") == std::string_view::npos && text.find("E-") == std::string_view::npos
            ? std::numeric_limits<double>::infinity()
            : 0;
  return minus ? -x : x;
}

std::optional<std::int64_t> integer_in(const std::string& raw) {
  const auto plain = without_underscores(trimmed(raw));
  if (!plain) return std::nullopt;
  std::string_view text = *plain;
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  if (const std::size_t point = text.find('.');
      point != std::string_view::npos && point > 0 &&
      text.find_first_not_of('0', point + 1) == std::string_view::npos && point + 1 < text.size()) {
    text = text.substr(0, point);
  }
  std::int64_t x = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), x);
  if (end != text.data() + text.size() || text.empty() || problem == std::errc::invalid_argument)
    return std::nullopt;
  if (problem == std::errc::result_out_of_range)
    return text.front() == '-' ? std::numeric_limits<std::int64_t>::min()
                               : std::numeric_limits<std::int64_t>::max();
  return x;
}

std::optional<Complaint> read_number(const JsonValue& value, double& out) {
  switch (value.kind) {
    case Kind::integer:
    case Kind::real:
      out = value.number;
      break;
    case Kind::boolean:
      out = value.boolean ? 1 : 0;
      break;
    case Kind::string: {
      const auto x = number_in(value.text);
      if (!x)
        return Complaint{"float_parsing",
                         "Input should be a valid number, unable to parse string as a number"};
      out = *x;
      break;
    }
    default:
      return Complaint{"float_type", "Input should be a valid number"};
  }
  if (!std::isfinite(out)) return not_finite();
  return std::nullopt;
}

std::optional<Complaint> read_positive(const JsonValue& value, double& out) {
  if (auto complaint = read_number(value, out)) return complaint;
  if (!(out > 0)) return not_positive();
  return std::nullopt;
}

std::optional<Complaint> read_count(const JsonValue& value, std::int64_t& out) {
  constexpr double limit = 9223372036854775808.0;
  switch (value.kind) {
    case Kind::boolean:
      out = value.boolean ? 1 : 0;
      break;
    case Kind::integer:
      out = *integer_in(value.text);
      break;
    case Kind::real:
      if (!std::isfinite(value.number)) return not_finite();
      if (value.number != std::floor(value.number))
        return Complaint{"int_from_float",
                         "Input should be a valid integer, got a number with a fractional part"};
      if (std::abs(value.number) >= limit)
        return Complaint{"int_parsing_size",
                         "Unable to parse input string as an integer, exceeded maximum size"};
      out = static_cast<std::int64_t>(value.number);
      break;
    case Kind::string: {
      const auto x = integer_in(value.text);
      if (!x)
        return Complaint{"int_parsing",
                         "Input should be a valid integer, unable to parse string as an integer"};
      out = *x;
      break;
    }
    default:
      return Complaint{"int_type", "Input should be a valid integer"};
  }
  if (out <= 0) return not_positive();
  return std::nullopt;
}

std::optional<Complaint> read_flag(const JsonValue& value, bool& out) {
  const Complaint unclear{"bool_parsing", "Input should be a valid boolean, unable to interpret input"};
  switch (value.kind) {
    case Kind::boolean:
      out = value.boolean;
      return std::nullopt;
    case Kind::string: {
      std::string word = value.text;
      for (char& c : word) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
      for (const char* no : {"0", "off", "f", "false", "n", "no"}) {
        if (word == no) return out = false, std::nullopt;
      }
      for (const char* yes : {"1", "on", "t", "true", "y", "yes"}) {
        if (word == yes) return out = true, std::nullopt;
      }
      return unclear;
    }
    case Kind::integer:
    case Kind::real:
      if (value.number != 0 && value.number != 1)
        return value.number == std::floor(value.number)
                   ? unclear
                   : Complaint{"bool_type", "Input should be a valid boolean"};
      out = value.number == 1;
      return std::nullopt;
    default:
      return Complaint{"bool_type", "Input should be a valid boolean"};
  }
}

// Collects what is wrong, in the order of the schema, and words it.
class Validation {
 public:
  void complain(const std::string& location, const Complaint& complaint, const JsonValue& input) {
    ++count_;
    lines_ += "\n" + (location.empty() ? "" : location + "\n") + "  " + complaint.text +
              " [type=" + complaint.code + ", input_value=" + python_excerpt(python_text(input)) +
              ", input_type=" + python_type(input) +
              "]\n    For further information visit https://errors.pydantic.dev/2.10/v/" + complaint.code;
  }
  void finish(const std::string& path) const {
    if (count_ == 0) return;
    throw Error(ErrorCode::bad_input, path,
                "Wind definition at " + path + " failed validation: " + std::to_string(count_) +
                    " validation error" + (count_ == 1 ? "" : "s") + " for WindDefinition" + lines_);
  }

 private:
  int count_ = 0;
  std::string lines_;
};

// One object: each field under its camelCase or its snake_case name.
class ModelReader {
 public:
  ModelReader(Validation& validation, std::string location, const JsonValue& value)
      : validation_(validation), location_(std::move(location)), value_(value) {}

  std::string at(const std::string& name) const { return location_.empty() ? name : location_ + "." + name; }

  // The value and the name it was found under.
  std::pair<const JsonValue*, std::string> lookup(const std::string& camel, const std::string& snake) const {
    if (const JsonValue* found = value_.find(camel)) return {found, camel};
    return {value_.find(snake), snake};
  }

  template <typename Read>
  void optional(const std::string& camel, const std::string& snake, const Read& read) {
    const auto [found, name] = lookup(camel, snake);
    if (found == nullptr) return;
    if (const std::optional<Complaint> complaint = read(*found))
      validation_.complain(at(name), *complaint, *found);
  }
  template <typename Read>
  void required(const std::string& camel, const std::string& snake, const Read& read) {
    if (lookup(camel, snake).first == nullptr) {
      validation_.complain(at(camel), {"missing", "Field required"}, value_);
    } else {
      optional(camel, snake, read);
    }
  }

  void positive(const std::string& camel, const std::string& snake, double& out) {
    required(camel, snake, [&](const JsonValue& value) { return read_positive(value, out); });
  }
  void count(const std::string& camel, const std::string& snake, std::int64_t& out) {
    required(camel, snake, [&](const JsonValue& value) { return read_count(value, out); });
  }
  void flag(const std::string& camel, const std::string& snake, bool& out) {
    optional(camel, snake, [&](const JsonValue& value) { return read_flag(value, out); });
  }
  // A nested object; `model` names its class in the message.
  void object(const std::string& camel, const std::string& snake, const std::string& model,
              const std::function<void(ModelReader&)>& read) {
    required(camel, snake, [&](const JsonValue& value) -> std::optional<Complaint> {
      if (value.kind != Kind::object)
        return Complaint{"model_type", "Input should be a valid dictionary or instance of " + model};
      ModelReader inner(validation_, at(lookup(camel, snake).second), value);
      read(inner);
      return std::nullopt;
    });
  }

 private:
  Validation& validation_;
  std::string location_;
  const JsonValue& value_;
};

void read_mandrel(ModelReader& reader, WindMandrel& mandrel) {
  reader.positive("diameter", "diameter", mandrel.diameter_mm);
  reader.positive("windLength", "wind_length", mandrel.length_mm);
  reader.optional("endDiameter", "end_diameter", [&](const JsonValue& value) -> std::optional<Complaint> {
    if (value.kind == Kind::null) return std::nullopt;
    return read_positive(value, mandrel.end_diameter_mm.emplace());
  });
}

void read_tow(ModelReader& reader, WindTow& tow) {
  reader.positive("width", "width", tow.width_mm);
  reader.positive("thickness", "thickness", tow.thickness_mm);
}

HelicalLayer read_helical(ModelReader& reader) {
  HelicalLayer layer;
  reader.positive("windAngle", "wind_angle", layer.angle_deg);
  reader.count("patternNumber", "pattern_number", layer.pattern);
  reader.count("skipIndex", "skip_index", layer.skip);
  reader.positive("lockDegrees", "lock_degrees", layer.lock_deg);
  reader.positive("leadInMM", "lead_in_mm", layer.lead_in_mm);
  reader.positive("leadOutDegrees", "lead_out_degrees", layer.lead_out_deg);
  reader.flag("skipInitialNearLock", "skip_initial_near_lock", layer.skip_initial_near_lock);
  return layer;
}

void read_layer(Validation& validation, const JsonValue& value, std::size_t index,
                std::vector<WindLayer>& layers) {
  const std::string location = "layers." + std::to_string(index);
  if (value.kind != Kind::object) {
    validation.complain(
        location,
        {"model_attributes_type", "Input should be a valid dictionary or object to extract fields from"},
        value);
    return;
  }
  const std::string discriminator = "'wind_type' | 'windType'";
  const JsonValue* tag = value.find("wind_type");
  if (tag == nullptr) tag = value.find("windType");
  if (tag == nullptr) {
    validation.complain(location,
                        {"union_tag_not_found", "Unable to extract tag using discriminator " + discriminator},
                        value);
    return;
  }
  const std::string name = tag->kind == Kind::string ? tag->text : python_text(*tag);
  ModelReader reader(validation, location + "." + name, value);
  if (tag->kind == Kind::string && name == "hoop") {
    HoopLayer hoop;
    reader.flag("terminal", "terminal", hoop.terminal);
    layers.emplace_back(hoop);
  } else if (tag->kind == Kind::string && name == "skip") {
    SkipLayer skip;
    reader.required("mandrelRotation", "mandrel_rotation",
                    [&](const JsonValue& turn) { return read_number(turn, skip.rotation_deg); });
    layers.emplace_back(skip);
  } else if (tag->kind == Kind::string && name == "helical") {
    // A key of ours that FiberPath would pass over, and so wind another angle than the file says.
    const JsonValue* from = value.find("angleFrom");
    if (from != nullptr && (from->kind != Kind::string || from->text != "axis")) {
      validation.complain(
          location + ".helical.angleFrom",
          {"value_error",
           "FiberPath measures windAngle from the axis; write it so, or plan without --fiberpath"},
          *from);
    }
    layers.emplace_back(read_helical(reader));
  } else {
    validation.complain(location,
                        {"union_tag_invalid", "Input tag '" + name + "' found using " + discriminator +
                                                  " does not match any of the expected tags: 'hoop', "
                                                  "'helical', 'skip'"},
                        value);
  }
}

std::optional<Complaint> read_version(const JsonValue& value, std::string& out) {
  if (value.kind != Kind::string) return Complaint{"string_type", "Input should be a valid string"};
  out = trimmed(value.text);
  if (!is_known_schema(out))
    return Complaint{"string_pattern_mismatch", "String should match pattern '^1\\.\\d+$'"};
  return std::nullopt;
}

JsonValue parsed(const std::string& path, const std::string& text) {
  const auto refuse = [&](const std::string& what, int line, int column, std::size_t character) {
    return Error(ErrorCode::bad_input, path,
                 "Invalid JSON in " + path + ": " + what + ": line " + std::to_string(line) + " column " +
                     std::to_string(column) + " (char " + std::to_string(character) + ")");
  };
  if (text.rfind("\xef\xbb\xbf", 0) == 0)
    throw refuse("Unexpected UTF-8 BOM (decode using utf-8-sig)", 1, 1, 0);
  try {
    return read_json(text);
  } catch (const JsonProblem& problem) {
    throw refuse(problem.what(), problem.line, problem.column, problem.character);
  }
}

}  // namespace

WindDefinition read_fiberpath_wind(const std::string& path, const std::string& text) {
  const JsonValue root = parsed(path, text);
  WindDefinition definition;
  Validation validation;
  if (root.kind != Kind::object) {
    validation.complain(
        "", {"model_type", "Input should be a valid dictionary or instance of WindDefinition"}, root);
    validation.finish(path);
  }
  ModelReader reader(validation, "", root);
  reader.optional("schemaVersion", "schema_version",
                  [&](const JsonValue& value) { return read_version(value, definition.schema_version); });
  reader.object("mandrelParameters", "mandrel_parameters", "MandrelParameters",
                [&](ModelReader& inner) { read_mandrel(inner, definition.mandrel); });
  reader.object("towParameters", "tow_parameters", "TowParameters",
                [&](ModelReader& inner) { read_tow(inner, definition.tow); });
  reader.positive("defaultFeedRate", "default_feed_rate", definition.feed_mm_per_min);
  reader.required("layers", "layers", [&](const JsonValue& value) -> std::optional<Complaint> {
    if (value.kind != Kind::array) return Complaint{"list_type", "Input should be a valid list"};
    for (std::size_t i = 0; i < value.items.size(); ++i)
      read_layer(validation, value.items[i], i, definition.layers);
    return std::nullopt;
  });
  validation.finish(path);
  return definition;
}

}  // namespace afptraj
