#include "winding/skin_mandrel.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/error.h"
#include "winding/meridian_geodesic.h"

namespace afptraj {
namespace {

struct Patch {
  Surface surface;
  Interval u, v;
};

// The patches as faces that only lie beside each other.
Skin skin_of(const std::vector<Patch>& patches) {
  Part part;
  std::vector<int> faces;
  for (const Patch& patch : patches) {
    const RectangularFace made =
        make_rectangular_face(patch.surface, patch.u, patch.v, static_cast<int>(part.edges.size()));
    part.faces.push_back(made.face);
    part.edges.insert(part.edges.end(), made.edges.begin(), made.edges.end());
    faces.push_back(static_cast<int>(faces.size()));
  }
  return Skin(std::make_shared<const Part>(std::move(part)), faces);
}

Frame tilted(double along) {
  Frame f;
  f.x = Vec3(1, 2, 2) / 3;
  f.y = Vec3(2, 1, -2) / 3;
  f.z = Vec3(-2, 2, -1) / 3;
  f.origin = Vec3(10, -20, 5) + f.z * along;
  return f;
}

constexpr double R = 150, L = 420;
const Interval round{0, 2 * pi};

std::vector<Patch> tank() {
  return {{Surface::cylinder(tilted(0), R), round, {0, L}},
          {Surface::sphere(tilted(0), R), round, {-pi / 2 + 0.1, 0}},
          {Surface::sphere(tilted(L), R), round, {0, pi / 2 - 0.1}}};
}

std::string refusal(const std::vector<Patch>& patches, double tolerance_mm = 0.01) {
  try {
    mandrel_from_skin(skin_of(patches), tolerance_mm);
    return "(made)";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::bad_input);
    return e.what();
  }
}

TEST(SkinMandrel, ATankOfThreeFacesAnywhereInSpace) {
  const SkinMandrel mandrel = mandrel_from_skin(skin_of(tank()), 0.01);
  EXPECT_NEAR(std::abs(mandrel.direction.dot(tilted(0).z)), 1, 1e-12);
  EXPECT_LT((mandrel.origin - tilted(0).origin).cross(mandrel.direction).norm(), 1e-9);
  EXPECT_LT(mandrel.deviation_mm, 1e-7);
  const Meridian& meridian = mandrel.meridian;
  EXPECT_NEAR(meridian.at(meridian.widest()).r_mm, R, 1e-8);
  EXPECT_NEAR(meridian.length_mm(), L + R * (pi - 0.2), 1e-6);
  EXPECT_LT(meridian.breaks().size(), 1000u);  // of some 4000 rows of the section
  EXPECT_NEAR(meridian.at(meridian.first()).r_mm, R * std::sin(0.1), 1e-8);
  // sections of a step of 0.2 mm: the spline holds the circle to 1e-12, what is left is the section's own
  // 1e-9 or so
  for (const double alpha : {0.2, 0.5, 1.0}) {
    const MeridianGeodesic geodesic(meridian, R * std::sin(alpha), meridian.widest());
    EXPECT_NEAR(geodesic.turn_rad(), pi + L * std::tan(alpha) / R, 1e-6);
    EXPECT_NEAR(geodesic.length_mm(), pi * R + L / std::cos(alpha), 1e-4);
  }
}

TEST(SkinMandrel, ASectorIsEnough) {
  const SkinMandrel mandrel =
      mandrel_from_skin(skin_of({{Surface::cone(tilted(0), 80, 0.2), {0.4, 1.1}, {0, 100}}}), 0.01);
  EXPECT_NEAR(mandrel.meridian.length_mm(), 100, 1e-6);
}

TEST(SkinMandrel, SaysWhatIsNoMandrel) {
  auto patches = tank();
  patches.push_back({Surface::cylinder(tilted(0), R - 3), round, {0, L}});
  EXPECT_NE(refusal(patches).find("more than one wall"), std::string::npos) << refusal(patches);
  patches = tank();
  patches[2].surface = Surface::sphere(tilted(L + 5), R);
  EXPECT_NE(refusal(patches).find("has a gap near z"), std::string::npos) << refusal(patches);
  patches = tank();
  Frame beside = tilted(L);
  beside.origin += 0.5 * beside.x;
  patches[2].surface = Surface::sphere(beside, R);
  EXPECT_NE(refusal(patches).find("--face"), std::string::npos);
  EXPECT_NE(refusal(patches, 2).find("(made)"), std::string::npos) << refusal(patches, 2);
  EXPECT_NE(refusal({{Surface::plane(tilted(0)), {0, 10}, {0, 10}}}).find("no face of revolution"),
            std::string::npos);
}

}  // namespace
}  // namespace afptraj
