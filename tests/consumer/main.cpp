// Follows a geodesic at 45 degrees on a cylinder of radius 350, where it is a helix: after the arc
// length s it has turned by s cos(45) / R and climbed s sin(45). Prints the end point.
#include <geometry/geodesic.h>

#include <cmath>
#include <cstdio>
#include <memory>

int main() {
  using namespace afptraj;
  const Surface cylinder = Surface::cylinder(Frame{}, 350);
  const auto part = std::make_shared<const Part>(make_rectangular_part(cylinder, {0, 2 * pi}, {-10, 1100}));
  const Skin skin(part, {0});
  const GeodesicTracer tracer(skin, {});
  const double start_angle = 0.5;
  // 45 degrees between the direction of the circle and the axis
  const Vec3 direction(-std::sin(start_angle), std::cos(start_angle), 1);
  GeodesicState state = tracer.start({0, {start_angle, 0}}, direction);
  if (tracer.advance(state, 1000 * std::sqrt(2.0)) != TraceEnd::reached) return 1;
  const Vec3 end = skin.point(state.at);
  std::printf("%.6f %.6f %.6f\n", end.x(), end.y(), end.z());
  return 0;
}
