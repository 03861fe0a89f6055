#include "io/number_text.h"

#include <charconv>
#include <cmath>
#include <cstdint>

#include "geometry/error.h"

namespace afptraj {
namespace {

constexpr double integer_limit = 4e15;  // below it a double holds integers with room to round

/// Exact, as std::pow(10, n) is up to 22, and much faster.
double power_of_ten(int n) {
  static constexpr double exact[] = {1, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};
  return n >= 0 && n < 16 ? exact[n] : std::pow(10.0, n);
}

void append_round_trip(std::string& text, double x) {
  char buffer[40];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, x).ptr;
  text.append(buffer, end);
}

}  // namespace

void append_number(std::string& text, double x, int decimals) {
  if (!std::isfinite(x)) {
    throw Error(ErrorCode::internal, "output", "a number to be written is not finite; please report this");
  }
  const double scaled = std::abs(x) * power_of_ten(decimals);
  if (scaled >= integer_limit) {
    append_round_trip(text, x);
    return;
  }
  // Drop digits from the right while the rest stays within one unit of the last decimal.
  std::int64_t digits = std::llround(scaled);
  int places = decimals;
  std::int64_t unit = 1;
  while (places > 0) {
    const std::int64_t coarser = unit * 10;
    const std::int64_t shorter =
        static_cast<std::int64_t>(std::llround(scaled / static_cast<double>(coarser))) * coarser;
    if (std::abs(static_cast<double>(shorter) - scaled) > 1) break;
    digits = shorter;
    unit = coarser;
    --places;
  }
  digits /= unit;
  if (digits == 0) {
    text += '0';
    return;
  }
  if (x < 0) text += '-';
  char buffer[24];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, digits).ptr;
  const auto count = static_cast<int>(end - buffer);
  if (places == 0) {
    text.append(buffer, end);
    return;
  }
  if (count <= places) {
    text += "0.";
    text.append(static_cast<std::size_t>(places - count), '0');
    text.append(buffer, end);
  } else {
    text.append(buffer, static_cast<std::size_t>(count - places));
    text += '.';
    text.append(end - places, end);
  }
}

std::string number_text(double x, int decimals) {
  std::string text;
  append_number(text, x, decimals);
  return text;
}

double rounded_number(double x, int decimals) { return *parse_number(number_text(x, decimals)); }

std::optional<double> parse_number(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  if (text.size() > 1 && text.front() == '+' && text[1] != '-' && text[1] != '+') text.remove_prefix(1);
  double value = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (problem != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

}  // namespace afptraj
