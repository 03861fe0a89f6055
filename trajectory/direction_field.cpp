#include "trajectory/direction_field.h"

#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "geometry/error.h"

namespace afptraj {

DirectionField::DirectionField(std::vector<OrientationPoint> points, double range_mm)
    : points_(std::move(points)), range_mm_(range_mm) {
  if (!(range_mm > 0)) throw std::invalid_argument("direction field: the range must be greater than 0");
  for (OrientationPoint& p : points_) p.direction.normalize();
}

AskedDirection DirectionField::at(const Vec3& p, const Vec3& normal, const Vec3& walk) const {
  AskedDirection out;
  out.range_mm = range_mm_;
  // Distances from the normal line; points on an opposite wall are left out.
  thread_local std::vector<std::pair<double, const OrientationPoint*>> near;
  near.clear();
  double nearest = std::numeric_limits<double>::infinity();
  for (const OrientationPoint& k : points_) {
    if (k.skin_normal.dot(normal) < 0) continue;
    const Vec3 offset = k.position - p;
    const double R = (offset - offset.dot(normal) * normal).norm();
    near.emplace_back(R, &k);
    nearest = std::min(nearest, R);
  }
  if (near.empty()) {
    out.singular = true;
    return out;
  }
  while (nearest > out.range_mm) {
    out.range_mm *= 2;
    out.range_doubled = true;
  }
  const auto turned = [&](const OrientationPoint& k) {
    return k.direction.dot(walk) < 0 ? Vec3(-k.direction) : k.direction;
  };
  Vec3 sum = Vec3::Zero();
  double weights = 0;
  for (const auto& [R, k] : near) {
    if (R > out.range_mm) continue;
    if (R < 1e-9) {  // on the normal line: the weight is infinite
      sum = turned(*k);
      weights = 1;
      break;
    }
    sum += turned(*k) / R;
    weights += 1 / R;
  }
  Vec3 V = sum / weights;
  V -= V.dot(normal) * normal;
  out.strength = V.norm();
  if (V.norm() < 1e-6) {
    out.singular = true;
    return out;
  }
  out.direction = V.normalized();
  return out;
}

DirectionField make_direction_field(const Skin& skin, const PlyOrientation& ply, double range_mm, double limit_mm,
                                    const std::string& file) {
  std::vector<OrientationPoint> points;
  points.reserve(ply.points.size());
  for (const PlyPoint& p : ply.points) {
    const auto nearest = skin.closest_point().closest(p.position);
    if (!nearest || nearest->distance_mm > limit_mm) {
      char text[240];
      std::snprintf(text, sizeof text,
                    "ply '%s': the point lies %.6g mm from the skin (limit %.6g mm); move it onto the surface, choose "
                    "the faces with --face, or check the units with --unit",
                    ply.name.c_str(), nearest ? nearest->distance_mm : HUGE_VAL, limit_mm);
      throw Error(ErrorCode::bad_input, p.line > 0 ? file + ":" + std::to_string(p.line) : file, text);
    }
    points.push_back({p.position, p.direction, skin.normal(nearest->at)});
  }
  return DirectionField(std::move(points), range_mm);
}

}  // namespace afptraj
