// Law (C1) of geometry/closest_point.h: nothing is nearer than the point returned.
#include "geometry/closest_point.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "geometry/curvature.h"

namespace afptraj {
namespace {

using Random = std::mt19937;
double uniform(Random& random, double lo, double hi) {
  return std::uniform_real_distribution<double>(lo, hi)(random);
}
Vec3 random_point(Random& random, double reach) {
  return {uniform(random, -reach, reach), uniform(random, -reach, reach), uniform(random, -reach, reach)};
}

Frame tilted_frame() {
  Frame f;
  f.origin = Vec3(10, -20, 5);
  f.x = Vec3(1, 2, 2) / 3;
  f.y = Vec3(2, 1, -2) / 3;
  f.z = f.x.cross(f.y);
  return f;
}

/// A clamped B-spline height field over [0, 100]^2 with random heights, bent poles included.
BSplineSurface bumpy(Random& random, int count, double height, bool rational) {
  BSplineSurface s;
  s.degree_u = s.degree_v = 3;
  const auto knots = [&] {
    std::vector<double> k(4, 0.0);
    for (int i = 1; i < count - 3; ++i) k.push_back(static_cast<double>(i) / (count - 3));
    k.insert(k.end(), 4, 1.0);
    return k;
  };
  s.knots_u = s.knots_v = knots();
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < count; ++j) {
      s.poles.emplace_back(100.0 * i / (count - 1), 100.0 * j / (count - 1),
                           uniform(random, -height, height));
      if (rational) s.weights.push_back(uniform(random, 0.5, 2));
    }
  }
  return s;
}

struct Specimen {
  std::shared_ptr<const Part> part;
  std::vector<std::shared_ptr<const TrimRegion>> trim;
  explicit Specimen(Part p) : part(std::make_shared<const Part>(std::move(p))) {
    for (const Face& face : part->faces) trim.push_back(std::make_shared<const TrimRegion>(face));
  }
  ClosestPointFinder finder() const { return {part, {}, trim}; }
};

void add_circular_hole(Part& part, const Uv& centre, const Uv& radius) {
  const double w = std::sqrt(0.5);
  const double x[9] = {1, 1, 0, -1, -1, -1, 0, 1, 1}, y[9] = {0, -1, -1, -1, 0, 1, 1, 1, 0};
  BSplineCurve2 curve;
  curve.degree = 2;
  curve.knots = {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4};
  for (int i = 0; i < 9; ++i) {
    curve.poles.push_back(centre + radius.cwiseProduct(Uv(x[i], y[i])));
    curve.weights.push_back(i % 2 == 0 ? 1 : w);
  }
  Loop loop;
  loop.coedges.push_back({curve, false, static_cast<int>(part.edges.size())});
  part.edges.push_back(Edge{});
  part.faces[0].loops.push_back(loop);
}

/// Brute force: a grid of samples inside the loops and along them, then a pattern search from the
/// best few that halves its step down to 1e-9 of the domain. Never nearer than the truth.
class BruteForce {
 public:
  explicit BruteForce(const Specimen& specimen, int count = 120) : specimen_(specimen) {
    for (std::size_t f = 0; f < specimen.part->faces.size(); ++f) {
      const TrimRegion& trim = *specimen.trim[f];
      const Face& face = specimen.part->faces[f];
      const Uv lo = trim.box_min(), size = trim.box_max() - lo;
      for (int i = 0; i <= count; ++i) {
        for (int j = 0; j <= count; ++j) {
          const Uv uv = lo + Uv(size.x() * i / count, size.y() * j / count);
          if (trim.contains(uv)) samples_.push_back({static_cast<int>(f), uv, face.surface.point(uv)});
        }
      }
      for (const Loop& loop : face.loops) {
        for (const Coedge& coedge : loop.coedges) {
          for (int i = 0; i <= 20 * count; ++i) {
            const double t0 = coedge.pcurve.first(), t1 = coedge.pcurve.last();
            const Uv uv = coedge.pcurve.point(t0 + (t1 - t0) * i / (20 * count));
            samples_.push_back({static_cast<int>(f), uv, face.surface.point(uv)});
          }
        }
      }
    }
  }

  double distance(const Vec3& p) const {
    constexpr std::size_t starts = 6;
    std::vector<std::pair<double, std::size_t>> order(samples_.size());
    for (std::size_t i = 0; i < samples_.size(); ++i) order[i] = {(samples_[i].point - p).squaredNorm(), i};
    const std::size_t n = std::min(starts, order.size());
    std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(n), order.end());
    double best = std::sqrt(order[0].first);
    for (std::size_t k = 0; k < n; ++k) best = std::min(best, refine(samples_[order[k].second], p));
    return best;
  }

 private:
  struct Sample {
    int face;
    Uv uv;
    Vec3 point;
  };
  double refine(const Sample& start, const Vec3& p) const {
    const Surface& surface = specimen_.part->faces[static_cast<std::size_t>(start.face)].surface;
    const TrimRegion& trim = *specimen_.trim[static_cast<std::size_t>(start.face)];
    Uv uv = start.uv, step = (trim.box_max() - trim.box_min()) / 120;
    double best = (start.point - p).norm();
    for (int level = 0; level < 34; ++level, step /= 2) {
      for (bool moved = true; moved;) {
        moved = false;
        for (int k = 0; k < 8; ++k) {
          const double angle = k * pi / 4;
          const Uv next = uv + step.cwiseProduct(Uv(std::cos(angle), std::sin(angle)));
          if (!trim.contains(next)) continue;
          const double d = (surface.point(next) - p).norm();
          if (d >= best - 1e-14) continue;
          best = d;
          uv = next;
          moved = true;
        }
      }
    }
    return best;
  }
  const Specimen& specimen_;
  std::vector<Sample> samples_;
};

void expect_nearest(const Specimen& specimen, const ClosestPointFinder& finder, const BruteForce& brute,
                    const Vec3& p) {
  const auto found = finder.closest(p);
  ASSERT_TRUE(found);
  const auto f = static_cast<std::size_t>(found->at.face);
  EXPECT_LE((specimen.part->faces[f].surface.point(found->at.uv) - found->point).norm(), 1e-10);
  EXPECT_DOUBLE_EQ((found->point - p).norm(), found->distance_mm);
  EXPECT_TRUE(specimen.trim[f]->contains(found->at.uv)) << found->at.uv.transpose();
  ASSERT_LE(found->distance_mm, brute.distance(p) + 1e-9)
      << "p " << p.transpose() << " uv " << found->at.uv.transpose()
      << (found->on_boundary ? " boundary" : " foot");
}

void expect_nearest(const Specimen& specimen, double reach, const Vec3& centre, int count, unsigned seed) {
  Random random(seed);
  const ClosestPointFinder finder = specimen.finder();
  const BruteForce brute(specimen);
  for (int i = 0; i < count; ++i)
    expect_nearest(specimen, finder, brute, centre + random_point(random, reach));
}

TEST(ClosestPoint, AnalyticFacesAgainstBruteForce) {
  const Frame frame = tilted_frame();
  struct Case {
    Surface surface;
    Interval u, v;
  };
  const std::vector<Case> cases = {
      {Surface::plane(frame), {-30, 40}, {-10, 60}},
      {Surface::cylinder(frame, 30), {0.3, 2.8}, {-40, 50}},
      {Surface::cylinder(frame, 30), {0, 2 * pi}, {-40, 50}},
      {Surface::cone(frame, 30, 0.4), {-1, 3}, {-30, 50}},
      {Surface::cone(frame, 30, 0.4), {0, 2 * pi}, {-30 / std::sin(0.4), 10}},
      {Surface::cone(frame, 30, -0.7), {0, 2 * pi}, {0, 30 / std::sin(0.7)}},
      {Surface::sphere(frame, 40), {1, 4}, {-0.5, 1.2}},
      {Surface::sphere(frame, 40), {0, 2 * pi}, {0.2, pi / 2}},
      {Surface::sphere(frame, 40), {0, 2 * pi}, {-pi / 2, pi / 2}},
      {Surface::torus(frame, 40, 12), {0.2, 4}, {-1, 2}},
      {Surface::torus(frame, 40, 12), {0, 2 * pi}, {0, 2 * pi}},
  };
  for (const Case& c : cases) {
    Part part = make_rectangular_part(c.surface, c.u, c.v);
    expect_nearest(Specimen(part), 90, frame.origin, 60, 1);
    const Uv middle(0.5 * (c.u.lo + c.u.hi), 0.5 * (c.v.lo + c.v.hi));
    add_circular_hole(part, middle, Uv(0.2 * c.u.length(), 0.3 * c.v.length()));
    expect_nearest(Specimen(part), 90, frame.origin, 40, 2);
  }
}

// On axes and centres many points are nearest; one of them must be found.
TEST(ClosestPoint, PointsOnAxesPolesAndCentres) {
  const Frame frame;
  const std::vector<Part> parts = {
      make_rectangular_part(Surface::cylinder(frame, 30), {0.3, 2.8}, {-40, 50}),
      make_rectangular_part(Surface::cone(frame, 30, 0.4), {1, 5}, {-30 / std::sin(0.4), 10}),
      make_rectangular_part(Surface::sphere(frame, 40), {2, 4}, {-0.3, pi / 2}),
      make_rectangular_part(Surface::sphere(frame, 40), {0, 2 * pi}, {-pi / 2, pi / 2}),
      make_rectangular_part(Surface::torus(frame, 40, 12), {1, 4}, {0, 2 * pi})};
  for (const Part& part : parts) {
    const Specimen specimen(part);
    const ClosestPointFinder finder = specimen.finder();
    const BruteForce brute(specimen);
    for (const double z : {-100.0, -75.0, -41.0, -40.0, -1.0, 0.0, 7.0, 40.0, 40.5, 90.0}) {
      expect_nearest(specimen, finder, brute, Vec3(0, 0, z));
      expect_nearest(specimen, finder, brute, Vec3(1e-13, 0, z));
      expect_nearest(specimen, finder, brute, Vec3(40, 0, z));
    }
  }
  const Specimen sphere(parts[3]);
  const auto pole = sphere.finder().closest(Vec3(0, 0, 55));
  EXPECT_NEAR(pole->distance_mm, 15, 1e-12);
  EXPECT_NEAR(pole->at.uv.y(), pi / 2, 1e-15);
}

TEST(ClosestPoint, RandomBicubicsAgainstBruteForce) {
  Random random(3);
  for (int round = 0; round < 24; ++round) {
    const double height = round % 3 == 0 ? 5 : round % 3 == 1 ? 25 : 60;
    const Surface surface = Surface::bspline(bumpy(random, 4 + round % 5, height, round % 2 == 1));
    Part part = make_rectangular_part(surface, {0, 1}, {0, 1});
    if (round >= 8) add_circular_hole(part, Uv(0.45, 0.55), Uv(0.3, 0.2));
    const Specimen specimen(part);
    expect_nearest(specimen, 90, Vec3(50, 50, 0), 40, static_cast<unsigned>(round));
    // Near the surface, at distances about its radius of curvature: many feet.
    expect_nearest(specimen, 30, Vec3(50, 50, 20), 40, static_cast<unsigned>(100 + round));
  }
}

/// A ball of radius R as one rational biquadratic with two poles.
BSplineSurface nurbs_sphere(double R) {
  const double w = std::sqrt(0.5);
  const double cx[9] = {1, 1, 0, -1, -1, -1, 0, 1, 1}, cy[9] = {0, 1, 1, 1, 0, -1, -1, -1, 0};
  const double rho[5] = {0, 1, 1, 1, 0}, z[5] = {-1, -1, 0, 1, 1};
  BSplineSurface s;
  s.degree_u = s.degree_v = 2;
  s.knots_u = {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4};
  s.knots_v = {0, 0, 0, 1, 1, 2, 2, 2};
  for (int i = 0; i < 9; ++i) {
    for (int j = 0; j < 5; ++j) {
      s.poles.emplace_back(R * rho[j] * cx[i], R * rho[j] * cy[i], R * z[j]);
      s.weights.push_back((i % 2 == 0 ? 1 : w) * (j % 2 == 0 ? 1 : w));
    }
  }
  s.periodic_u = true;
  return s;
}

TEST(ClosestPoint, SplineSphereWithPolesAndSeam) {
  const double R = 40;
  const Part part = make_rectangular_part(Surface::bspline(nurbs_sphere(R)), {0, 4}, {0, 2});
  EXPECT_TRUE(part.edges[0].degenerate);
  EXPECT_EQ(part.edges.size(), 3u);
  const Specimen specimen(part);
  const ClosestPointFinder finder = specimen.finder();
  Random random(4);
  for (int i = 0; i < 3000; ++i) {
    Vec3 p = random_point(random, 80);
    if (i % 3 == 0) p.head<2>() *= std::pow(10, uniform(random, -14, -1));  // about the axis
    if (i % 5 == 0) p.y() = 0;                                              // about the seam
    if (p.norm() < 1) continue;
    const auto found = finder.closest(p);
    ASSERT_TRUE(found);
    // The distance of the sphere is known; its NURBS form is exact to rounding.
    EXPECT_NEAR(found->distance_mm, std::abs(p.norm() - R), 1e-9) << p.transpose();
    // A point x beside the foot is farther by x^2 (1/R + 1/|p - foot|)/2 at least; ties within 1e-10 mm
    // may go to the pole or the seam: x <= sqrt(2 R 1e-10).
    EXPECT_LE((found->point - R * p.normalized()).norm(), std::sqrt(2 * R * 1e-10)) << p.transpose();
  }
}

// A saddle-like strip on which the foot of a perpendicular exists, yet an edge is nearer: a search
// for feet alone returns the larger distance.
TEST(ClosestPoint, AnEdgeMayBeNearerThanTheFoot) {
  // A quarter of a cylinder wall seen from beyond its axis: the foot is at distance 30 + 12, the
  // edges at sqrt(30^2 + 12^2 + 2*30*12*cos 45) = 39.4.
  const Part part = make_rectangular_part(Surface::cylinder(Frame{}, 30), {0, pi / 2}, {-50, 50});
  BSplineSurface s;  // the same arc as a spline
  s.degree_u = 2;
  s.degree_v = 1;
  s.knots_u = {0, 0, 0, 1, 1, 1};
  s.knots_v = {0, 0, 1, 1};
  for (int i = 0; i < 3; ++i) {
    for (const double z : {-50.0, 50.0}) {
      s.poles.emplace_back(i < 2 ? 30 : 0, i > 0 ? 30 : 0, z);
      s.weights.push_back(i == 1 ? std::sqrt(0.5) : 1);
    }
  }
  const double c = std::sqrt(0.5);
  const Vec3 p(-12 * c, -12 * c, 3);
  const double edge = std::sqrt(30.0 * 30 + 12 * 12 + 2 * 30 * 12 * c);
  for (const Part& each : {part, make_rectangular_part(Surface::bspline(s), {0, 1}, {0, 1})}) {
    const Specimen specimen(each);
    const auto found = specimen.finder().closest(p);
    ASSERT_TRUE(found);
    EXPECT_TRUE(found->on_boundary);
    EXPECT_NEAR(found->distance_mm, edge, 1e-10);
  }
}

// A roof: the ridge is a crease of the surface, neither a foot nor a trim loop.
TEST(ClosestPoint, CreasesInsideAFace) {
  BSplineSurface s;
  s.degree_u = 1;
  s.degree_v = 1;
  s.knots_u = {0, 0, 1, 2, 2};
  s.knots_v = {0, 0, 1, 1};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 2; ++j) s.poles.emplace_back(50 * i, 80 * j, i == 1 ? 40 : 0);
  }
  const Specimen specimen(make_rectangular_part(Surface::bspline(s), {0, 2}, {0, 1}));
  const auto found = specimen.finder().closest(Vec3(50, 33, 60));
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->distance_mm, 20, 1e-12);
  EXPECT_FALSE(found->on_boundary);
  expect_nearest(specimen, 80, Vec3(50, 40, 20), 60, 5);
}

TEST(ClosestPoint, LimitFacingAndFeet) {
  const Part part = make_rectangular_part(Surface::cylinder(Frame{}, 30), {0, 2 * pi}, {-50, 50});
  const Specimen specimen(part);
  const ClosestPointFinder finder = specimen.finder();
  EXPECT_FALSE(finder.closest(Vec3(40, 0, 0), 9.999));
  const auto foot = finder.closest(Vec3(40, 0, 0), 10.001);
  ASSERT_TRUE(foot);
  EXPECT_FALSE(foot->on_boundary);  // though it lies on the seam
  const Vec3 out(1, 0, 0);
  EXPECT_NEAR(finder.closest(Vec3(25, 0, 0), 1e9, &out)->point.x(), 30, 1e-12);
  const Vec3 in(-1, 0, 0);
  const auto other = finder.closest(Vec3(25, 0, 0), 1e9, &in);
  EXPECT_TRUE(!other || other->point.x() <= 1e-9);
  EXPECT_FALSE(finder.closest(Vec3(std::nan(""), 0, 0)));
}

// foot_point converges from a neighbour to rounding, and says so when there is no foot.
TEST(ClosestPoint, FootPoint) {
  Random random(6);
  const Surface surface = Surface::bspline(bumpy(random, 8, 10, false));
  for (int i = 0; i < 2000; ++i) {
    const Uv uv(uniform(random, 0.05, 0.95), uniform(random, 0.05, 0.95));
    const SurfaceDerivatives d = surface.derivatives(uv);
    const Vec3 p = d.S + uniform(random, -2, 2) * unit_normal(d);
    const auto foot =
        foot_point(surface, p, uv + Uv(uniform(random, -0.01, 0.01), uniform(random, -0.01, 0.01)));
    ASSERT_TRUE(foot);
    // |dS| <= 1e-11 mm over a metric of at least (100 / 1.5)^2 /mm: 1e-12 in (u, v) with room.
    EXPECT_LE((*foot - uv).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace afptraj
