#include <algorithm>
#include <cmath>
#include <set>

#include "geometry/error.h"
#include "io/json_reader.h"
#include "io/nearest_name.h"
#include "io/text_file.h"
#include "io/wind_schema.h"
#include "winding/number_words.h"

namespace afptraj {
namespace {

using Kind = JsonValue::Kind;

const char* described(const JsonValue& value) {
  constexpr const char* names[] = {"null",   "true or false", "a number", "a number",
                                   "a text", "a list",        "an object"};
  return names[static_cast<int>(value.kind)];
}

// One object of the file: hands out the values of its keys and knows which were asked for.
class ObjectReader {
 public:
  ObjectReader(const std::string& path, const JsonValue& value, std::string what)
      : path_(path), value_(value), what_(std::move(what)) {
    if (value.kind != Kind::object) {
      fail(value, what_ + " is " + described(value) + "; it must be an object { ... }");
    }
    std::set<std::string> seen;
    for (const JsonMember& member : value.members) {
      if (!seen.insert(member.name).second) {
        fail(member, "'" + printable(member.name) + "' stands twice in " + what_ + "; keep one");
      }
    }
  }

  const JsonValue* optional(const std::string& key) {
    known_.push_back(key);
    return value_.find(key);
  }
  const JsonValue& required(const std::string& key) {
    const JsonValue* found = optional(key);
    // A misspelt key is the likelier fault than a forgotten one.
    if (found == nullptr) missing_.push_back(key);
    static const JsonValue none;
    return found == nullptr ? none : *found;
  }

  double number(const std::string& key, bool positive) {
    const JsonValue& value = required(key);
    return missing_.empty() ? number_of(value, key, positive) : 1;
  }
  double positive(const std::string& key) { return number(key, true); }
  std::optional<double> optional_positive(const std::string& key) {
    const JsonValue* value = optional(key);
    if (value == nullptr || value->kind == Kind::null) return std::nullopt;
    return number_of(*value, key, true);
  }

  std::int64_t count(const std::string& key) {
    const double x = positive(key);
    if (x == std::floor(x) && x < 9e15) return static_cast<std::int64_t>(x);
    fail(required(key), "'" + key + "' is " + shortest_text(x) + "; it must be a whole number");
  }

  bool flag(const std::string& key) {
    const JsonValue* value = optional(key);
    if (value == nullptr) return false;
    if (value->kind != Kind::boolean)
      fail(*value, "'" + key + "' is " + described(*value) + "; write true or false");
    return value->boolean;
  }

  // One of two words; the first where the key is not given.
  std::string choice(const std::string& key, const std::string& usual, const std::string& other) {
    const JsonValue* value = optional(key);
    if (value == nullptr) return usual;
    if (value->kind != Kind::string || (value->text != usual && value->text != other))
      fail(*value, "'" + key + "' must be \"" + usual + "\" or \"" + other + "\"");
    return value->text;
  }

  std::string text(const std::string& key) {
    const JsonValue& value = required(key);
    if (!missing_.empty()) return {};
    if (value.kind != Kind::string)
      fail(value, "'" + key + "' is " + described(value) + "; write a text in quotes");
    return value.text;
  }

  // To be called when all keys have been asked for.
  void finish() const {
    for (const JsonMember& member : value_.members) {
      if (std::find(known_.begin(), known_.end(), member.name) != known_.end()) continue;
      const std::string hint = did_you_mean(member.name, known_);
      fail(member, "unknown key '" + printable(member.name) + "' in " + what_ +
                       (hint.empty() ? "; known are " + list(known_) : hint));
    }
    if (!missing_.empty()) fail(value_, what_ + " lacks '" + missing_.front() + "'; add it");
  }

  template <typename Place>
  [[noreturn]] void fail(const Place& place, const std::string& message) const {
    throw Error(ErrorCode::bad_input, file_line(path_, place.line) + ":" + std::to_string(place.column),
                message);
  }

 private:
  double number_of(const JsonValue& value, const std::string& key, bool positive) const {
    if (value.kind != Kind::integer && value.kind != Kind::real)
      fail(value, "'" + key + "' is " + described(value) + "; write a number without quotes");
    if (!std::isfinite(value.number)) fail(value, "'" + key + "' is not finite; write a number");
    if (positive && !(value.number > 0))
      fail(value, "'" + key + "' is " + shortest_text(value.number) + "; it must be greater than 0");
    return value.number;
  }

  static std::string list(const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
    return text;
  }

  const std::string& path_;
  const JsonValue& value_;
  std::string what_;
  std::vector<std::string> known_, missing_;
};

WindMandrel read_mandrel(const std::string& path, const JsonValue& value) {
  ObjectReader reader(path, value, "mandrelParameters");
  WindMandrel mandrel;
  mandrel.diameter_mm = reader.positive("diameter");
  mandrel.length_mm = reader.positive("windLength");
  mandrel.end_diameter_mm = reader.optional_positive("endDiameter");
  reader.finish();
  return mandrel;
}

WindTow read_tow(const std::string& path, const JsonValue& value) {
  ObjectReader reader(path, value, "towParameters");
  WindTow tow;
  tow.width_mm = reader.positive("width");
  tow.thickness_mm = reader.positive("thickness");
  reader.finish();
  return tow;
}

HelicalLayer read_helical(ObjectReader& reader) {
  HelicalLayer layer;
  layer.angle_deg = reader.positive("windAngle");
  if (reader.choice("angleFrom", "axis", "hoop") == "hoop") layer.angle_deg = 90 - layer.angle_deg;
  layer.pattern = reader.count("patternNumber");
  layer.skip = reader.count("skipIndex");
  layer.lock_deg = reader.positive("lockDegrees");
  layer.lead_in_mm = reader.positive("leadInMM");
  layer.lead_out_deg = reader.positive("leadOutDegrees");
  layer.skip_initial_near_lock = reader.flag("skipInitialNearLock");
  return layer;
}

WindLayer read_layer(const std::string& path, const JsonValue& value, std::size_t number) {
  ObjectReader reader(path, value, "layer " + std::to_string(number));
  const JsonValue* type = value.find("windType");
  if (type == nullptr) {
    static const std::vector<std::string> only{"windType"};
    for (const JsonMember& member : value.members) {
      const std::string hint = did_you_mean(member.name, only);
      if (!hint.empty()) reader.fail(member, "unknown key '" + printable(member.name) + "'" + hint);
    }
    reader.fail(value, "layer " + std::to_string(number) + " lacks 'windType'; use hoop, helical or skip");
  }
  const std::string name = reader.text("windType");
  WindLayer layer;
  if (name == "hoop") {
    layer = HoopLayer{reader.flag("terminal")};
  } else if (name == "skip") {
    layer = SkipLayer{reader.number("mandrelRotation", false)};
  } else if (name == "helical") {
    layer = read_helical(reader);
  } else {
    const std::string hint = did_you_mean(name, {"hoop", "helical", "skip"});
    reader.fail(*type, "unknown windType '" + printable(name) + "'" +
                           (hint.empty() ? "; use hoop, helical or skip" : hint));
  }
  reader.finish();
  return layer;
}

JsonValue parsed(const std::string& path, const std::string& text) {
  try {
    return read_json(text);
  } catch (const JsonProblem& problem) {
    throw Error(ErrorCode::bad_input, file_line(path, problem.line) + ":" + std::to_string(problem.column),
                std::string("is not JSON: ") + problem.what() + "; correct the file there");
  }
}

}  // namespace

WindDefinition read_native_wind(const std::string& path, const std::string& text) {
  const JsonValue root = parsed(path, text);
  ObjectReader reader(path, root, "the file");
  WindDefinition definition;
  if (const JsonValue* version = reader.optional("schemaVersion"); version != nullptr) {
    definition.schema_version = reader.text("schemaVersion");
    if (!is_known_schema(definition.schema_version))
      reader.fail(*version,
                  "schemaVersion '" + printable(definition.schema_version) + "' is unknown; use \"1.1\"");
  }
  const JsonValue &mandrel = reader.required("mandrelParameters"), &tow = reader.required("towParameters"),
                  &layers = reader.required("layers");
  definition.feed_mm_per_min = reader.positive("defaultFeedRate");
  reader.finish();
  definition.mandrel = read_mandrel(path, mandrel);
  definition.tow = read_tow(path, tow);
  if (layers.kind != Kind::array)
    reader.fail(layers, std::string("'layers' is ") + described(layers) + "; write a list [ ... ]");
  for (std::size_t i = 0; i < layers.items.size(); ++i)
    definition.layers.push_back(read_layer(path, layers.items[i], i + 1));
  return definition;
}

bool is_known_schema(std::string_view version) {
  if (version.size() < 3 || version.substr(0, 2) != "1.") return false;
  return version.find_first_not_of("0123456789", 2) == std::string_view::npos;
}

}  // namespace afptraj
