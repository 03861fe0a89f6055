#pragma once

#include <string>

namespace afptraj {

/// Numbers in messages and headers, written as FiberPath's users know them. No locale.

/// The shortest text that reads back as x, a whole number with ".0": 95.0, 96.92307692307692, 1e-07.
std::string shortest_text(double x);

/// At most `digits` significant digits without trailing zeros: 193.846, 180, 1e+06.
std::string significant_text(double x, int digits);

/// A whole number without a point, anything else as shortest_text: 70, 63.5.
std::string header_number(double x);

}  // namespace afptraj
