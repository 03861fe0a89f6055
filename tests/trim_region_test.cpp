// Laws (T1) to (T3) of geometry/trim_region.h.
#include "geometry/trim_region.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "geometry/surface.h"

namespace afptraj {
namespace {

using Polygon = std::vector<Uv>;
using Random = std::mt19937;

double uniform(Random& random, double lo, double hi) {
  return std::uniform_real_distribution<double>(lo, hi)(random);
}

Loop polygon_loop(const Polygon& polygon) {
  Loop loop;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    loop.coedges.push_back(
        {line_segment(polygon[i], polygon[(i + 1) % polygon.size()]), false, static_cast<int>(i)});
  }
  return loop;
}

Face face_of(std::vector<Loop> loops) {
  return Face{Surface::plane(Frame{}), false, std::move(loops), {}, {}, 0};
}

/// A star-shaped polygon about `centre`: anticlockwise, or clockwise as a hole.
Polygon star(Random& random, const Uv& centre, double least, double most, int count, bool clockwise) {
  Polygon polygon;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * pi * (clockwise ? -i : i) / count;
    polygon.push_back(centre + uniform(random, least, most) * Uv(std::cos(angle), std::sin(angle)));
  }
  return polygon;
}

/// Crossing number in extended precision; what (T1) must equal away from the edges.
bool inside(const std::vector<Polygon>& polygons, const Uv& p) {
  bool in = false;
  for (const Polygon& polygon : polygons) {
    for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
      const Uv &a = polygon[i], &b = polygon[j];
      if ((a.y() > p.y()) == (b.y() > p.y())) continue;
      const long double x = (static_cast<long double>(b.x()) - a.x()) *
                                (static_cast<long double>(p.y()) - a.y()) /
                                (static_cast<long double>(b.y()) - a.y()) +
                            a.x();
      if (p.x() < x) in = !in;
    }
  }
  return in;
}

/// A full circle (ellipse after scaling) as a rational quadratic with 9 poles.
BSplineCurve2 circle(const Uv& centre, const Uv& radius, bool clockwise = false) {
  const double w = std::sqrt(0.5);
  const double x[9] = {1, 1, 0, -1, -1, -1, 0, 1, 1};
  const double y[9] = {0, 1, 1, 1, 0, -1, -1, -1, 0};
  BSplineCurve2 curve;
  curve.degree = 2;
  curve.knots = {0, 0, 0, 0.25, 0.25, 0.5, 0.5, 0.75, 0.75, 1, 1, 1};
  for (int i = 0; i < 9; ++i) {
    curve.poles.push_back(centre + radius.cwiseProduct(Uv(x[i], clockwise ? -y[i] : y[i])));
    curve.weights.push_back(i % 2 == 0 ? 1 : w);
  }
  return curve;
}

Loop one_curve(BSplineCurve2 curve, bool reversed = false) {
  Loop loop;
  loop.coedges.push_back({std::move(curve), reversed, 0});
  return loop;
}

UvCubic random_path(Random& random, const Uv& centre, double reach) {
  const auto point = [&] {
    return Uv(centre + Uv(uniform(random, -reach, reach), uniform(random, -reach, reach)));
  };
  return UvCubic::hermite(point(), 3 * (point() - centre), point(), 3 * (point() - centre));
}

/// (T2) and (T3) for one path.
void expect_laws(const TrimRegion& region, const Face& face, const UvCubic& path, double size) {
  const std::vector<LoopCrossing> found = region.crossings(path);
  bool state = region.contains(path.point(0));
  double before = 0;
  for (const LoopCrossing& c : found) {
    EXPECT_EQ(c.outward, state);
    EXPECT_GE(c.x, before);
    EXPECT_LE(c.x, 1);
    before = c.x;
    const Coedge& coedge =
        face.loops[static_cast<std::size_t>(c.loop)].coedges[static_cast<std::size_t>(c.coedge)];
    EXPECT_EQ(coedge.pcurve.point(c.t), c.uv);
    EXPECT_LE((path.point(c.x) - c.uv).norm(), 1e-12 * size);
    state = !state;
  }
  EXPECT_EQ(state, region.contains(path.point(1)));
  for (const bool outward : {true, false}) {
    const auto first = region.first_crossing(path, outward);
    const auto same =
        std::find_if(found.begin(), found.end(), [&](const auto& c) { return c.outward == outward; });
    ASSERT_EQ(first.has_value(), same != found.end());
    if (first) {
      EXPECT_EQ(first->x, same->x);
    }
  }
}

TEST(TrimRegion, StarsWithHolesAgreeWithCrossingNumbers) {
  Random random(1);
  for (int round = 0; round < 60; ++round) {
    const std::vector<Polygon> polygons = {star(random, Uv(0, 0), 0.8, 2, 3 + 4 * round, false),
                                           star(random, Uv(0.2, 0.1), 0.1, 0.4, 3 + round, true)};
    const Face face = face_of({polygon_loop(polygons[0]), polygon_loop(polygons[1])});
    const TrimRegion region(face);
    for (int i = 0; i < 2000; ++i) {
      const Uv p(uniform(random, -2.1, 2.1), uniform(random, -2.1, 2.1));
      ASSERT_EQ(region.contains(p), inside(polygons, p)) << p.transpose();
    }
    for (const Polygon& polygon : polygons) {
      for (std::size_t i = 0; i < polygon.size(); ++i) {
        EXPECT_TRUE(region.contains(polygon[i]));
        EXPECT_TRUE(region.contains(0.5 * (polygon[i] + polygon[(i + 1) % polygon.size()])));
      }
    }
    for (int i = 0; i < 200; ++i) expect_laws(region, face, random_path(random, Uv(0, 0), 2.2), 4);
  }
}

// The line through a vertex meets two coedges in one point; touching a corner is no crossing.
TEST(TrimRegion, PathsThroughVerticesCrossOnce) {
  const Polygon diamond = {Uv(0, -1), Uv(1, 0), Uv(0, 1), Uv(-1, 0)};
  const Face face = face_of({polygon_loop(diamond)});
  const TrimRegion region(face);
  EXPECT_EQ(region.crossings(UvCubic::line(Uv(-2, 0), Uv(2, 0))).size(), 2u);
  EXPECT_EQ(region.crossings(UvCubic::line(Uv(0, -2), Uv(0, 2))).size(), 2u);
  EXPECT_EQ(region.crossings(UvCubic::line(Uv(1, -2), Uv(1, 2))).size(), 0u);
  EXPECT_EQ(region.crossings(UvCubic::line(Uv(0, 0), Uv(1, 0))).size(), 0u);  // ends on the loop
  EXPECT_EQ(region.crossings(UvCubic::line(Uv(1, 0), Uv(0, 0))).size(), 0u);  // begins on it, inward
  const auto out = region.crossings(UvCubic::line(Uv(1, 0), Uv(2, 0)));       // begins on it, outward
  ASSERT_EQ(out.size(), 1u);
  EXPECT_TRUE(out[0].outward);
  EXPECT_LE(out[0].x, 1e-12);
  Random random(2);
  for (int i = 0; i < 3000; ++i) {
    const Uv vertex = diamond[static_cast<std::size_t>(i % 4)];
    const Uv d(uniform(random, -3, 3), uniform(random, -3, 3));
    expect_laws(region, face, UvCubic::line(vertex - d, vertex + 1.5 * d), 2);
  }
}

// A path along an edge is on the loop, hence inside; where it goes on beyond the edge it leaves.
TEST(TrimRegion, PathsAlongAnEdge) {
  const Face face = face_of({polygon_loop({Uv(0, 0), Uv(3, 0), Uv(3, 1), Uv(0, 1)})});
  const TrimRegion region(face);
  EXPECT_TRUE(region.crossings(UvCubic::line(Uv(0.5, 0), Uv(2.5, 0))).empty());
  const auto through = region.crossings(UvCubic::line(Uv(-1, 0), Uv(4, 0)));
  ASSERT_EQ(through.size(), 2u);
  EXPECT_FALSE(through[0].outward);
  EXPECT_TRUE(through[1].outward);
  EXPECT_NEAR(through[0].x, 0.2, 1e-12);
  EXPECT_NEAR(through[1].x, 0.8, 1e-12);
  // Leaves the edge tangentially: v = -x^3 from the middle of the edge on.
  const auto leaving = region.crossings(UvCubic{Uv(1, 0), Uv(1, 0), Uv(0, 0), Uv(0, -1)});
  ASSERT_EQ(leaving.size(), 1u);
  EXPECT_TRUE(leaving[0].outward);
  // On the loop to 1e-13 x 4 (size of the scaled box): x^3 <= 4e-13, so x <= 1e-4.
  EXPECT_LE(leaving[0].x, 1e-4);
}

// The band between chord and curve is decided by the curve: distances far below the chord error.
TEST(TrimRegion, CirclesAreExactWithinTheChordError) {
  Random random(3);
  for (const double scale_u : {1.0, 1e-7, 3e6}) {
    for (const double scale_v : {1.0, 2e5}) {
      const Uv radius(scale_u, scale_v), hole(0.3 * scale_u, 0.3 * scale_v);
      const Uv centre(2 * scale_u, -0.5 * scale_v);
      const Face face =
          face_of({one_curve(circle(centre, radius, true), true), one_curve(circle(centre, hole, true))});
      const TrimRegion region(face, 1e-4);
      for (int i = 0; i < 4000; ++i) {
        const double angle = uniform(random, 0, 2 * pi);
        const double delta = std::pow(10, uniform(random, -11, -3)) * (i % 2 == 0 ? 1 : -1);
        const Uv direction(std::cos(angle), std::sin(angle));
        // Rounding of the centre (2 x scale) is 4e-16, of the curve 1e-15: 1e-11 is safely beyond.
        EXPECT_EQ(region.contains(centre + (1 + delta) * radius.cwiseProduct(direction)), delta < 0);
        EXPECT_EQ(region.contains(centre + (0.3 + delta) * radius.cwiseProduct(direction)), delta > 0);
      }
      for (int i = 0; i <= 1000; ++i) {
        EXPECT_TRUE(region.contains(face.loops[0].coedges[0].pcurve.point(i / 1000.0)));
      }
    }
  }
}

// On the unit circle |path(x)|^2 = 1 is a polynomial whose roots can be counted by itself.
TEST(TrimRegion, CubicsThroughACircle) {
  Random random(4);
  const Face face = face_of({one_curve(circle(Uv(0, 0), Uv(1, 1)))});
  const TrimRegion region(face);
  int crossings = 0;
  for (int round = 0; round < 4000; ++round) {
    const UvCubic path = random_path(random, Uv(0, 0), 1.5);
    expect_laws(region, face, path, 2);
    std::vector<double> roots;
    constexpr int count = 4000;
    bool graze = false;
    double last = path.point(0).squaredNorm() - 1;
    for (int i = 1; i <= count; ++i) {
      const double here = path.point(i / static_cast<double>(count)).squaredNorm() - 1;
      graze |= std::abs(here) < 1e-5 && std::abs(last) < 1e-5;
      if ((here > 0) != (last > 0)) roots.push_back((i - 0.5) / count);
      last = here;
    }
    if (graze) continue;  // two roots may hide between samples
    const auto found = region.crossings(path);
    ASSERT_EQ(found.size(), roots.size());
    for (std::size_t i = 0; i < roots.size(); ++i) EXPECT_NEAR(found[i].x, roots[i], 0.6 / count);
    for (const LoopCrossing& c : found) EXPECT_NEAR(path.point(c.x).norm(), 1, 1e-13);
    crossings += static_cast<int>(found.size());
  }
  EXPECT_GT(crossings, 4000);
}

// Tangent to the circle from either side, and 1e-9 to each side of tangency.
TEST(TrimRegion, GrazingPaths) {
  const Face face = face_of({one_curve(circle(Uv(0, 0), Uv(1, 1)))});
  const TrimRegion region(face);
  for (int i = 0; i < 360; ++i) {
    const double angle = i * pi / 180;
    const Uv n(std::cos(angle), std::sin(angle)), t(-n.y(), n.x());
    const auto line = [&](double height) { return UvCubic::line(height * n - t, height * n + 1.3 * t); };
    EXPECT_EQ(region.crossings(line(1 + 1e-9)).size(), 0u);
    const auto pair = region.crossings(line(1 - 1e-9));
    ASSERT_EQ(pair.size(), 2u);
    // Half chord sqrt(2e-9) to 1e-6 of itself: rounding 1e-15 over slope 4e-5 is 2e-11.
    EXPECT_NEAR((pair[1].x - pair[0].x) * 2.3, 2 * std::sqrt(2e-9), 1e-9);
    expect_laws(region, face, line(1), 2);
    // A parabola that touches from inside: n-component 1 - x'^2 with x' about the middle.
    const UvCubic inner{0.0 * n - t, 4.0 * n + 2 * t, -4.0 * n, Uv::Zero()};
    expect_laws(region, face, inner, 2);
  }
}

/// A closed cubic spline through random radii: a loop of several curved coedges.
Loop spline_loop(Random& random, const Uv& centre, double radius, int count) {
  std::vector<Uv> at, slope;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * pi * i / count;
    at.push_back(centre + radius * uniform(random, 0.7, 1.3) * Uv(std::cos(angle), std::sin(angle)));
  }
  const auto n = static_cast<std::size_t>(count);
  Loop loop;
  for (std::size_t i = 0; i < n; ++i) {
    const Uv before = (at[(i + 1) % n] - at[(i + n - 1) % n]) / 6, after = (at[(i + 2) % n] - at[i]) / 6;
    BSplineCurve2 c;
    c.degree = 3;
    c.knots = {0, 0, 0, 0, 2, 2, 2, 2};
    c.poles = {at[i], at[i] + before, at[(i + 1) % n] - after, at[(i + 1) % n]};
    const bool reversed = i % 2 == 1;
    if (reversed) std::reverse(c.poles.begin(), c.poles.end());
    loop.coedges.push_back({c, reversed, static_cast<int>(i)});
  }
  return loop;
}

TEST(TrimRegion, SplineLoopsAgreeWithFinePolygons) {
  Random random(5);
  for (int round = 0; round < 20; ++round) {
    const Face face = face_of({spline_loop(random, Uv(5, 5), 3, 5 + round)});
    Polygon fine;
    for (const Coedge& coedge : face.loops[0].coedges) {
      for (int i = 0; i < 2000; ++i)
        fine.push_back(coedge.pcurve.point(coedge.reversed ? 2 - i / 1000.0 : i / 1000.0));
    }
    const TrimRegion region(face, 1e-3);
    for (int i = 0; i < 300; ++i) {
      // Half of the points close to the loop, yet farther than the fine polygon's chord error 1e-6.
      Uv p(uniform(random, 0.5, 9.5), uniform(random, 0.5, 9.5));
      const auto vertex = static_cast<std::size_t>(uniform(random, 0, static_cast<double>(fine.size() - 1)));
      if (i % 2 == 0) p = fine[vertex] + Uv(uniform(random, -1e-4, 1e-4), uniform(random, -1e-4, 1e-4));
      const LoopCrossing near = region.nearest(p, Eigen::Matrix2d::Identity());
      if ((near.uv - p).norm() < 3e-6) continue;
      ASSERT_EQ(region.contains(p), inside({fine}, p));
    }
    for (int i = 0; i < 200; ++i) expect_laws(region, face, random_path(random, Uv(5, 5), 5), 8);
  }
}

TEST(TrimRegion, NearestAgreesWithDenseSampling) {
  Random random(6);
  const Face face = face_of({spline_loop(random, Uv(0, 0), 2, 7)});
  const TrimRegion region(face);
  const Eigen::Matrix2d metric = (Eigen::Matrix2d() << 4, 1, 1, 2).finished();
  for (int i = 0; i < 300; ++i) {
    const Uv p(uniform(random, -4, 4), uniform(random, -4, 4));
    const auto distance = [&](const Uv& q) { return std::sqrt((q - p).dot(metric * (q - p))); };
    double best = 1e9;
    for (const Coedge& coedge : face.loops[0].coedges) {
      for (int k = 0; k <= 2000; ++k) best = std::min(best, distance(coedge.pcurve.point(k / 1000.0)));
    }
    const LoopCrossing near = region.nearest(p, metric);
    EXPECT_LE(distance(near.uv), best + 1e-12);
    EXPECT_GE(distance(near.uv), best - 1e-3);
  }
}

// The rectangle of a whole cylinder: both sides of the seam bound it like any other coedge.
TEST(TrimRegion, SeamsAndPolesAreOrdinarySides) {
  for (const Surface& surface : {Surface::cylinder(Frame{}, 50), Surface::sphere(Frame{}, 50)}) {
    const Part part = make_rectangular_part(surface, {0, 2 * pi}, {-pi / 2, pi / 2});
    const Face& face = part.faces[0];
    const TrimRegion region(face);
    EXPECT_EQ(region.box_min(), Uv(0, -pi / 2));
    EXPECT_EQ(region.box_max(), Uv(2 * pi, pi / 2));
    const auto seam = region.first_crossing(UvCubic::line(Uv(6, 0), Uv(6.6, 0.3)), true);
    ASSERT_TRUE(seam);
    EXPECT_EQ(seam->coedge, 1);
    EXPECT_DOUBLE_EQ(seam->uv.x(), 2 * pi);
    EXPECT_NEAR(seam->t, (2 * pi - 6) / 2, 1e-15);
    const Coedge& mate = face.loops[0].coedges[3];
    EXPECT_EQ(mate.edge, face.loops[0].coedges[1].edge);
    EXPECT_LE((surface.point(mate.pcurve.point(seam->t)) - surface.point(seam->uv)).norm(), 1e-12);
    const auto top = region.first_crossing(UvCubic::line(Uv(1, 1), Uv(1, 2)), true);
    ASSERT_TRUE(top);
    EXPECT_EQ(top->coedge, 2);
    EXPECT_EQ(region.classify(Uv(1, -1), Uv(2, 1)), TrimRegion::BoxState::inside);
    EXPECT_EQ(region.classify(Uv(6, -1), Uv(7, 1)), TrimRegion::BoxState::mixed);
    EXPECT_EQ(region.classify(Uv(8, -1), Uv(9, 1)), TrimRegion::BoxState::outside);
    Random random(7);
    for (int i = 0; i < 2000; ++i) expect_laws(region, face, random_path(random, Uv(3, 0), 5), 2 * pi);
  }
}

TEST(TrimRegion, RefusesAFaceWithoutLoops) {
  EXPECT_THROW(TrimRegion(face_of({})), std::invalid_argument);
  EXPECT_THROW(TrimRegion(face_of({Loop{}})), std::invalid_argument);
}

}  // namespace
}  // namespace afptraj
