#include "winding/fixed_text.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstring>

#include "geometry/error.h"

namespace afptraj {
namespace {

char* write_beyond_limit(char* at, double x) {
  if (!std::isfinite(x)) {
    throw Error(ErrorCode::no_path, "program",
                "a position of an axis is beyond all numbers; use a smaller angle, length or lock");
  }
  char* end = std::to_chars(at, at + fixed_room, x, std::chars_format::fixed, 6).ptr;
  while (end[-1] == '0') --end;
  return end[-1] == '.' ? end - 1 : end;
}

constexpr std::array<char, 200> two_digits = [] {
  std::array<char, 200> table{};
  for (std::size_t i = 0; i < 100; ++i) {
    table[2 * i] = static_cast<char>('0' + i / 10);
    table[2 * i + 1] = static_cast<char>('0' + i % 10);
  }
  return table;
}();

char* write_whole(char* at, std::uint64_t x) {
  char buffer[20];
  char* first = buffer + sizeof buffer;
  while (x >= 100) {
    first -= 2;
    std::memcpy(first, &two_digits[2 * (x % 100)], 2);
    x /= 100;
  }
  first -= 2;
  std::memcpy(first, &two_digits[2 * x], 2);
  if (x < 10) ++first;
  const auto length = static_cast<std::size_t>(buffer + sizeof buffer - first);
  std::memcpy(at, first, length);
  return at + length;
}

char* write_fraction(char* at, std::uint64_t millionths) {
  *at = '.';
  std::memcpy(at + 1, &two_digits[2 * (millionths / 10000)], 2);
  std::memcpy(at + 3, &two_digits[2 * (millionths / 100 % 100)], 2);
  std::memcpy(at + 5, &two_digits[2 * (millionths % 100)], 2);
  at += 7;
  while (at[-1] == '0') --at;
  return at;
}

}  // namespace

std::int64_t millionths(double x) {
  const double scaled = x * 1e6;
  const double lost = std::fma(x, 1e6, -scaled);  // scaled + lost is exact
  const double below = std::floor(scaled);
  const double over_half = ((scaled - below) - 0.5) + lost;  // exact in its sign
  const auto whole = static_cast<std::int64_t>(below);
  if (over_half > 0) return whole + 1;
  if (over_half < 0) return whole;
  return whole + (whole & 1);
}

char* write_fixed(char* at, double x, bool minus_zero) {
  if (!(std::abs(x) < fixed_limit)) return write_beyond_limit(at, x);
  const std::int64_t value = millionths(x);
  if (value < 0 || (minus_zero && value == 0 && std::signbit(x))) *at++ = '-';
  const auto size = static_cast<std::uint64_t>(value < 0 ? -value : value);
  at = write_whole(at, size / 1000000);
  const std::uint64_t fraction = size % 1000000;
  return fraction == 0 ? at : write_fraction(at, fraction);
}

std::string fixed_text(double x, bool minus_zero) {
  char buffer[fixed_room];
  return {buffer, write_fixed(buffer, x, minus_zero)};
}

}  // namespace afptraj
