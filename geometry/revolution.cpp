#include "geometry/revolution.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/closest_point.h"
#include "geometry/curvature.h"
#include "geometry/skin.h"

namespace afptraj {
namespace {

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

struct Sample {
  Uv uv;
  Vec3 p, n;
};

std::vector<Sample> sample_face(const Part& part, int face, const TrimRegion& trim) {
  const Surface& surface = part.faces[static_cast<std::size_t>(face)].surface;
  std::vector<Sample> samples;
  for (const AreaSample& area : area_samples(part, face, trim, 400)) {
    const SurfaceDerivatives d = surface.derivatives(area.at.uv);
    const Vec3 n = unit_normal(d);
    if (!n.isZero()) samples.push_back({area.at.uv, d.S, n});
  }
  return samples;
}

struct Axis {
  Vec3 point, direction;
};

// The place of the axis nearest to `p`.
Vec3 foot_on(const Axis& axis, const Vec3& p) {
  return axis.point + axis.direction * axis.direction.dot(p - axis.point);
}

Vec3 upright(const Vec3& direction) {
  Eigen::Index greatest = 0;
  direction.cwiseAbs().maxCoeff(&greatest);
  return direction[greatest] < 0 ? Vec3(-direction) : direction;
}

// The axis whose rotation leaves the normals' line complex in place; nothing when none does.
std::optional<Axis> fit_axis(const std::vector<Sample>& samples, const Vec3& centre, double size) {
  Mat6 sum = Mat6::Zero();
  for (const Sample& s : samples) {
    Vec6 row;
    row << ((s.p - centre) / size).cross(s.n), s.n;
    sum += row * row.transpose();
  }
  sum /= static_cast<double>(samples.size());
  const Eigen::SelfAdjointEigenSolver<Mat6> solver(sum);
  // Motions that slide the surface in itself: small eigenvalues. More than one for spheres
  // (all turns) and cylinders (a turn and a shift).
  constexpr double slides = 1e-8;
  Eigen::Index count = 0;
  while (count < 3 && solver.eigenvalues()[count] < slides) ++count;
  if (count == 0) return std::nullopt;
  const Eigen::Matrix<double, 6, Eigen::Dynamic> motions = solver.eigenvectors().leftCols(count);
  // among them the one that turns most, as against shifting
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> turn(motions.topRows(3).transpose() *
                                                            motions.topRows(3));
  const Vec6 motion = motions * turn.eigenvectors().col(count - 1);
  const Vec3 a = motion.head<3>();
  if (a.norm() < 1e-3) return std::nullopt;  // a shift only: an extrusion, or a plane
  const Vec3 direction = a.normalized();
  Vec3 m = motion.tail<3>() / a.norm();
  m -= direction * direction.dot(m);  // a shift along the axis is not part of the turn
  return Axis{centre + size * direction.cross(m), upright(direction)};
}

double greatest_distance_when_turned(const Surface& surface, const TrimRegion& trim, const Axis& axis,
                                     const std::vector<Sample>& samples, double spacing) {
  double greatest = 0;
  int measured = 0;
  const std::size_t stride = std::max<std::size_t>(1, samples.size() / 60);
  const auto azimuth_frame = [&](const Vec3& p) { return Vec3(p - foot_on(axis, p)); };
  for (std::size_t i = 0; i < samples.size(); i += stride) {
    const Vec3 arm = azimuth_frame(samples[i].p);
    if (arm.norm() < 1e-9) continue;
    for (std::size_t j = stride / 2; j < samples.size(); j += 5 * stride) {
      const Vec3 other = azimuth_frame(samples[j].p);
      if (other.norm() < 1e-9) continue;
      const Vec3 turned = foot_on(axis, samples[i].p) + other.normalized() * arm.norm();
      const auto near =
          std::min_element(samples.begin(), samples.end(), [&](const Sample& a, const Sample& b) {
            return (a.p - turned).squaredNorm() < (b.p - turned).squaredNorm();
          });
      if ((near->p - turned).norm() > 2 * spacing) continue;  // the face does not reach there
      const auto foot = foot_point(surface, turned, near->uv);
      if (!foot || !trim.contains(*foot)) continue;
      greatest = std::max(greatest, (surface.point(*foot) - turned).norm());
      ++measured;
    }
  }
  return measured < 20 ? std::numeric_limits<double>::infinity() : greatest;
}

Revolution describe(const Axis& axis, const std::vector<Sample>& samples, const Vec3& centre,
                    double deviation) {
  Revolution out;
  out.point = foot_on(axis, centre);
  out.direction = axis.direction;
  out.deviation_mm = deviation;
  std::vector<Eigen::Vector2d> profile;
  for (const Sample& s : samples) {
    profile.emplace_back(axis.direction.dot(s.p - out.point), (s.p - foot_on(axis, s.p)).norm());
  }
  std::sort(profile.begin(), profile.end(),
            [](const auto& a, const auto& b) { return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y(); });
  out.radius_min_mm = std::numeric_limits<double>::infinity();
  for (const auto& point : profile) {
    out.radius_min_mm = std::min(out.radius_min_mm, point.y());
    out.radius_max_mm = std::max(out.radius_max_mm, point.y());
  }
  const std::size_t count = std::min(Revolution::profile_points, profile.size());
  for (std::size_t i = 0; i < count; ++i) {
    out.profile.push_back(profile[count == 1 ? 0 : i * (profile.size() - 1) / (count - 1)]);
  }
  return out;
}

}  // namespace

std::optional<Revolution> find_revolution(const Part& part, int face, const TrimRegion& trim,
                                          double tolerance_mm) {
  const Surface& surface = part.faces[static_cast<std::size_t>(face)].surface;
  if (surface.kind() == SurfaceKind::plane) return std::nullopt;
  const std::vector<Sample> samples = sample_face(part, face, trim);
  if (samples.size() < 9) return std::nullopt;
  Vec3 lo = samples.front().p, hi = lo, centre = Vec3::Zero();
  for (const Sample& s : samples) {
    lo = lo.cwiseMin(s.p);
    hi = hi.cwiseMax(s.p);
    centre += s.p / static_cast<double>(samples.size());
  }
  if (surface.kind() != SurfaceKind::bspline) {
    return describe({surface.frame().origin, upright(surface.frame().z)}, samples, centre, 0);
  }
  const double size = (hi - lo).norm();
  if (!(size > 0)) return std::nullopt;
  const auto axis = fit_axis(samples, centre, size);
  // An axis far away is that of a nearly flat sheet: every such sheet has one.
  if (!axis || (foot_on(*axis, centre) - centre).norm() > 100 * size) return std::nullopt;
  const double spacing = size / std::sqrt(static_cast<double>(samples.size()));
  const double deviation = greatest_distance_when_turned(surface, trim, *axis, samples, spacing);
  if (!(deviation <= tolerance_mm)) return std::nullopt;
  return describe(*axis, samples, centre, deviation);
}

}  // namespace afptraj
