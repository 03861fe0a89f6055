// The way back from the eye to the path that it lays.
#include "winding/thread_contact.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/meridians.h"
#include "winding/meridian_geodesic.h"
#include "winding/payout_eye.h"

namespace afptraj {
namespace {

using std::numbers::pi;
using Vec3 = Eigen::Vector3d;

// Paths are compared with chords of some 0.3 mm, which lie h^2 / 8 / r = 1e-4 mm below arcs of r = 100 mm;
// what is promised is 0.01 mm.
constexpr double bound_mm = 3e-4;

Vec3 place(double r, double turn, double z) { return {r * std::cos(turn), r * std::sin(turn), z}; }

// A geodesic there and back, with the eye's places.
struct Circuit {
  std::vector<Vec3> path;
  std::vector<EyePlace> eyes;
  double start_t = 0;
};

Circuit circuit(const Meridian& meridian, double K, const EyeRoom& room, int count) {
  const MeridianGeodesic pass(meridian, K, meridian.widest());
  const PayoutEye eye(meridian, room);
  const auto points = pass.points(count);
  Circuit out;
  out.start_t = points.front().t;
  const auto add = [&](const FibrePoint& point, double turn, double angle) {
    out.path.push_back(place(point.r_mm, turn, point.z_mm));
    const EyePosition at = eye.at(fibre_tangent(meridian, point.t, turn, angle));
    out.eyes.push_back({at.carriage_mm, at.cross_feed_mm, at.mandrel_rad});
  };
  for (const FibrePoint& point : points) add(point, point.turn_rad, point.angle_rad);
  for (std::size_t i = points.size(); i-- > 0;)
    add(points[i], 2 * pass.turn_rad() - points[i].turn_rad, pi - points[i].angle_rad);
  return out;
}

double distance(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 e = b - a;
  const double share = e.squaredNorm() > 0 ? std::clamp((p - a).dot(e) / e.squaredNorm(), 0.0, 1.0) : 0;
  return (p - a - share * e).norm();
}

// Greatest distance of contacts from the path; a contact's neighbours on the path are sought near its own
// piece.
double worst_error(const Circuit& planned, const std::vector<ContactPoint>& laid) {
  double worst = 0;
  for (const ContactPoint& point : laid) {
    const auto middle = static_cast<std::size_t>(point.at_eye);
    const std::size_t first = middle > 20 ? middle - 20 : 0,
                      last = std::min(middle + 20, planned.path.size() - 1);
    double least = 1e300;
    for (std::size_t i = first; i < last; ++i)
      least = std::min(least, distance(place(point.r_mm, point.turn_rad, point.z_mm), planned.path[i],
                                       planned.path[i + 1]));
    worst = std::max(worst, least);
  }
  return worst;
}

void expect_rebuilt(const Meridian& meridian, double K, const EyeRoom& room) {
  const Circuit planned = circuit(meridian, K, room, 2500);
  const auto laid = follow_thread(meridian, planned.start_t, 0, planned.eyes, 1);
  ASSERT_GT(laid.size(), 100u);
  // to the end: the last contact is within a step of the last place
  const ContactPoint& end = laid.back();
  EXPECT_LT((place(end.r_mm, end.turn_rad, end.z_mm) - planned.path.back()).norm(), 1.1);
  EXPECT_LT(worst_error(planned, laid), bound_mm) << "K " << K;
}

TEST(ThreadContact, RebuildsGeodesicsOnVessels) {
  for (const double height : {100.0, 60.0, 35.0}) {
    const Meridian tank = test::vessel(100, 250, height);
    for (const double K : {10.0, 35.0, 80.0}) {
      expect_rebuilt(tank, K, {20, {}});
      expect_rebuilt(tank, K, {20, 140.0});
    }
  }
  expect_rebuilt(test::vessel(150, 0, 150), 40, {25, {}});
}

TEST(ThreadContact, RebuildsAHelix) {
  const double R = 60, c = 95, a = 0.6;
  const Meridian cylinder = meridian_through({{0, R}, {400, R}});
  const double lead = std::acos(R / c), ahead = std::sqrt(c * c - R * R) / std::tan(a);
  // a helix is two axes at steady speed: one straight line
  const double turns = 300 * std::tan(a) / R;
  const std::vector<EyePlace> eyes{{50 + ahead, c, lead}, {350 + ahead, c, lead + turns}};
  const auto laid = follow_thread(cylinder, 50, 0, eyes, 1);
  EXPECT_NEAR(laid.back().length_mm, 300 / std::cos(a), 1.0 + 1e-6);
  for (const ContactPoint& point : laid) {
    EXPECT_NEAR(point.angle_rad, a, 1e-9);
    EXPECT_NEAR((point.z_mm - 50) * std::tan(a) / R, point.turn_rad, 1e-9);
  }
}

// A thread that starts beside its path comes to it as exp(-s / l).
TEST(ThreadContact, ForgetsAWrongStart) {
  const double R = 60, c = 95, a = 1.2;
  const Meridian cylinder = meridian_through({{0, R}, {4000, R}});
  const double leg = std::sqrt(c * c - R * R), free_length = leg / std::sin(a);
  const double turns = 800 * std::tan(a) / R;
  const std::vector<EyePlace> eyes{{50 + leg / std::tan(a), c, std::acos(R / c)},
                                   {850 + leg / std::tan(a), c, std::acos(R / c) + turns}};
  const double off = 0.5;
  const auto laid = follow_thread(cylinder, 50 + off, 0, eyes, 0.5);
  for (const ContactPoint& point : laid) {
    const double beside = point.z_mm - (50 + point.turn_rad * R / std::tan(a));
    EXPECT_NEAR(beside, off * std::exp(-point.length_mm / free_length), 1e-3 * off);
  }
}

// Runge-Kutta's order, on the path over a dome: halving the step divides the error by 16, here somewhat more.
TEST(ThreadContact, IsOfFourthOrder) {
  const Meridian tank = test::vessel(100, 250, 35);
  const Circuit planned = circuit(tank, 60, {25, {}}, 8000);
  const auto end = [&](double step) {
    const auto laid = follow_thread(tank, planned.start_t, 0, planned.eyes, step);
    const auto k = static_cast<std::size_t>(std::lround(64 / step));
    return place(laid[k].r_mm, laid[k].turn_rad, laid[k].z_mm);
  };
  const Vec3 fine = end(0.5);
  const double coarse = (end(16) - fine).norm(), half = (end(8) - fine).norm();
  EXPECT_GT(std::log2(coarse / half), 3.7);
}

}  // namespace
}  // namespace afptraj
