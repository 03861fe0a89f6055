#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace afptraj {

/// The whole number of millionths nearest to x, halves to even, from the exact value of the double.
/// |x| < fixed_limit.
std::int64_t millionths(double x);
inline constexpr double fixed_limit = 4e9;

/// Writes x at `at` with six decimals (rounded as above) without trailing zeros, at most `fixed_room`
/// characters, and returns the end. What rounds to zero from below is "-0" where `minus_zero` is wanted,
/// else "0". Throws Error(no_path) when x is not finite.
char* write_fixed(char* at, double x, bool minus_zero);
inline constexpr std::size_t fixed_room = 320;

std::string fixed_text(double x, bool minus_zero = false);

}  // namespace afptraj
