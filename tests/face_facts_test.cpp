// Face facts, surfaces of revolution and the choice of a group of faces.
#include "geometry/face_facts.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "geometry/revolution.h"

namespace afptraj {
namespace {

std::shared_ptr<const Part> part_of(const Surface& surface, const Interval& u, const Interval& v) {
  return std::make_shared<const Part>(make_rectangular_part(surface, u, v));
}

FaceFacts facts_of(const Surface& surface, const Interval& u, const Interval& v) {
  const auto part = part_of(surface, u, v);
  return face_facts(*part, 0, TrimRegion(part->faces[0]));
}

std::optional<Revolution> revolution_of(const Surface& surface, const Interval& u, const Interval& v,
                                        double tolerance = 1e-6) {
  const auto part = part_of(surface, u, v);
  return find_revolution(*part, 0, TrimRegion(part->faces[0]), tolerance);
}

// Turned by `angle` about z, a profile of quadratic pieces: exact as a rational B-spline.
// Source: Piegl & Tiller, ch. 8.5 (one arc of less than 180 degrees).
BSplineSurface revolved(const std::vector<Eigen::Vector2d>& profile, double angle, const Frame& frame) {
  BSplineSurface s;
  s.degree_u = 2;
  s.degree_v = 2;
  s.knots_u = {0, 0, 0, 1, 1, 1};
  s.knots_v = {0, 0, 0};
  for (std::size_t i = 3; i < profile.size(); ++i) s.knots_v.push_back(static_cast<double>(i - 2));
  for (int i = 0; i < 3; ++i) s.knots_v.push_back(static_cast<double>(profile.size() - 2));
  const double w = std::cos(angle / 2);
  for (int i = 0; i < 3; ++i) {
    const double a = angle * i / 2, stretch = i == 1 ? 1 / w : 1;
    for (const Eigen::Vector2d& p : profile) {
      s.poles.push_back(frame.origin + stretch * p.x() * (std::cos(a) * frame.x + std::sin(a) * frame.y) +
                        p.y() * frame.z);
      s.weights.push_back(i == 1 ? w : 1);
    }
  }
  return s;
}

Frame tilted_frame() {
  const Eigen::Quaterniond q =
      Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()) * Eigen::AngleAxisd(1.1, Vec3::UnitX());
  return {Vec3(100, -200, 300), q * Vec3::UnitX(), q * Vec3::UnitY(), q * Vec3::UnitZ()};
}

const std::vector<Eigen::Vector2d> vase{{200, 0}, {260, 100}, {180, 220}, {150, 330}, {220, 500}};

TEST(FaceFacts, OfAQuarterCylinder) {
  const FaceFacts facts = facts_of(Surface::cylinder(Frame{}, 350), {0, pi / 2}, {0, 1000});
  // midpoint sums of a constant are exact
  EXPECT_NEAR(facts.area_mm2, 350 * pi / 2 * 1000, 1e-6);
  EXPECT_NEAR(facts.smallest_radius_mm, 350, 1e-9);
  EXPECT_LT((facts.box_min - Vec3(0, 0, 0)).norm(), 1e-9);
  EXPECT_LT((facts.box_max - Vec3(350, 350, 1000)).norm(), 1e-9);
  EXPECT_EQ(facts.holes, 0);
  EXPECT_TRUE(facts.neighbours.empty());
}

TEST(FaceFacts, OfAPlaneIsFlat) {
  EXPECT_TRUE(std::isinf(facts_of(Surface::plane(Frame{}), {0, 10}, {0, 20}).smallest_radius_mm));
}

TEST(FaceFacts, CountHoles) {
  Part part = make_rectangular_part(Surface::plane(Frame{}), {0, 100}, {0, 100});
  Loop hole;
  const Uv corners[4] = {{40, 40}, {40, 60}, {60, 60}, {60, 40}};  // clockwise
  for (int i = 0; i < 4; ++i) {
    hole.coedges.push_back(
        {line_segment(corners[i], corners[(i + 1) % 4]), false, static_cast<int>(part.edges.size())});
    part.edges.emplace_back();
  }
  part.faces[0].loops.push_back(hole);
  const FaceFacts facts = face_facts(part, 0, TrimRegion(part.faces[0]));
  EXPECT_EQ(facts.holes, 1);
  EXPECT_NEAR(facts.area_mm2, 100 * 100 - 20 * 20, 200);  // cells of 2.2 mm along a rim of 80 mm
}

TEST(Revolution, OfAnalyticKinds) {
  const Frame frame = tilted_frame();
  const auto cone = revolution_of(Surface::cone(frame, 200, 0.3), {0, 2}, {0, 300});
  ASSERT_TRUE(cone);
  EXPECT_NEAR(std::abs(cone->direction.dot(frame.z)), 1, 1e-12);
  EXPECT_NEAR((cone->point - frame.origin).cross(frame.z).norm(), 0, 1e-9);
  EXPECT_EQ(cone->deviation_mm, 0);
  EXPECT_GT(cone->radius_max_mm, 280);
  EXPECT_FALSE(revolution_of(Surface::plane(frame), {0, 100}, {0, 100}));
}

// The axis of a B-spline is found to rounding, whatever its place and the sector it covers.
TEST(Revolution, OfABSplineInAnyPlace) {
  for (const Frame& frame : {Frame{}, tilted_frame()}) {
    for (const double angle : {0.4, 1.0, 2.5}) {
      const auto found = revolution_of(Surface::bspline(revolved(vase, angle, frame)), {0, 1}, {0, 3});
      ASSERT_TRUE(found) << angle;
      EXPECT_NEAR(std::abs(found->direction.dot(frame.z)), 1, 1e-9) << angle;
      EXPECT_LT((found->point - frame.origin).cross(frame.z).norm(), 1e-5) << angle;
      EXPECT_LT(found->deviation_mm, 1e-6) << angle;
      ASSERT_EQ(found->profile.size(), Revolution::profile_points);
      EXPECT_GE(found->radius_min_mm, 150);
      EXPECT_LE(found->radius_max_mm, 260);
    }
  }
}

// A cylinder may be shifted in itself as well as turned, a sphere turned about any axis.
TEST(Revolution, OfSymmetricBSplines) {
  const Frame frame = tilted_frame();
  const auto cylinder =
      revolution_of(Surface::bspline(revolved({{300, 0}, {300, 200}, {300, 400}}, 2, frame)), {0, 1}, {0, 1});
  ASSERT_TRUE(cylinder);
  EXPECT_NEAR(std::abs(cylinder->direction.dot(frame.z)), 1, 1e-9);
  EXPECT_NEAR(cylinder->radius_min_mm, 300, 1e-6);
}

// What is turned about no axis is not taken for it.
TEST(Revolution, RefusesOtherSurfaces) {
  BSplineSurface bumped = revolved(vase, 2.5, Frame{});
  bumped.poles[7] += Vec3(0, 0, 3);
  EXPECT_FALSE(revolution_of(Surface::bspline(bumped), {0, 1}, {0, 3}));
  BSplineSurface saddle;
  saddle.degree_u = saddle.degree_v = 2;
  saddle.knots_u = saddle.knots_v = {0, 0, 0, 1, 1, 1};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      saddle.poles.emplace_back(100 * i, 130 * j, 40.0 * (i - 1) * (j - 1) + 15 * i * i);
  }
  EXPECT_FALSE(revolution_of(Surface::bspline(saddle), {0, 1}, {0, 1}));
  // extruded along x: shifts in itself, turns about nothing near
  BSplineSurface gutter = saddle;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      gutter.poles[static_cast<std::size_t>(3 * i + j)] = Vec3(100 * i, 130 * j,
                                                               j == 1   ? 0
                                                               : j == 0 ? 40
                                                                        : 90);
  }
  EXPECT_FALSE(revolution_of(Surface::bspline(gutter), {0, 1}, {0, 1}));
}

// Two plates in space: the points decide which is laid on.
TEST(NearestTangentGroup, FollowsMostPoints) {
  Frame high;
  high.origin = Vec3(0, 0, 500);
  const auto low_face = make_rectangular_face(Surface::plane(Frame{}), {0, 100}, {0, 100}, 0);
  const auto high_face = make_rectangular_face(Surface::plane(high), {0, 100}, {0, 100},
                                               static_cast<int>(low_face.edges.size()));
  auto part = std::make_shared<Part>();
  part->faces = {low_face.face, high_face.face};
  part->edges = low_face.edges;
  part->edges.insert(part->edges.end(), high_face.edges.begin(), high_face.edges.end());
  std::vector<std::shared_ptr<const TrimRegion>> trim;
  for (const Face& face : part->faces) trim.push_back(std::make_shared<const TrimRegion>(face));
  const auto choose = [&](const std::vector<Vec3>& points) {
    return nearest_tangent_group(part, trim, points, 0.1);
  };
  EXPECT_EQ(choose({{50, 50, 0}, {20, 50, 1}, {50, 50, 499}}), (std::vector<int>{0}));
  EXPECT_EQ(choose({{50, 50, 0}, {20, 50, 501}, {50, 50, 499}}), (std::vector<int>{1}));
  EXPECT_TRUE(choose({}).empty());
}

}  // namespace
}  // namespace afptraj
