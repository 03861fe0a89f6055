#pragma once

#include <algorithm>
#include <limits>
#include <memory>
#include <vector>

#include "boundary/clip.h"
#include "geometry/curvature.h"
#include "trajectory/parallels.h"

namespace afptraj::test {

/// What tests of parallels share.

constexpr double W = 50.8;

/// A straight (u, v) segment as the reference.
inline std::shared_ptr<const SplinePath> uv_line(const Skin& skin, const Uv& a, const Uv& b,
                                                 bool closed = false) {
  const SurfaceDerivatives d = skin.derivatives({0, 0.5 * (a + b)});
  const double length = uv_to_tangent(d, b - a).norm();
  return std::make_shared<const SplinePath>(
      skin, std::vector<SplinePath::Piece>{{{0, 1, nullptr}, line_segment(a, b, 0, length)}}, closed);
}

/// Cubics to 1e-7 mm between rays of 1e-11 mm: below all that the tests of closed forms ask for (1e-6 mm).
inline ParallelOptions exact_options(const Skin& skin, double spacing_mm = W) {
  ParallelOptions o;
  o.front.spacing_mm = spacing_mm;
  o.front.sample_mm = 4;
  o.front.hermite_tolerance_mm = 1e-7;
  o.geodesic.tolerance_mm = 1e-11;
  o.geodesic.outside_limit_mm = skin.diagonal();
  o.geodesic.margin_mm = spacing_mm / 2;
  return o;
}

/// Visits points between the nodes, where a curve is worst.
template <typename Visit>
void for_each_midpoint(const Skin& skin, const SurfaceCurve& curve, Visit visit) {
  for (const auto& piece : curve.pieces)
    for (std::size_t i = 0; i + 1 < piece.size(); ++i) visit(frame_at(skin, piece, i, 0.5));
}

inline double length_of(const Skin& skin, const SurfaceCurve& curve) {
  double sum = 0;
  for (const auto& piece : curve.pieces)
    for (std::size_t i = 0; i + 1 < piece.size(); ++i) sum += arc_length(skin, piece, i, 0, 1);
  return sum;
}

/// The stretches of a level on the skin.
inline std::vector<SurfaceCurve> on_skin(const Skin& skin, const LevelCurve& level) {
  std::vector<SurfaceCurve> out;
  for (const SurfaceCurve& curve : level.curves)
    for (SurfaceCurve& stretch : clip_to_skin(skin, curve)) out.push_back(std::move(stretch));
  return out;
}

inline const LevelCurve* level(const Parallels& parallels, int number) {
  for (const LevelCurve& l : parallels.levels)
    if (l.number == number) return &l;
  return nullptr;
}

/// Distance in space from p to a curve: from the nearest nodes along the tangent to the foot.
inline double distance_to(const Skin& skin, const SurfaceCurve& curve, const Vec3& p) {
  double best = std::numeric_limits<double>::infinity();
  for (const auto& piece : curve.pieces) {
    std::size_t nearest = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < piece.size(); ++i) {
      const double d = (skin.point(piece[i].at) - p).squaredNorm();
      if (d < least) least = d, nearest = i;
    }
    for (const std::size_t i : {nearest > 0 ? nearest - 1 : 0, std::min(nearest, piece.size() - 2)}) {
      double x = i < nearest ? 1 : 0;
      for (int iteration = 0; iteration < 30; ++iteration) {
        const CurveFrame f = frame_at(skin, piece, i, x);
        const double h = f.speed * (piece[i + 1].t - piece[i].t);
        const double next = std::clamp(x + (p - f.frame.position).dot(f.frame.tangent) / h, 0.0, 1.0);
        if (std::abs(next - x) < 1e-13) break;
        x = next;
      }
      best = std::min(best, (frame_at(skin, piece, i, x).frame.position - p).norm());
    }
  }
  return best;
}

inline double distance_to(const Skin& skin, const std::vector<SurfaceCurve>& curves, const Vec3& p) {
  double best = std::numeric_limits<double>::infinity();
  for (const SurfaceCurve& curve : curves) best = std::min(best, distance_to(skin, curve, p));
  return best;
}

}  // namespace afptraj::test
