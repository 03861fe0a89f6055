#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace afptraj {

/// Appends the shortest decimal text t (no exponent for |x| < 4e6) with |t - x| <= 10^-decimals,
/// up to the rounding of a double. Nine decimals suit mm and unit vectors, twelve 1/mm.
/// Never writes "-0", and never a NaN or infinity: those throw Error(internal).
/// The decimal point is a point in every locale.
void append_number(std::string& text, double x, int decimals = 9);
std::string number_text(double x, int decimals = 9);

/// The double that number_text(x, decimals) reads back as.
double rounded_number(double x, int decimals = 9);

/// The number that the whole of `text` (blanks around it allowed) means, in every locale; nothing
/// when it is not a finite number. A leading '+' is allowed.
std::optional<double> parse_number(std::string_view text);

}  // namespace afptraj
