#include "io/winding_svg.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "io/number_text.h"

namespace afptraj {
namespace {

// There and back, by layer.
constexpr std::array<std::array<const char*, 2>, 4> colours{
    {{"#1f5fa8", "#5b93cf"}, {"#a8481f", "#d48a68"}, {"#2b7a3d", "#6fb37e"}, {"#74398f", "#ac7cc2"}}};

std::string hundredths(double x) { return number_text(x, 2); }

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&') {
      out += "&amp;";
    } else if (c == '<') {
      out += "&lt;";
    } else {
      out += c;
    }
  }
  return out;
}

// The strip, moved by whole turns to where it begins in the picture, and again where it leaves that.
void add_strip(const UnrolledStrip& strip, double height, std::string& text) {
  std::vector<UnrolledPoint> outline = strip.left;
  outline.insert(outline.end(), strip.right.rbegin(), strip.right.rend());
  const auto [low, high] = std::minmax_element(
      outline.begin(), outline.end(), [](const auto& a, const auto& b) { return a.turn_deg < b.turn_deg; });
  for (double turns = std::floor(low->turn_deg / 360); turns * 360 < high->turn_deg; ++turns) {
    text += "<polygon points=\"";
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const double y = height * (1 - (outline[i].turn_deg / 360 - turns));
      text += (i == 0 ? "" : " ") + hundredths(outline[i].along_mm) + "," + hundredths(y);
    }
    text += "\"/>\n";
  }
}

}  // namespace

std::string winding_svg(const UnrolledBand& band) {
  const double height = 2 * std::numbers::pi * band.radius_mm;
  const std::string box = "0 0 " + hundredths(band.length_mm) + " " + hundredths(height);
  std::string text = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"" + box + "\" width=\"1000\">\n" +
                     "<rect width=\"" + hundredths(band.length_mm) + "\" height=\"" + hundredths(height) +
                     "\" fill=\"white\"/>\n";
  for (std::size_t i = 0; i < band.layers.size(); ++i) {
    const auto& shades = colours[i % colours.size()];
    text += "<g id=\"layer-" + std::to_string(i + 1) + "\" fill-opacity=\"0.5\">\n<title>" +
            escaped(band.layers[i].name) + "</title>\n";
    // runs of strips that go one way share a group
    const std::vector<UnrolledStrip>& strips = band.layers[i].strips;
    for (std::size_t k = 0; k < strips.size(); ++k) {
      const bool first = k == 0 || strips[k].back != strips[k - 1].back;
      if (first) text += std::string("<g fill=\"") + shades[strips[k].back ? 1 : 0] + "\">\n";
      add_strip(strips[k], height, text);
      if (k + 1 == strips.size() || strips[k].back != strips[k + 1].back) text += "</g>\n";
    }
    text += "</g>\n";
  }
  return text + "</svg>\n";
}

}  // namespace afptraj
