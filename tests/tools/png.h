#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace picture {

/// Writes 8-bit RGB rows as PNG; throws std::runtime_error.
void write_png(const std::string& path, int width, int height, const std::vector<std::uint8_t>& rgb);

}  // namespace picture
