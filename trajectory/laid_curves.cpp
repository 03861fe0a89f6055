#include "trajectory/laid_curves.h"

#include <algorithm>
#include <cmath>

namespace afptraj {

LaidCurves::LaidCurves(const Skin& skin, double cell_mm) : skin_(&skin), cell_mm_(cell_mm) {}

LaidCurves::Key LaidCurves::key(const Vec3& p) const {
  const auto c = [&](double x) { return static_cast<Key>(std::floor(x / cell_mm_)) & 0x1fffff; };
  return c(p.x()) | (c(p.y()) << 21) | (c(p.z()) << 42);
}

template <typename Visit>
void LaidCurves::visit_near(const Vec3& p, double radius, Visit visit) const {
  const int reach = static_cast<int>(std::ceil(radius / cell_mm_));
  for (int i = -reach; i <= reach; ++i)
    for (int j = -reach; j <= reach; ++j)
      for (int k = -reach; k <= reach; ++k) {
        const auto it = cells_.find(key(p + cell_mm_ * Vec3(i, j, k)));
        if (it == cells_.end()) continue;
        for (const auto& [curve, node] : it->second) visit(curve, node);
      }
}

int LaidCurves::add(SurfaceCurve curve, int number, const GeodesicTracer* own_tracer) {
  const int index = static_cast<int>(curves_.size());
  Entry entry;
  entry.number = number;
  entry.own_tracer = own_tracer;
  for (const auto& piece : curve.pieces)
    for (const CurveNode& node : piece)
      entry.nodes.push_back({skin_->point(node.at), node.normal_sign * skin_->normal(node.at), node.t});
  entry.curve = std::move(curve);
  for (std::size_t i = 0; i < entry.nodes.size(); ++i)
    cells_[key(entry.nodes[i].position)].emplace_back(index, static_cast<int>(i));
  curves_.push_back(std::move(entry));
  return index;
}

std::optional<LaidCurves::Rival> LaidCurves::rival(const GeodesicTracer& tracer, const Vec3& p, const Vec3& n,
                                                   double limit_mm, int own, double own_t,
                                                   double own_reach_mm) const {
  const auto distance = [&](const Entry& entry, std::size_t i) {
    return (entry.nodes[i].position - p).norm();
  };
  thread_local std::vector<std::pair<int, int>> minima;
  minima.clear();
  visit_near(p, limit_mm, [&](int c, int i) {
    const Entry& entry = curves_[static_cast<std::size_t>(c)];
    const auto at = static_cast<std::size_t>(i);
    const double d = distance(entry, at);
    if (d >= limit_mm) return;
    if (c == own && std::abs(entry.nodes[at].t - own_t) <= own_reach_mm) return;
    if (at > 0 && distance(entry, at - 1) < d) return;
    if (at + 1 < entry.nodes.size() && distance(entry, at + 1) < d) return;
    // The least arc that turns the normal so far over this chord must be short enough.
    const double cosine = std::clamp(n.dot(entry.nodes[at].normal), -1.0, 1.0);
    const double half = 0.5 * std::acos(cosine);
    if (half > 1e-3 && d * half / std::sin(half) > 1.2 * limit_mm) return;
    minima.emplace_back(c, i);
  });
  std::sort(minima.begin(), minima.end());
  std::optional<Rival> best;
  for (const auto& [c, i] : minima) {
    const Entry& entry = curves_[static_cast<std::size_t>(c)];
    const GeodesicTracer& walk = entry.own_tracer ? *entry.own_tracer : tracer;
    const double tolerance = std::max(1e-7, 10 * walk.options().tolerance_mm);
    const auto foot =
        geodesic_foot(walk, entry.curve, entry.nodes[static_cast<std::size_t>(i)].t, p, tolerance);
    if (!foot || std::abs(foot->distance_mm) >= limit_mm) continue;
    if (c == own && std::abs(foot->t - own_t) <= own_reach_mm) continue;
    if (!best || std::abs(foot->distance_mm) < std::abs(best->foot.distance_mm)) best = Rival{c, *foot};
  }
  return best;
}

double LaidCurves::distance(const Vec3& p, const Vec3& n, double limit_mm) const {
  double best = limit_mm;
  visit_near(p, limit_mm, [&](int c, int i) {
    const Entry& entry = curves_[static_cast<std::size_t>(c)];
    const Node& node = entry.nodes[static_cast<std::size_t>(i)];
    if (node.normal.dot(n) < -0.5) return;
    best = std::min(best, (node.position - p).norm());
    if (static_cast<std::size_t>(i) + 1 >= entry.nodes.size()) return;
    const Vec3 a = node.position, ab = entry.nodes[static_cast<std::size_t>(i) + 1].position - a;
    const double x = ab.squaredNorm() > 0 ? std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0) : 0.0;
    best = std::min(best, (a + x * ab - p).norm());
  });
  return best;
}

bool LaidCurves::abreast(const Vec3& p, const Vec3& n, const Vec3& along, double limit_mm,
                         double abreast_mm) const {
  bool found = false;
  visit_near(p, limit_mm, [&](int c, int i) {
    const Node& node = curves_[static_cast<std::size_t>(c)].nodes[static_cast<std::size_t>(i)];
    const Vec3 r = node.position - p;
    const double ahead = std::abs(r.dot(along));
    if (r.norm() < limit_mm && ahead <= abreast_mm &&
        r.squaredNorm() - ahead * ahead > abreast_mm * abreast_mm && node.normal.dot(n) > 0.5)
      found = true;
  });
  return found;
}

}  // namespace afptraj
