#include "io/json_reader.h"

#include <charconv>
#include <cstdint>
#include <limits>

namespace afptraj {
namespace {

constexpr int deepest = 200;  // nested arrays and objects

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool begins_character(char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }

void append_utf8(std::string& out, std::uint32_t code) {
  const auto byte = [&](std::uint32_t bits) { out += static_cast<char>(bits); };
  if (code < 0x80) {
    byte(code);
  } else if (code < 0x800) {
    byte(0xC0 | code >> 6), byte(0x80 | (code & 0x3F));
  } else if (code < 0x10000) {
    byte(0xE0 | code >> 12), byte(0x80 | (code >> 6 & 0x3F)), byte(0x80 | (code & 0x3F));
  } else {
    byte(0xF0 | code >> 18), byte(0x80 | (code >> 12 & 0x3F)), byte(0x80 | (code >> 6 & 0x3F)),
        byte(0x80 | (code & 0x3F));
  }
}

class Reader {
 public:
  explicit Reader(std::string_view text) : text_(text) {}

  JsonValue read() {
    skip_blanks();
    JsonValue value = read_value();
    skip_blanks();
    if (at_ < text_.size()) fail("Extra data", at_);
    return value;
  }

 private:
  [[noreturn]] void fail(const std::string& what, std::size_t at) {
    move_mark(at);
    throw JsonProblem(what, line_, column_, character_);
  }

  // Lines and columns are counted once, from the last place asked for: places only grow, but for a fault.
  void move_mark(std::size_t at) {
    if (at < mark_) mark_ = 0, line_ = 1, column_ = 1, character_ = 0;
    for (; mark_ < at && mark_ < text_.size(); ++mark_) {
      if (!begins_character(text_[mark_])) continue;
      ++character_;
      ++column_;
      if (text_[mark_] == '\n') ++line_, column_ = 1;
    }
  }

  char next() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  void skip_blanks() {
    while (at_ < text_.size() && std::string_view(" \t\n\r").find(text_[at_]) != std::string_view::npos)
      ++at_;
  }
  bool take(std::string_view word) {
    if (text_.substr(at_, word.size()) != word) return false;
    at_ += word.size();
    return true;
  }

  JsonValue read_value() {
    JsonValue value;
    move_mark(at_);
    value.line = line_;
    value.column = column_;
    using Kind = JsonValue::Kind;
    const std::size_t start = at_;
    if (next() == '"') {
      value.kind = Kind::string;
      value.text = read_string();
    } else if (next() == '{') {
      read_object(value);
    } else if (next() == '[') {
      read_array(value);
    } else if (take("null")) {
      value.kind = Kind::null;
    } else if (take("true") || take("false")) {
      value.kind = Kind::boolean;
      value.boolean = text_[start] == 't';
    } else if (take("NaN")) {
      value.kind = Kind::real;
      value.number = std::numeric_limits<double>::quiet_NaN();
    } else if (take("Infinity") || take("-Infinity")) {
      value.kind = Kind::real;
      value.number = std::numeric_limits<double>::infinity() * (text_[start] == '-' ? -1 : 1);
    } else {
      read_number(value);
    }
    return value;
  }

  void read_number(JsonValue& value) {
    const std::size_t start = at_;
    std::size_t end = at_;
    const auto digits = [&] {
      const std::size_t first = end;
      while (end < text_.size() && is_digit(text_[end])) ++end;
      return end > first;
    };
    const auto at = [&](std::size_t i) { return i < text_.size() ? text_[i] : '\0'; };
    if (at(end) == '-') ++end;
    if (!is_digit(at(end))) fail("Expecting value", start);
    if (at(end) == '0') {
      ++end;
    } else {
      digits();
    }
    value.kind = JsonValue::Kind::integer;
    if (at(end) == '.' && is_digit(at(end + 1))) {
      ++end;
      digits();
      value.kind = JsonValue::Kind::real;
    }
    if (at(end) == 'e' || at(end) == 'E') {
      const std::size_t sign = at(end + 1) == '+' || at(end + 1) == '-' ? 1 : 0;
      if (is_digit(at(end + 1 + sign))) {
        end += 1 + sign;
        digits();
        value.kind = JsonValue::Kind::real;
      }
    }
    value.text = text_.substr(start, end - start);
    value.number = number_of(value.text);
    at_ = end;
  }

  // from_chars leaves the value alone beyond the range of doubles, where it is infinite or 0.
  static double number_of(const std::string& text) {
    double number = 0;
    const auto result = std::from_chars(text.data(), text.data() + text.size(), number);
    if (result.ec != std::errc::result_out_of_range) return number;
    const bool small = text.find("e-") != std::string::npos || text.find("E-") != std::string::npos;
    return (small ? 0.0 : std::numeric_limits<double>::infinity()) * (text.front() == '-' ? -1 : 1);
  }

  std::string read_string() {
    const std::size_t start = at_++;
    std::string out;
    for (;;) {
      if (at_ >= text_.size()) fail("Unterminated string starting at", start);
      const char c = text_[at_];
      if (c == '"') break;
      if (static_cast<unsigned char>(c) < 0x20) fail("Invalid control character at", at_);
      if (c == '\\') {
        read_escape(out, start);
      } else {
        out += c;
        ++at_;
      }
    }
    ++at_;
    return out;
  }

  void read_escape(std::string& out, std::size_t start) {
    const std::size_t slash = at_++;
    if (at_ >= text_.size()) fail("Unterminated string starting at", start);
    constexpr std::string_view from = "\"\\/bfnrt", to = "\"\\/\b\f\n\r\t";
    const char c = text_[at_++];
    if (const std::size_t i = from.find(c); i != std::string_view::npos) {
      out += to[i];
      return;
    }
    if (c != 'u') fail("Invalid \\escape", slash);
    std::uint32_t code = read_four_digits(slash);
    const bool high = code >= 0xD800 && code < 0xDC00;
    if (high && text_.substr(at_, 2) == "\\u") {
      const std::size_t before = at_;
      at_ += 2;
      const std::uint32_t low = read_four_digits(before);
      if (low >= 0xDC00 && low < 0xE000) {
        code = 0x10000 + ((code - 0xD800) << 10) + (low - 0xDC00);
      } else {
        at_ = before;
      }
    }
    append_utf8(out, code >= 0xD800 && code < 0xE000 ? 0xFFFD : code);
  }

  std::uint32_t read_four_digits(std::size_t slash) {
    std::uint32_t code = 0;
    const std::string_view digits = text_.substr(at_, 4);
    const auto result = std::from_chars(digits.data(), digits.data() + digits.size(), code, 16);
    if (digits.size() < 4 || result.ptr != digits.data() + 4) fail("Invalid \\uXXXX escape", slash + 1);
    at_ += 4;
    return code;
  }

  void enter() {
    if (++depth_ > deepest) fail("Nested too deep", at_);
    ++at_;
    skip_blanks();
  }
  void leave() {
    --depth_;
    ++at_;
  }

  void read_array(JsonValue& value) {
    value.kind = JsonValue::Kind::array;
    enter();
    if (next() == ']') return leave();
    for (;;) {
      value.items.push_back(read_value());
      skip_blanks();
      if (next() == ']') return leave();
      if (next() != ',') fail("Expecting ',' delimiter", at_);
      ++at_;
      skip_blanks();
    }
  }

  void read_object(JsonValue& value) {
    value.kind = JsonValue::Kind::object;
    enter();
    if (next() == '}') return leave();
    for (;;) {
      if (next() != '"') fail("Expecting property name enclosed in double quotes", at_);
      move_mark(at_);
      JsonMember member;
      member.line = line_;
      member.column = column_;
      member.name = read_string();
      skip_blanks();
      if (next() != ':') fail("Expecting ':' delimiter", at_);
      ++at_;
      skip_blanks();
      member.value = read_value();
      value.members.push_back(std::move(member));
      skip_blanks();
      if (next() == '}') return leave();
      if (next() != ',') fail("Expecting ',' delimiter", at_);
      ++at_;
      skip_blanks();
    }
  }

  std::string_view text_;
  std::size_t at_ = 0, mark_ = 0, character_ = 0;
  int line_ = 1, column_ = 1, depth_ = 0;
};

}  // namespace

const JsonValue* JsonValue::find(std::string_view name) const {
  for (auto member = members.rbegin(); member != members.rend(); ++member) {
    if (member->name == name) return &member->value;
  }
  return nullptr;
}

JsonValue read_json(std::string_view text) { return Reader(text).read(); }

}  // namespace afptraj
