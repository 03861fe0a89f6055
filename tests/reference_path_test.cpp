#include "trajectory/reference_path.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/curvature.h"
#include "tests/specimens.h"

namespace afptraj {
namespace {

/// Steps of exactly lambda: the chord error is left free.
StepOptions steps_of(double lambda) {
  StepOptions o;
  o.step_mm = lambda;
  o.chord_error_mm = 1e9;
  return o;
}

std::size_t start_of(const SteppedPath& path) {
  std::size_t i = 0;
  while (path.points[i].s_mm < 0) ++i;
  return i;
}

/// Ply points aside of the path with directions that differ, all in range everywhere: the field varies
/// and is smooth, so that the order of the steps is what is measured.
DirectionField varying_field(const Skin& skin) {
  PlyOrientation ply{"P", {}, 0};
  const Vec3 places[] = {{480, 130, 0}, {250, 520, 0}, {780, 540, 0}, {700, 80, 0}, {150, 90, 0}};
  const double degrees[] = {24, -6, 20, -12, 15};
  for (int i = 0; i < 5; ++i) {
    const double angle = degrees[i] * pi / 180;
    const auto on_skin = skin.closest_point().closest(places[i]);
    ply.points.push_back({on_skin->point, Vec3(std::cos(angle), std::sin(angle), 0), 0});
  }
  return make_direction_field(skin, ply, 1e4, 5, "");
}

void expect_sound(const Skin& skin, const SteppedPath& path, double lambda) {
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    const SteppedPoint& p = path.points[i];
    EXPECT_LT((skin.point(p.at) - p.position).norm(), 1e-12);
    EXPECT_NEAR(p.direction.norm(), 1, 1e-12);
    if (i == 0) continue;
    const Vec3 chord = p.position - path.points[i - 1].position;
    EXPECT_NEAR(p.s_mm - path.points[i - 1].s_mm, chord.norm(), 1e-9);
    EXPECT_LE(chord.norm(), lambda * (1 + 1e-3));
    EXPECT_GT(chord.dot(p.direction), 0);
  }
}

// Error O(lambda^2) against the field line: halving the step quarters it. The truth is a step 16 times
// smaller than the finest that is measured and adds 1/256 of that one's error. The bound 1.8 leaves room for
// the next term of the expansion only; a first-order rule gives 1.
TEST(ReferencePath, IsOfSecondOrderInTheStep) {
  const Skin skin = make_skin(gentle_surface(), {0, 1}, {0, 1});
  const DirectionField field = varying_field(skin);
  const SurfacePoint start{0, Uv(0.5, 0.47)};
  const double walked = 320;
  const auto path_of = [&](double lambda) {
    return step_reference_path(skin, field, start, steps_of(lambda));
  };
  const SteppedPath paths[] = {path_of(4), path_of(2), path_of(1), path_of(0.0625)};
  for (const int way : {1, -1}) {
    const auto after = [&](const SteppedPath& path, double lambda) {
      const auto steps = std::lround(walked / lambda), first = static_cast<long>(start_of(path));
      return path.points.at(static_cast<std::size_t>(first + way * steps)).position;
    };
    const Vec3 truth = after(paths[3], 0.0625);
    const double e4 = (after(paths[0], 4) - truth).norm(), e2 = (after(paths[1], 2) - truth).norm(),
                 e1 = (after(paths[2], 1) - truth).norm();
    EXPECT_GT(std::log2(e4 / e2), 1.8) << way << ": " << e4 << " " << e2;
    EXPECT_GT(std::log2(e2 / e1), 1.8) << way << ": " << e2 << " " << e1;
    EXPECT_GT(e1, 1e-8) << "nothing was measured";
  }
}

// The step by itself, on a cylinder along the hoop: the osculating circle is the hoop, so the step is exact.
// At a slant the arc leaves the helix by the next term: third order in the step.
TEST(ReferencePath, StepsOnTheOsculatingArc) {
  const double R = 350;
  const Skin skin = make_skin(Surface::cylinder({}, R), {0, 2 * pi}, {0, 1000});
  const ArcStep from{{0, Uv(1, 500)}, 1, false};
  const SurfaceDerivatives d = skin.derivatives(from.at);
  const auto miss = [&](double angle, double length) {
    const auto to =
        arc_step(skin, from, std::cos(angle) * d.Su.normalized() + std::sin(angle) * d.Sv, length);
    if (!to) return 1e9;
    const double phi = 1 + length * std::cos(angle) / R, z = 500 + length * std::sin(angle);
    return (skin.point(to->at) - Vec3(R * std::cos(phi), R * std::sin(phi), z)).norm();
  };
  EXPECT_LT(miss(0, 40), 1e-10);
  EXPECT_LT(miss(pi / 2, 40), 1e-10);  // straight
  const double e40 = miss(0.7, 40), e20 = miss(0.7, 20);
  EXPECT_GT(std::log2(e40 / e20), 2.8) << e40 << " " << e20;
  EXPECT_LT(e20, 20 * 20 * 20 / (R * R) / 6);
  EXPECT_FALSE(arc_step(skin, {{0, Uv(1, 990)}, 1, false}, d.Sv, 20));  // off the rim
}

// Both ways to the boundary, from one end to the other, with the start between.
TEST(ReferencePath, WalksToBothSides) {
  const Skin skin = make_skin(gentle_surface(), {0, 1}, {0, 1});
  const DirectionField field = varying_field(skin);
  const SurfacePoint start{0, Uv(0.31, 0.47)};
  const SteppedPath path = step_reference_path(skin, field, start, steps_of(2));
  EXPECT_EQ(path.end[0], WalkEnd::boundary);
  EXPECT_EQ(path.end[1], WalkEnd::boundary);
  EXPECT_FALSE(path.closed);
  expect_sound(skin, path, 2);
  EXPECT_EQ(path.points.size(), path.steps + 1);
  EXPECT_EQ(path.doubled, 0u);
  const std::size_t i = start_of(path);
  EXPECT_EQ(path.points[i].s_mm, 0);
  EXPECT_EQ(path.points[i].at.uv, start.uv);
  // The sides x = 0 and x = 1000 are less than a step ahead; the first ply point gives the sense.
  EXPECT_LT(path.points.front().position.x(), 2);
  EXPECT_GT(path.points.back().position.x(), 998);
  // The same field line from another of its points: O(lambda^2) apart, some 2e-4 here.
  const SteppedPath again = step_reference_path(skin, field, path.points[i + 100].at, steps_of(2));
  const std::size_t j = start_of(again);
  for (const int k : {-200, -100, 0, 100, 150}) {
    const auto a = static_cast<std::size_t>(static_cast<int>(i) + 100 + k);
    const auto b = static_cast<std::size_t>(static_cast<int>(j) + k);
    EXPECT_LT((path.points[a].position - again.points[b].position).norm(), 1e-3) << k;
  }
}

// On a plate with one direction the path is the straight line through the start.
TEST(ReferencePath, IsStraightWhereTheFieldIs) {
  const Skin skin = make_skin(Surface::plane({}), {0, 400}, {0, 300});
  const DirectionField field({{Vec3(10, 10, 0), Vec3(-4, -3, 0), Vec3::UnitZ()}}, 1e4);
  const SteppedPath path = step_reference_path(skin, field, {0, Uv(200, 140)}, steps_of(2));
  for (const SteppedPoint& p : path.points) {
    EXPECT_NEAR((p.position.y() - 140) * 4 - (p.position.x() - 200) * 3, 0, 1e-9);
    EXPECT_LT((p.direction - Vec3(-0.8, -0.6, 0)).norm(), 1e-12);
  }
  EXPECT_NEAR(path.points.front().position.x(), 400, 2);
  EXPECT_NEAR(path.points.back().position.y(), 0, 2);
}

// With a bound on the chord error h^2 / 8 R the steps get shorter where the surface bends.
TEST(ReferencePath, ShortensStepsByTheChordError) {
  const double R = 40;
  const Skin skin = make_skin(Surface::cylinder({}, R), {0, 2 * pi}, {0, 1000});
  const DirectionField field({{Vec3(R, 0, 500), Vec3(0, 1, 1), Vec3::Zero()}}, 1e4);
  StepOptions options;
  options.step_mm = 20;
  options.chord_error_mm = 0.01;
  options.max_length_mm = 300;
  const SteppedPath path = step_reference_path(skin, field, {0, Uv(0, 500)}, options);
  ASSERT_GT(path.points.size(), 60u);  // 16 without the bound
  for (std::size_t i = 1; i < path.points.size(); ++i) {
    const Vec3 middle = 0.5 * (path.points[i].position + path.points[i - 1].position);
    EXPECT_LT(R - std::hypot(middle.x(), middle.y()), 0.01 * 1.01);
  }
}

/// Hoops everywhere: directions round the axis of a tube, on both walls.
DirectionField hoop_field(const Skin& skin, double R, double z) {
  PlyOrientation ply{"P", {}, 0};
  for (int i = 0; i < 12; ++i) {
    const double a = i * pi / 6;
    ply.points.push_back(
        {Vec3(R * std::cos(a), R * std::sin(a), z + 5 * i), Vec3(-std::sin(a), std::cos(a), 0), 0});
  }
  return make_direction_field(skin, ply, 4 * R, 5, "");
}

void expect_hoop(const SteppedPath& path, double R, double z) {
  EXPECT_TRUE(path.closed) << R << ": " << to_string(path.end[1]);
  if (!path.closed) return;
  EXPECT_EQ(path.end[0], WalkEnd::closed);
  EXPECT_EQ(path.end[1], WalkEnd::closed);
  EXPECT_EQ(path.points.front().position, path.points.back().position);
  // Once round: chords of 2 mm fall short of their arcs by their third power, and the last step is what is
  // left.
  EXPECT_NEAR(path.points.back().s_mm, 2 * pi * R, 4);
  for (const SteppedPoint& p : path.points) EXPECT_NEAR(p.position.z(), z, 1e-8) << R;
}

// The path closes where it comes back to its start, whatever the radius and the rest of the last step: on
// narrow tubes the bend of the last step was once taken for a sideways distance, and the path for one
// alongside itself.
TEST(ReferencePath, ClosesRoundACylinder) {
  // From a circumference of W, over 2.5 W (R = 20.2): below 3 W once only a second or third turn closed.
  for (double R = 8; R < 400; R *= 1.07) {
    const Skin skin = make_skin(Surface::cylinder({}, R), {0, 2 * pi}, {0, 200});
    expect_hoop(step_reference_path(skin, hoop_field(skin, R, 70), {0, Uv(0.3, 100)}, StepOptions{}), R, 100);
  }
}

// The same over the seam and the creases of a closed B-spline.
TEST(ReferencePath, ClosesRoundAClosedBSpline) {
  for (const double R : {90.0, 180.0, 350.0}) {
    const Skin skin = make_skin(nurbs_cylinder(R, 200), {0, 4}, {0, 1});
    expect_hoop(step_reference_path(skin, hoop_field(skin, R, 70), {0, Uv(0.3, 0.5)}, StepOptions{}), R, 100);
  }
}

// A path that would come back aside of its start by a little is closed, the distance taken up evenly: a helix
// of pitch h on a cylinder becomes the ring through its start. Above the limit it stays a helix.
TEST(ReferencePath, ClosesAHelixOfLittlePitch) {
  const double R = 300, length = 2 * pi * R;
  const Skin skin = make_skin(Surface::cylinder({}, R), {0, 2 * pi}, {0, 1000});
  for (const double pitch : {0.3, 4.0, 0.8 * StepOptions{}.closing_rad * length, StepOptions{}.closing_rad * length}) {
    PlyOrientation ply{"P", {}, 0};
    for (int i = 0; i < 36; ++i)
      for (int k = 0; k < 21; ++k) {
        const double a = i * pi / 18;
        ply.points.push_back(
            {Vec3(R * std::cos(a), R * std::sin(a), 50 * k), Vec3(-std::sin(a), std::cos(a), pitch / length), 0});
      }
    const DirectionField field = make_direction_field(skin, ply, 300, 5, "");
    const SteppedPath path = step_reference_path(skin, field, {0, Uv(0.3, 500)}, StepOptions{});
    // The weighted average tilts a little more than the points: those round the bend lose length along the
    // tangent plane, not along the axis.
    const SurfacePoint start{0, Uv(0.3, 500)};
    const Vec3 asked = field.at(skin.point(start), skin.normal(start), Vec3(-std::sin(0.3), std::cos(0.3), 0)).direction;
    const double real = length * asked.z() / std::hypot(asked.x(), asked.y());
    EXPECT_EQ(path.closed, real <= StepOptions{}.closing_rad * length) << pitch;
    if (!path.closed) continue;
    // The average ripples by less than two hundredths from ply point to ply point.
    EXPECT_NEAR(path.closed_over_mm, real, 0.02 * real) << pitch;
    // Straight in the developed plane from the start to its image a turn on, so the ring at its height, but for
    // the rest of the last step, below two steps of 2 mm, and the ripple over half the 52 mm between ply points.
    for (const SteppedPoint& p : path.points) EXPECT_NEAR(p.position.z(), 500, (4 + 0.02 * 26) * real / length + 1e-6) << pitch;
    EXPECT_EQ(path.points.front().position, path.points.back().position);
    EXPECT_NEAR(path.points.back().s_mm, length, 4) << pitch;
  }
}

// Round the tube of a torus, a duct bent into a ring.
TEST(ReferencePath, ClosesRoundADuct) {
  const double r = 200;
  const Skin skin = make_skin(Surface::torus({}, 1000, r), {0, 1}, {0, 2 * pi});
  PlyOrientation ply{"P", {}, 0};
  for (int i = 0; i < 12; ++i) {
    const SurfacePoint at{0, Uv(0.5, i * pi / 6)};
    ply.points.push_back({skin.point(at), skin.derivatives(at).Sv, 0});
  }
  const DirectionField field = make_direction_field(skin, ply, 800, 5, "");
  const SteppedPath path = step_reference_path(skin, field, {0, Uv(0.5, 1)}, StepOptions{});
  EXPECT_TRUE(path.closed) << to_string(path.end[1]);
  EXPECT_NEAR(path.points.back().s_mm, 2 * pi * r, 4);
  for (const SteppedPoint& p : path.points) EXPECT_NEAR(p.at.uv.x(), 0.5, 1e-10);
}

// On a tube of 2.5 W too, and never closed.
TEST(ReferencePath, AHelixOnANarrowTubeIsNoRing) {
  const double R = 2.5 * 50.8 / (2 * pi);
  const Skin skin = make_skin(Surface::cylinder({}, R), {0, 2 * pi}, {0, 1000});
  for (const double pitch : {1.0, 30.0, 70.0}) {
    PlyOrientation ply{"P", {}, 0};
    for (int i = 0; i < 12; ++i)
      for (int k = 0; k < 21; ++k) {
        const double a = i * pi / 6;
        ply.points.push_back({Vec3(R * std::cos(a), R * std::sin(a), 50 * k),
                              Vec3(-std::sin(a), std::cos(a), pitch / (2 * pi * R)), 0});
      }
    const DirectionField field = make_direction_field(skin, ply, 300, 5, "");
    const SteppedPath path = step_reference_path(skin, field, {0, Uv(0.3, 500)}, StepOptions{});
    EXPECT_FALSE(path.closed) << pitch;
    const WalkEnd expected = pitch < 50.8 ? WalkEnd::alongside : WalkEnd::boundary;
    EXPECT_EQ(path.end[0], expected) << pitch << " " << to_string(path.end[0]);
    EXPECT_EQ(path.end[1], expected) << pitch << " " << to_string(path.end[1]);
    if (expected != WalkEnd::alongside) continue;
    // The forward walk ends after one turn, less the lead of a line at right angles to it; the backward one at once.
    double turned = 0;
    for (std::size_t i = 1; i < path.points.size(); ++i) {
      const Vec3 &q = path.points[i - 1].position, &r = path.points[i].position;
      turned += std::atan2(q.x() * r.y() - q.y() * r.x(), q.x() * r.x() + q.y() * r.y());
    }
    EXPECT_GT(turned, 2 * pi * 0.8) << pitch;
    EXPECT_LT(turned, 2 * pi * 1.05) << pitch;
  }
}

// A helix comes alongside itself after one turn when its pitch is below W, and does not when it is above.
TEST(ReferencePath, EndsWhereItComesAlongsideItself) {
  const double R = 100;
  const Skin skin = make_skin(Surface::cylinder({}, R), {0, 2 * pi}, {0, 1000});
  for (const double pitch : {30.0, 70.0}) {
    PlyOrientation ply{"P", {}, 0};
    for (int i = 0; i < 36; ++i)
      for (int k = 0; k < 5; ++k) {
        const double a = i * pi / 18;
        ply.points.push_back({Vec3(R * std::cos(a), R * std::sin(a), 200 * k + 100),
                              Vec3(-std::sin(a), std::cos(a), pitch / (2 * pi * R)), 0});
      }
    const DirectionField field = make_direction_field(skin, ply, 300, 5, "");
    const SteppedPath path = step_reference_path(skin, field, {0, Uv(0.3, 500)}, StepOptions{});
    EXPECT_FALSE(path.closed);
    const WalkEnd expected = pitch < 50.8 ? WalkEnd::alongside : WalkEnd::boundary;
    EXPECT_EQ(path.end[0], expected) << pitch;
    EXPECT_EQ(path.end[1], expected) << pitch;
  }
}

// Steps that found no ply point in range are counted: points cover the left half only.
TEST(ReferencePath, CountsTheStepsWithoutAPlyPointInRange) {
  const Skin skin = make_skin(Surface::plane({}), {0, 1000}, {0, 600});
  std::vector<OrientationPoint> points;
  for (int i = 0; i <= 10; ++i) points.push_back({Vec3(50 * i, 300, 0), Vec3(1, 0, 0), Vec3::UnitZ()});
  const SteppedPath path =
      step_reference_path(skin, DirectionField(points, 51), {0, Uv(500, 300)}, steps_of(2));
  // The last point in range lies 51 before x = 551; half a step ahead is asked too: 1 step of about 225 of
  // doubt.
  EXPECT_NEAR(static_cast<double>(path.doubled), (1000 - 551) / 2.0, 2);
  EXPECT_NEAR(static_cast<double>(path.steps), 500, 2);
}

// Directions that turn against each other: the path ends there and says so.
TEST(ReferencePath, EndsWhereTheDirectionsCancel) {
  const Skin skin = make_skin(Surface::plane({}), {-300, 300}, {-300, 300});
  // Nothing but the normal is asked for beyond x = 100.
  const DirectionField field(
      {{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3::UnitZ()}, {Vec3(200, 0, 0), Vec3(0, 0, 1), Vec3::UnitZ()}}, 99);
  const SteppedPath path = step_reference_path(skin, field, {0, Uv(-50, 0)}, steps_of(2));
  EXPECT_EQ(path.end[1], WalkEnd::singular_field);
  EXPECT_NEAR(path.points.back().position.x(), 101, 3);
  for (const SteppedPoint& p : path.points) EXPECT_TRUE(p.position.allFinite());
  // From a start without any direction there is no path, and no NaN.
  const SteppedPath none = step_reference_path(skin, field, {0, Uv(200, 0)}, steps_of(2));
  EXPECT_EQ(none.points.size(), 1u);
  EXPECT_EQ(none.end[0], WalkEnd::singular_field);
}

// Holes are walked over: the path goes on beyond, on the surface that was cut away.
TEST(ReferencePath, WalksOverAHole) {
  Part part = make_rectangular_part(Surface::plane({}), {0, 400}, {0, 300});
  Loop hole;
  const Uv corner[4] = {{150, 100}, {150, 200}, {250, 200}, {250, 100}};  // clockwise
  for (int i = 0; i < 4; ++i) {
    hole.coedges.push_back(
        {line_segment(corner[i], corner[(i + 1) % 4]), false, static_cast<int>(part.edges.size())});
    part.edges.push_back({});
  }
  part.faces[0].loops.push_back(hole);
  const Skin skin(std::make_shared<const Part>(part), {0});
  const DirectionField field({{Vec3(10, 150, 0), Vec3(1, 0, 0), Vec3::UnitZ()}}, 1e4);
  const SteppedPath path = step_reference_path(skin, field, {0, Uv(50, 150)}, steps_of(2));
  EXPECT_EQ(path.end[1], WalkEnd::boundary);
  EXPECT_NEAR(path.points.back().position.x(), 400, 2);
  for (const SteppedPoint& p : path.points) EXPECT_NEAR(p.position.y(), 150, 1e-12);
}

}  // namespace
}  // namespace afptraj
