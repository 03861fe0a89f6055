#include "io/flat_curve.h"

#include <algorithm>

namespace afptraj {
namespace {

void halve(std::vector<Vec2>& points, const std::function<Vec2(double)>& curve, double t0, const Vec2& a,
           double t1, const Vec2& b, int depth, double tolerance) {
  const Vec2 middle = curve((t0 + t1) / 2);
  const Vec2 d = b - a;
  const auto off = [&](const Vec2& p) {
    const Vec2 v = p - a;
    const double squared = d.squaredNorm();
    return (v - d * (squared > 0 ? std::clamp(v.dot(d) / squared, 0.0, 1.0) : 0.0)).norm();
  };
  constexpr int deepest = 18;
  if (depth < deepest && (off(middle) > tolerance || off(curve(0.75 * t0 + 0.25 * t1)) > tolerance ||
                          off(curve(0.25 * t0 + 0.75 * t1)) > tolerance)) {
    halve(points, curve, t0, a, (t0 + t1) / 2, middle, depth + 1, tolerance);
    halve(points, curve, (t0 + t1) / 2, middle, t1, b, depth + 1, tolerance);
  } else {
    points.push_back(b);
  }
}

}  // namespace

void append_curve(std::vector<Vec2>& points, const std::function<Vec2(double)>& curve, double t0, double t1,
                  int pieces, double tolerance_mm) {
  Vec2 from = curve(t0);
  for (int i = 0; i < pieces; ++i) {
    const double s0 = t0 + (t1 - t0) * i / pieces,
                 s1 = i + 1 == pieces ? t1 : t0 + (t1 - t0) * (i + 1) / pieces;
    const Vec2 to = curve(s1);
    halve(points, curve, s0, from, s1, to, 0, tolerance_mm);
    from = to;
  }
}

}  // namespace afptraj
