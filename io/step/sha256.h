#pragma once

#include <string>
#include <string_view>

namespace afptraj {

/// SHA-256 of `bytes` in lower-case hexadecimal. Source: FIPS 180-4.
std::string sha256_hex(std::string_view bytes);

}  // namespace afptraj
