#include "geometry/poles.h"

#include <algorithm>
#include <cmath>

namespace afptraj {
namespace {

/// A normal of the skin beside a pole, and how much of the way round it stands for.
struct NormalBeside {
  Vec3 normal;
  double share;
};

std::vector<NormalBeside> normals_beside(const Skin& skin, int face, const Coedge& coedge) {
  const Uv size = skin.trim(face).box_max() - skin.trim(face).box_min();
  const double t0 = coedge.pcurve.first(), t1 = coedge.pcurve.last();
  const Uv along = (coedge.pcurve.point(t1) - coedge.pcurve.point(t0)) * (coedge.reversed ? -1 : 1);
  Uv inward = Uv(-along.y(), along.x()).normalized();  // left of the loop lies the material
  inward *= 1e-6 * size.cwiseProduct(inward).norm();
  constexpr int parts = 8;
  const auto at = [&](double x) {
    return SurfacePoint{face, coedge.pcurve.point(t0 + (t1 - t0) * x / parts) + inward};
  };
  const Vec3 pole = skin.face(face).surface.point(coedge.pcurve.point(t0));
  const auto way = [&](double x) { return (skin.point(at(x)) - pole).normalized(); };
  std::vector<NormalBeside> out;
  for (int i = 0; i < parts; ++i) out.push_back({skin.normal(at(i + 0.5)), (way(i + 1) - way(i)).norm()});
  return out;
}

}  // namespace

std::vector<Pole> poles_of(const Skin& skin) {
  std::vector<Pole> poles;
  std::vector<std::vector<NormalBeside>> normals;
  const double same_mm = 1e-6 * skin.diagonal();
  for (int face : skin.faces())
    for (const Loop& loop : skin.face(face).loops)
      for (const Coedge& coedge : loop.coedges) {
        if (!skin.part().edges[static_cast<std::size_t>(coedge.edge)].degenerate) continue;
        const Vec3 point = skin.face(face).surface.point(coedge.pcurve.point(coedge.pcurve.first()));
        std::size_t k = 0;
        while (k < poles.size() && (poles[k].point - point).norm() > same_mm) ++k;
        if (k == poles.size()) {
          poles.emplace_back().point = point;
          normals.emplace_back();
        }
        poles[k].faces.push_back(face);
        for (const NormalBeside& n : normals_beside(skin, face, coedge)) normals[k].push_back(n);
      }
  for (std::size_t k = 0; k < poles.size(); ++k) {
    Vec3 sum = Vec3::Zero();
    for (const NormalBeside& n : normals[k]) sum += n.share * n.normal;
    poles[k].axis = sum.normalized();
    poles[k].smooth = std::all_of(normals[k].begin(), normals[k].end(), [&](const NormalBeside& n) {
      return n.normal.dot(poles[k].axis) > std::cos(1e-3);
    });
  }
  return poles;
}

}  // namespace afptraj
