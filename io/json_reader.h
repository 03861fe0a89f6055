#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace afptraj {

struct JsonMember;

/// A JSON value with its place in the file. Unlike a general reader this one keeps what a strict schema
/// must see: repeated keys, the difference of 1 and 1.0, and the literals NaN and Infinity.
struct JsonValue {
  enum class Kind { null, boolean, integer, real, string, array, object };
  Kind kind = Kind::null;
  bool boolean = false;
  double number = 0;                ///< integer and real
  std::string text;                 ///< string: its characters; integer: its digits
  std::vector<JsonValue> items;     ///< array
  std::vector<JsonMember> members;  ///< object, in the order of the file
  int line = 1, column = 1;         ///< where it begins, counted from 1, in characters

  /// The last member of this name, as JSON readers that forget the earlier ones see it; or none.
  const JsonValue* find(std::string_view name) const;
};

struct JsonMember {
  std::string name;
  int line = 1, column = 1;
  JsonValue value;
};

/// What is not JSON, and where.
class JsonProblem : public std::runtime_error {
 public:
  JsonProblem(const std::string& what, int line, int column, std::size_t character)
      : std::runtime_error(what), line(line), column(column), character(character) {}
  int line, column;       ///< from 1
  std::size_t character;  ///< from 0
};

/// Reads one JSON text (UTF-8), with NaN, Infinity and -Infinity as numbers. Throws JsonProblem, in the
/// words of Python's reader, which users of `.wind` files know.
JsonValue read_json(std::string_view text);

}  // namespace afptraj
