#include "analysis/region_shape.h"

#include <algorithm>
#include <cmath>

#include "geometry/curvature.h"

namespace afptraj {
namespace {

/// The outline in the tangent plane at its middle, mm.
std::vector<Uv> flat_outline(const Skin& skin, int face, const std::vector<Uv>& outline) {
  std::vector<Vec3> points;
  Vec3 middle = Vec3::Zero();
  Uv mean = Uv::Zero();
  for (const Uv& uv : outline) {
    points.push_back(skin.point({face, uv}));
    middle += points.back() / static_cast<double>(outline.size());
    mean += uv / static_cast<double>(outline.size());
  }
  const Vec3 n = unit_normal(skin.derivatives({face, mean})), x = n.unitOrthogonal(), y = n.cross(x);
  std::vector<Uv> out;
  for (const Vec3& p : points) out.emplace_back((p - middle).dot(x), (p - middle).dot(y));
  return out;
}

/// Two points of a ring that lie farthest apart, to cos(pi / 32): of the farthest in 32 directions.
std::pair<std::size_t, std::size_t> farthest(const std::vector<Uv>& ring) {
  constexpr std::size_t directions = 16;
  std::size_t ends[2 * directions] = {};
  for (std::size_t k = 0; k < directions; ++k) {
    const double angle = pi * static_cast<double>(k) / directions;
    const Uv way(std::cos(angle), std::sin(angle));
    for (std::size_t i = 0; i < ring.size(); ++i) {
      if (ring[i].dot(way) > ring[ends[2 * k]].dot(way)) ends[2 * k] = i;
      if (ring[i].dot(way) < ring[ends[2 * k + 1]].dot(way)) ends[2 * k + 1] = i;
    }
  }
  std::pair<std::size_t, std::size_t> best(0, 0);
  for (const std::size_t i : ends)
    for (const std::size_t j : ends)
      if ((ring[i] - ring[j]).squaredNorm() > (ring[best.first] - ring[best.second]).squaredNorm())
        best = {i, j};
  return best;
}

}  // namespace

RegionShape region_shape(const Skin& skin, int face, const std::vector<Uv>& outline) {
  RegionShape out;
  const std::vector<Uv> ring = flat_outline(skin, face, outline);
  const auto [a, b] = farthest(ring);
  out.length_mm = (ring[b] - ring[a]).norm();
  out.where = skin.point({face, outline.front()});
  if (out.length_mm == 0) return out;
  const Uv along = (ring[b] - ring[a]) / out.length_mm, across(-along.y(), along.x());
  constexpr int places = 65;
  std::vector<std::pair<double, Uv>> hits[places];  // across, with (u, v)
  const double start = ring[a].dot(along);
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const std::size_t j = (i + 1) % ring.size();
    const double si = (ring[i].dot(along) - start) / out.length_mm * places - 0.5;
    const double sj = (ring[j].dot(along) - start) / out.length_mm * places - 0.5;
    const int first = std::max(0, static_cast<int>(std::ceil(std::min(si, sj))));
    for (int k = first; k < places && k < std::max(si, sj); ++k) {
      const double x = (k - si) / (sj - si);
      hits[k].emplace_back((1 - x) * ring[i].dot(across) + x * ring[j].dot(across),
                           (1 - x) * outline[i] + x * outline[j]);
    }
  }
  for (auto& row : hits) {
    std::sort(row.begin(), row.end(), [](const auto& p, const auto& q) { return p.first < q.first; });
    for (std::size_t i = 0; i + 1 < row.size(); i += 2)
      if (const double width = row[i + 1].first - row[i].first; width > out.width_mm) {
        out.width_mm = width;
        out.where = skin.point({face, 0.5 * (row[i].second + row[i + 1].second)});
      }
  }
  return out;
}

}  // namespace afptraj
