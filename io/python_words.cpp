#include "io/python_words.h"

#include "winding/number_words.h"

namespace afptraj {
namespace {

std::string quoted(const std::string& text) {
  const bool apostrophe = text.find('\'') != std::string::npos, quote = text.find('"') != std::string::npos;
  const char mark = apostrophe && !quote ? '"' : '\'';
  constexpr const char* digits = "0123456789abcdef";
  std::string out(1, mark);
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == mark || c == '\\') {
      out += '\\';
      out += c;
    } else if (c == '\n') {
      out += "\\n";
    } else if (c == '\r') {
      out += "\\r";
    } else if (c == '\t') {
      out += "\\t";
    } else if (byte < 0x20 || byte == 0x7f) {
      out += "\\x";
      out += digits[byte >> 4];
      out += digits[byte & 15];
    } else {
      out += c;
    }
  }
  return out + mark;
}

// Members as a dictionary holds them: a repeated key keeps its first place and its last value.
std::string dictionary(const JsonValue& value) {
  std::string out;
  for (std::size_t i = 0; i < value.members.size(); ++i) {
    const std::string& name = value.members[i].name;
    bool repeated = false;
    for (std::size_t j = 0; j < i; ++j) repeated = repeated || value.members[j].name == name;
    if (repeated) continue;
    out += (out.empty() ? "" : ", ") + quoted(name) + ": " + python_text(*value.find(name));
  }
  return "{" + out + "}";
}

}  // namespace

std::string python_text(const JsonValue& value) {
  switch (value.kind) {
    case JsonValue::Kind::null:
      return "None";
    case JsonValue::Kind::boolean:
      return value.boolean ? "True" : "False";
    case JsonValue::Kind::integer:
      return value.text == "-0" ? "0" : value.text;
    case JsonValue::Kind::real:
      return shortest_text(value.number);
    case JsonValue::Kind::string:
      return quoted(value.text);
    case JsonValue::Kind::object:
      return dictionary(value);
    case JsonValue::Kind::array:
      break;
  }
  std::string out;
  for (const JsonValue& item : value.items) out += (out.empty() ? "" : ", ") + python_text(item);
  return "[" + out + "]";
}

const char* python_type(const JsonValue& value) {
  constexpr const char* names[] = {"NoneType", "bool", "int", "float", "str", "list", "dict"};
  return names[static_cast<int>(value.kind)];
}

std::string python_excerpt(const std::string& text) {
  constexpr std::size_t longest = 50, head = 25, tail = 24;
  if (text.size() <= longest) return text;
  const auto inside = [&](std::size_t i) { return (static_cast<unsigned char>(text[i]) & 0xC0U) == 0x80U; };
  std::size_t first = head, last = text.size() - tail;
  while (inside(first)) --first;
  while (last < text.size() && inside(last)) ++last;
  return text.substr(0, first) + "..." + text.substr(last);
}

}  // namespace afptraj
