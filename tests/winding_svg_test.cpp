// The picture of a winding, read back: what its polygons cover is what the simulation finds covered.
#include "io/winding_svg.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "io/machine_program_file.h"
#include "io/program_file.h"
#include "tests/meridians.h"
#include "winding/plan_program.h"
#include "winding/vessel_program.h"

namespace afptraj {
namespace {

using std::numbers::pi;

struct Point {
  double x, y;
};
using Polygon = std::vector<Point>;

// The polygons of a picture by the colour of their group, by its own reading.
std::map<std::string, std::vector<Polygon>> polygons_of(const std::string& svg) {
  std::map<std::string, std::vector<Polygon>> out;
  std::istringstream lines(svg);
  std::string line, colour;
  while (std::getline(lines, line)) {
    const std::size_t fill = line.find("<g fill=\""), points = line.find("points=\"");
    if (fill != std::string::npos) colour = line.substr(fill + 9, 7);
    if (points == std::string::npos) continue;
    std::string text = line.substr(points + 8, line.rfind('"') - points - 8);
    std::replace(text.begin(), text.end(), ',', ' ');
    std::istringstream numbers(text);
    Polygon polygon;
    for (Point p{}; numbers >> p.x >> p.y;) polygon.push_back(p);
    out[colour].push_back(polygon);
  }
  return out;
}

bool inside(const Polygon& polygon, const Point& p) {
  bool in = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Point &a = polygon[i], &b = polygon[j];
    if ((a.y > p.y) != (b.y > p.y) && p.x < (b.x - a.x) * (p.y - a.y) / (b.y - a.y) + a.x) in = !in;
  }
  return in;
}

// Share of places between two abscissas that lie in some polygon, each weighted by its circle's radius.
template <typename Radius>
double covered(const std::vector<Polygon>& polygons, double from, double to, double height,
               const Radius& radius) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> share(0, 1);
  double all = 0, in = 0;
  for (int k = 0; k < 4000; ++k) {
    const Point p{from + (to - from) * share(random), height * share(random)};
    const double weight = radius(p.x);
    all += weight;
    if (std::any_of(polygons.begin(), polygons.end(),
                    [&](const Polygon& polygon) { return inside(polygon, p); }))
      in += weight;
  }
  return in / all;
}

MachineProfile machine() {
  MachineProfile profile;
  profile.axes[0] = MachineAxis{'X', -1000, 2000, 2000, 10000};
  profile.axes[1] = MachineAxis{'A', -1e9, 1e9, 3600, 20000};
  profile.axes[2] = MachineAxis{'Y', 0, 1000, 2000, 10000};
  return profile;
}

TEST(WindingSvg, ShowsWhatTheSimulationFinds) {
  VesselLayer layer{50, 4, 0.3};
  layer.steering.friction = 0.25;
  const double R = 50, L = 260;
  const VesselWinding winding{meridian_through({{0, R}, {L, R}}), {30, 0.3}, 6000, {layer}};
  std::string text;
  write_vessel_program(winding, machine(), OverSpeed::clamp, [&](std::string_view piece) { text += piece; });
  const std::size_t last = text.rfind("; Circuit "), end = text.find("; Tow cut");
  const std::string shorter = text.substr(0, last) + text.substr(end);
  for (const std::string& program : {text, shorter}) {
    const SimulatedMachineProgram simulated = simulate_machine_text("program", program);
    const LaidTravel& laid = simulated.layers.front().laid;
    UnrolledBand band{L, R, {unrolled_layer("a<b", winding.meridian, winding.tow, laid.path)}};
    const std::string svg = winding_svg(band);
    EXPECT_NE(svg.find("viewBox=\"0 0 260 314.16\""), std::string::npos);
    EXPECT_NE(svg.find("<title>a&lt;b</title>"), std::string::npos);
    const auto polygons = polygons_of(svg);
    ASSERT_EQ(polygons.size(), 2u);  // there and back
    double least = 1;
    for (const auto& [colour, some] : polygons)
      least = std::min(least, covered(some, 15, L - 15, 2 * pi * R, [](double) { return 1; }));
    // 4000 samples: a standard deviation of 0.006 where a tenth is bare
    EXPECT_NEAR(least, laid.one_way.covered_share, 0.02);
    if (program == text) {
      EXPECT_GT(least, 0.998);
    }
  }
  EXPECT_LT(simulate_machine_text("program", shorter).layers.front().laid.one_way.covered_share, 0.95);
}

TEST(WindingSvg, ShowsTubesAndCones) {
  for (const std::optional<double> end : {std::optional<double>{}, std::optional<double>{70}}) {
    const HelicalLayer helical{40, 4, 3, 540, 20, 60, true};
    const WindDefinition definition{"1.1", {90, 200, end}, {9, 0.3}, 6000, {helical}};
    std::string text;
    write_program(definition, WindMode::native, [&](std::string_view piece) { text += piece; });
    const SimulatedProgram program = simulate_text("program", text, {}, KeepPieces::yes);
    ASSERT_EQ(program.layers.size(), 1u);
    const double slant = std::hypot(1, (end.value_or(90) - 90) / 2 / 200);
    const UnrolledBand band{
        200 * slant, 45, {unrolled_layer("helical", program.mandrel, program.tow, program.layers[0].pieces)}};
    // a hundredth of the lines is enough on a tube, where they go straight on
    if (!end) {
      EXPECT_LT(program.layers[0].pieces.size() * 20, static_cast<std::size_t>(program.commands));
    }
    std::vector<Polygon> all;
    for (const auto& [colour, some] : polygons_of(winding_svg(band)))
      all.insert(all.end(), some.begin(), some.end());
    const double share = covered(all, 0, 200 * slant, 2 * pi * 45, [](double) { return 1; });
    EXPECT_NEAR(share, program.layers[0].coverage->covered_share, 0.005);
  }
}

}  // namespace
}  // namespace afptraj
