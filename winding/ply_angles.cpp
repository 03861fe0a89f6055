#include "winding/ply_angles.h"

#include <algorithm>
#include <cmath>

#include "geometry/error.h"
#include "winding/frustum.h"
#include "winding/number_words.h"

namespace afptraj {
namespace {

constexpr double farthest_share = 0.1;  // of the widest radius
constexpr double steepest_deg = 80;     // of a direction from the surface
constexpr double plain_deg = 0.5;       // from the axis or the hoop, where a sense says nothing

struct Asked {
  double clairaut_mm, r_mm, angle_rad, off_mm;
  int sense;
};

std::string point_text(const Vec3& p) {
  return "(" + significant_text(p.x(), 6) + " " + significant_text(p.y(), 6) + " " +
         significant_text(p.z(), 6) + ")";
}

[[noreturn]] void refuse(const std::string& message) { throw Error(ErrorCode::bad_input, "ply", message); }

Asked asked_at(const SkinMandrel& mandrel, const FibreDirection& wanted) {
  const Meridian& meridian = mandrel.meridian;
  const Vec3 from = wanted.point - mandrel.origin;
  const double z = from.dot(mandrel.direction);
  const Vec3 across = from - z * mandrel.direction;
  const double radius = across.norm(), R = meridian.at(meridian.widest()).r_mm;
  const MeridianPoint at = meridian.at(meridian.nearest(z, radius));
  const double off = std::hypot(at.z_mm - z, at.r_mm - radius);
  if (!(off <= farthest_share * R) || !(radius > 0))
    refuse("has a point " + point_text(wanted.point) + " " + significant_text(off, 4) +
           " mm off the mandrel; give points on it");
  const Vec3 out = across / radius;
  const Vec3 along = (at.dz * mandrel.direction + at.dr * out) / at.speed();
  const Vec3 round = mandrel.direction.cross(out);
  double axial = wanted.direction.dot(along), hoop = wanted.direction.dot(round);
  if (std::hypot(axial, hoop) < std::cos(radians(steepest_deg)) * wanted.direction.norm() ||
      !(wanted.direction.norm() > 0))
    refuse("has a direction across the surface at " + point_text(wanted.point) + "; give one along it");
  if (axial < 0) axial = -axial, hoop = -hoop;
  const double angle = std::atan2(std::abs(hoop), axial), plain = radians(plain_deg);
  const int sense = angle < plain || angle > radians(90) - plain ? 0 : (hoop > 0 ? 1 : -1);
  return {at.r_mm * std::sin(angle), at.r_mm, angle, off, sense};
}

}  // namespace

PlyAngle ply_angle(const SkinMandrel& mandrel, const std::vector<FibreDirection>& points) {
  std::vector<Asked> asked;
  PlyAngle out;
  double sum = 0;
  for (const FibreDirection& point : points) {
    asked.push_back(asked_at(mandrel, point));
    sum += asked.back().clairaut_mm;
    out.off_mm = std::max(out.off_mm, asked.back().off_mm);
    if (out.sense * asked.back().sense < 0)
      refuse("runs to both sides, at " + point_text(point.point) +
             " to the other; give each sense its own ply: a helical layer lays both");
    if (out.sense == 0) out.sense = asked.back().sense;
  }
  const double K = sum / static_cast<double>(points.size());
  const double R = mandrel.meridian.at(mandrel.meridian.widest()).r_mm;
  out.angle_deg = degrees(std::asin(std::min(1.0, K / R)));
  for (const Asked& at : asked) {
    const double geodesic = std::asin(std::min(1.0, K / at.r_mm));
    out.spread_deg = std::max(out.spread_deg, degrees(std::abs(at.angle_rad - geodesic)));
  }
  return out;
}

std::vector<PlyLayer> layers_of_plies(const std::vector<PlyAngle>& plies, double tolerance_deg) {
  std::vector<PlyLayer> out;
  for (std::size_t i = 0; i < plies.size(); ++i) {
    PlyLayer layer{plies[i].angle_deg, {i}};
    if (i + 1 < plies.size() && plies[i].sense * plies[i + 1].sense < 0 &&
        std::abs(plies[i].angle_deg - plies[i + 1].angle_deg) <= tolerance_deg) {
      layer.angle_deg = (plies[i].angle_deg + plies[i + 1].angle_deg) / 2;
      layer.plies.push_back(++i);
    }
    out.push_back(layer);
  }
  return out;
}

}  // namespace afptraj
