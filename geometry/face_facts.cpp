#include "geometry/face_facts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "geometry/closest_point.h"
#include "geometry/curvature.h"
#include "geometry/skin.h"

namespace afptraj {
namespace {

constexpr int curve_samples = 32;

// Twice the signed area of a loop in (u, v), from chords of its pcurves.
double signed_area(const Loop& loop) {
  double area = 0;
  for (const Coedge& coedge : loop.coedges) {
    const double sign = coedge.reversed ? -1 : 1;
    Uv before = coedge.pcurve.point(coedge.pcurve.first());
    for (int i = 1; i <= curve_samples; ++i) {
      const double x = static_cast<double>(i) / curve_samples;
      const Uv at =
          coedge.pcurve.point(coedge.pcurve.first() + x * (coedge.pcurve.last() - coedge.pcurve.first()));
      area += sign * (before.x() * at.y() - before.y() * at.x());
      before = at;
    }
  }
  return area;
}

}  // namespace

FaceFacts face_facts(const Part& part, int index, const TrimRegion& trim) {
  const Face& face = part.faces[static_cast<std::size_t>(index)];
  FaceFacts facts;
  facts.box_min.setConstant(std::numeric_limits<double>::infinity());
  facts.box_max = -facts.box_min;
  const auto grow = [&](const Vec3& p) {
    facts.box_min = facts.box_min.cwiseMin(p);
    facts.box_max = facts.box_max.cwiseMax(p);
  };
  double greatest = 0;
  for (const AreaSample& sample : area_samples(part, index, trim, 2000)) {
    facts.area_mm2 += sample.area_mm2;
    const SurfaceDerivatives d = face.surface.derivatives(sample.at.uv);
    grow(d.S);
    const Vec3 normal = unit_normal(d);
    if (normal.isZero()) continue;
    const Curvatures k = curvatures(d, normal);
    greatest = std::max({greatest, std::abs(k.k1), std::abs(k.k2)});
  }
  facts.smallest_radius_mm = greatest > 1e-12 ? 1 / greatest : std::numeric_limits<double>::infinity();
  std::set<int> own_edges;
  for (const Loop& loop : face.loops) {
    if (signed_area(loop) < 0) ++facts.holes;
    for (const Coedge& coedge : loop.coedges) {
      own_edges.insert(coedge.edge);
      for (int i = 0; i <= curve_samples; ++i) {
        const double x = static_cast<double>(i) / curve_samples;
        const double t = coedge.pcurve.first() + x * (coedge.pcurve.last() - coedge.pcurve.first());
        grow(face.surface.point(coedge.pcurve.point(t)));
      }
    }
  }
  std::set<int> neighbours;
  for (std::size_t f = 0; f < part.faces.size(); ++f) {
    if (static_cast<int>(f) == index) continue;
    for (const Loop& loop : part.faces[f].loops) {
      for (const Coedge& coedge : loop.coedges) {
        if (own_edges.count(coedge.edge) != 0) neighbours.insert(static_cast<int>(f));
      }
    }
  }
  facts.neighbours.assign(neighbours.begin(), neighbours.end());
  return facts;
}

std::vector<int> nearest_tangent_group(const std::shared_ptr<const Part>& part,
                                       const std::vector<std::shared_ptr<const TrimRegion>>& trim,
                                       const std::vector<Vec3>& points, double angle_rad) {
  std::vector<int> all(part->faces.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
  const ClosestPointFinder finder(part, all, trim);
  std::map<int, int> votes;  // by face
  for (const Vec3& p : points) {
    if (const auto nearest = finder.closest(p)) ++votes[nearest->at.face];
  }
  std::vector<int> best;
  int best_votes = 0;
  std::set<int> seen;
  for (const auto& [face, count] : votes) {
    if (seen.count(face) != 0) continue;
    const std::vector<int> group = grow_tangent(*part, {face}, angle_rad);
    seen.insert(group.begin(), group.end());
    int sum = 0;
    for (const int member : group) {
      const auto found = votes.find(member);
      if (found != votes.end()) sum += found->second;
    }
    if (sum > best_votes) {
      best = group;
      best_votes = sum;
    }
  }
  return best;
}

}  // namespace afptraj
