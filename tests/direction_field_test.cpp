#include "trajectory/direction_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "geometry/error.h"
#include "tests/specimens.h"

namespace afptraj {
namespace {

// A place with a tilted normal and a basis of its tangent plane; every component is a third.
const Vec3 P(7, -3, 11);
const Vec3 n = Vec3(1, 2, 2) / 3, a = Vec3(2, 1, -2) / 3, b = Vec3(2, -2, 1) / 3;

OrientationPoint point(const Vec3& position, const Vec3& direction) {
  return {position, direction, Vec3::Zero()};
}

constexpr double rounding = 1e-14;

void expect_direction(const AskedDirection& asked, const Vec3& expected) {
  ASSERT_FALSE(asked.singular);
  EXPECT_LT((asked.direction - expected.normalized()).norm(), rounding) << asked.direction.transpose();
}

// R_k is the distance from the normal line: 5 and 10, however far the points lie along n. With the
// sign of P' = P + n ((P_k - P) . n) turned they would be 180 and 41 and the weights others.
TEST(DirectionField, WeighsByTheDistanceFromTheNormalLine) {
  const DirectionField field({point(P + 3 * a + 4 * b + 90 * n, a), point(P - 10 * b - 20 * n, b)}, 12);
  const AskedDirection asked = field.at(P, n, a + b);
  expect_direction(asked, 2 * a + b);  // w = 1/5 : 1/10
  EXPECT_EQ(asked.range_mm, 12);
  EXPECT_FALSE(asked.range_doubled);
}

// Doubling a range of 0 would never end.
TEST(DirectionField, RefusesARangeThatIsNotPositive) {
  for (const double range : {0.0, -1.0, std::nan("")})
    EXPECT_THROW(DirectionField({point(P + a, a)}, range), std::invalid_argument) << range;
}

TEST(DirectionField, LeavesOutPointsBeyondTheRange) {
  const std::vector<OrientationPoint> points{point(P + 3 * a + 4 * b + 90 * n, a),
                                             point(P - 10 * b - 20 * n, b)};
  expect_direction(DirectionField(points, 9.999).at(P, n, a + b), a);
  // R_k = range counts; 10 is not exact here, hence the hair.
  expect_direction(DirectionField(points, 10 + 1e-12).at(P, n, a + b), 2 * a + b);
}

// Only the direction counts, not its length; the part along n falls away after the sum.
TEST(DirectionField, TakesDirectionsOfAnyLength) {
  const DirectionField field({point(P + 5 * a, 1e6 * a), point(P - 5 * b, 1e-6 * (b + n))}, 6);
  expect_direction(field.at(P, n, a + b), a + b / std::sqrt(2.0));
}

// A fibre has no sense: turning a given direction changes nothing, turning the walk turns the answer.
TEST(DirectionField, TakesDirectionsAsAxes) {
  for (const double sense1 : {1.0, -1.0})
    for (const double sense2 : {1.0, -1.0}) {
      const DirectionField field(
          {point(P + 5 * a, sense1 * (a + 0.1 * b)), point(P + 10 * b, sense2 * (a - 0.1 * b))}, 20);
      // Equal lengths, so the weights 2 : 1 act on the unit directions.
      const Vec3 expected = 3 * a + 0.1 * b;
      expect_direction(field.at(P, n, a), expected);
      expect_direction(field.at(P, n, -a), -expected);
    }
}

TEST(DirectionField, GivesThePointsOwnDirectionOnItsNormalLine) {
  const DirectionField field({point(P + 1e-3 * a, a), point(P + 40 * n, b), point(P - 2 * b, a)}, 50);
  expect_direction(field.at(P, n, a + b), b);
  expect_direction(field.at(P, n, -b), -b);
  // And tends to it: at R = 1e-6 beside R = 2 the other direction weighs 5e-7.
  const DirectionField near({point(P + 1e-6 * a, b), point(P - 2 * b, a)}, 50);
  EXPECT_LT((near.at(P, n, b).direction - b).norm(), 1e-6);
  EXPECT_GT((near.at(P, n, b).direction - b).norm(), 1e-7);
}

// The opposite wall of a thin part lies near the normal line too, but faces away.
TEST(DirectionField, LeavesOutTheOppositeWall) {
  OrientationPoint here = point(P + 8 * a, a), wall = point(P + 1 * a - 3 * n, b);
  here.skin_normal = (n + 0.5 * a).normalized();
  wall.skin_normal = -n;
  expect_direction(DirectionField({here, wall}, 10).at(P, n, a + b), a);
  wall.skin_normal = Vec3::Zero();  // unknown: counts
  expect_direction(DirectionField({here, wall}, 10).at(P, n, a + b), a + 8 * b);
  // With nothing else there is nothing to ask for, and no range to double for ever.
  wall.skin_normal = -n;
  const AskedDirection asked = DirectionField({wall}, 10).at(P, n, b);
  EXPECT_TRUE(asked.singular);
  EXPECT_TRUE(asked.direction.allFinite());
}

// Opposite directions at right angles to the walk cannot be told apart: a singularity, not a NaN.
// Axes here, so that the right angles are exact.
TEST(DirectionField, ReportsDirectionsThatCancel) {
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
  const auto at = [&](double weight_1, const Vec3& second) {
    const DirectionField field({point(P + 5 / weight_1 * x, y), point(P - 5 * x, second)}, 100);
    return field.at(P, z, x);
  };
  const AskedDirection cancelled = at(1, -y);
  EXPECT_TRUE(cancelled.singular);
  EXPECT_TRUE(cancelled.direction.allFinite());
  expect_direction(at(1.01, -y), y);       // |V| = 0.005: weak, but a direction
  EXPECT_TRUE(at(1 + 1e-7, -y).singular);  // |V| = 5e-8
  // A direction along the normal asks for nothing either.
  const AskedDirection upright = DirectionField({point(P + 5 * x, z)}, 100).at(P, z, x);
  EXPECT_TRUE(upright.singular);
  EXPECT_TRUE(upright.direction.allFinite());
  EXPECT_TRUE(DirectionField({}, 100).at(P, z, x).singular);
}

// The nearest point lies at 70: 10 doubles to 80, and then all points within 80 count.
TEST(DirectionField, DoublesTheRangeUntilAPointIsIn) {
  const DirectionField field({point(P + 70 * a, a), point(P + 79 * b, b), point(P - 81 * b, b)}, 10);
  const AskedDirection asked = field.at(P, n, a + b);
  EXPECT_TRUE(asked.range_doubled);
  EXPECT_EQ(asked.range_mm, 80);
  expect_direction(asked, a / 70 + b / 79);
}

// The answer is a unit vector of the tangent plane in the sense of the walk, wherever it is asked for.
TEST(DirectionField, AnswersInTheTangentPlaneInTheSenseOfTheWalk) {
  std::mt19937 rng(5);
  std::normal_distribution<double> normal;
  const auto vector = [&] { return Vec3(normal(rng), normal(rng), normal(rng)); };
  for (int i = 0; i < 200; ++i) {
    std::vector<OrientationPoint> points;
    for (int k = 0; k < 5; ++k) points.push_back(point(30 * vector(), vector()));
    const Vec3 up = vector().normalized(), walk = up.cross(vector()).normalized();
    const AskedDirection asked = DirectionField(points, 20).at(30 * vector(), up, walk);
    if (asked.singular) continue;
    EXPECT_NEAR(asked.direction.norm(), 1, rounding);
    EXPECT_NEAR(asked.direction.dot(up), 0, rounding);
    // Each summand has a part along the walk that is not negative, and the walk lies in the plane.
    EXPECT_GE(asked.direction.dot(walk), -rounding);
  }
}

// The skin tells the normals: on a tube of 40 mm the far wall does not count.
TEST(DirectionField, LooksUpTheNormalsOfTheSkin) {
  const Skin tube = make_skin(Surface::cylinder({}, 20), {0, 2 * pi}, {0, 100});
  PlyOrientation ply{"P", {{Vec3(20, 0, 50), Vec3(0, 0, 3), 2}, {Vec3(-20, 0, 50), Vec3(0, 1, 0), 3}}, 0};
  const DirectionField field = make_direction_field(tube, ply, 50, 5, "plies.csv");
  expect_direction(field.at(Vec3(20, 0, 60), Vec3(1, 0, 0), Vec3(0, 1, 1)), Vec3(0, 0, 1));
  expect_direction(field.at(Vec3(-20, 0, 60), Vec3(-1, 0, 0), Vec3(0, 1, 1)), Vec3(0, 1, 0));

  ply.points[1].position = Vec3(-26, 0, 50);
  try {
    make_direction_field(tube, ply, 50, 5, "plies.csv");
    FAIL() << "a point 6 mm off the skin was taken";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::bad_input);
    EXPECT_EQ(e.where(), "plies.csv:3");
    EXPECT_NE(std::string(e.what()).find("6 mm"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace afptraj
