#include "winding/skin_mandrel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "geometry/error.h"
#include "geometry/revolution.h"
#include "geometry/section.h"
#include "winding/number_words.h"

namespace afptraj {
namespace {

constexpr double meridian_steps = 4000, compared_steps = 300;  // of a section, by the skin's diagonal

[[noreturn]] void refuse(const std::string& message) { throw Error(ErrorCode::bad_input, "skin", message); }

std::string place_text(const Vec3& p) {
  return "(" + significant_text(p.x(), 6) + ", " + significant_text(p.y(), 6) + ", " +
         significant_text(p.z(), 6) + ")";
}

struct Axis {
  Vec3 origin, direction;
  Vec3 foot(const Vec3& p) const { return origin + direction * (p - origin).dot(direction); }
};

double reach(const Revolution& revolution) {
  return revolution.profile.empty() ? 0 : revolution.profile.back().x() - revolution.profile.front().x();
}

// How far the first face that is not plane is from one of revolution: for the message.
[[noreturn]] void refuse_without_axis(const Skin& skin) {
  for (const int face : skin.faces()) {
    const auto nearly =
        find_revolution(skin.part(), face, skin.trim(face), std::numeric_limits<double>::max());
    if (nearly) {
      refuse("face " + std::to_string(face + 1) + " deviates by " +
             significant_text(nearly->deviation_mm, 4) +
             " mm from a surface of revolution; choose faces with --face");
    }
  }
  refuse("has no face of revolution; choose faces with --face");
}

// The axis, and the face it was found on.
std::pair<Axis, int> find_axis(const Skin& skin, double tolerance_mm) {
  std::optional<Revolution> best;
  int best_face = -1;
  bool best_is_sphere = false;
  for (const int face : skin.faces()) {
    const auto found = find_revolution(skin.part(), face, skin.trim(face), tolerance_mm);
    if (!found) continue;
    // every line through its centre is an axis of a sphere
    const bool sphere = skin.face(face).surface.kind() == SurfaceKind::sphere;
    if (!best || (best_is_sphere && !sphere) || (sphere == best_is_sphere && reach(*found) > reach(*best))) {
      best = found;
      best_face = face;
      best_is_sphere = sphere;
    }
  }
  if (!best) refuse_without_axis(skin);
  const Vec3 direction = best->direction.normalized();
  return {{best->point - direction * best->point.dot(direction), direction}, best_face};
}

using Rows = std::vector<MeridianRow>;

// The parts of a section curve on one side of the axis, each as rows with growing z.
class HalfPlane {
 public:
  HalfPlane(const Axis& axis, const Vec3& outward) : axis_(axis), outward_(outward) {}

  std::vector<Rows> cut(const Skin& skin, double step_mm) const {
    SectionOptions options;
    options.step_mm = step_mm;
    const Plane plane{axis_.origin, axis_.direction.cross(outward_)};
    std::vector<Rows> runs;
    for (const SectionCurve& curve : section(skin, plane, options)) add_runs(skin, curve, runs);
    for (Rows& run : runs) {
      if (run.back().z_mm < run.front().z_mm) std::reverse(run.begin(), run.end());
    }
    std::sort(runs.begin(), runs.end(),
              [](const Rows& a, const Rows& b) { return a.front().z_mm < b.front().z_mm; });
    return runs;
  }

  Vec3 place(const MeridianRow& row) const {
    return axis_.origin + axis_.direction * row.z_mm + outward_ * row.r_mm;
  }

 private:
  void add_runs(const Skin& skin, const SectionCurve& curve, std::vector<Rows>& runs) const {
    const double on_axis = 1e-9 * skin.diagonal();
    std::vector<Rows> found;
    bool open = false, from_start = false;
    for (std::size_t i = 0; i < curve.points.size(); ++i) {
      const Vec3 p = skin.point(curve.points[i]) - axis_.origin;
      const double r = p.dot(outward_);
      if (r < -on_axis) {
        open = false;
        continue;
      }
      if (!open) found.emplace_back();
      from_start = from_start || i == 0;
      open = true;
      found.back().push_back({p.dot(axis_.direction), std::max(r, 0.0)});
    }
    // a closed curve may begin in the middle of a run
    if (curve.closed && open && from_start && found.size() > 1) {
      found.back().insert(found.back().end(), found.front().begin() + 1, found.front().end());
      found.erase(found.begin());
    }
    for (Rows& run : found) {
      if (run.size() > 1) runs.push_back(std::move(run));
    }
  }

  const Axis& axis_;
  Vec3 outward_;
};

std::string near_text(const Rows& run) { return " near z = " + significant_text(run.front().z_mm, 6); }

// The runs follow each other along the axis. `runs` are in the order of their beginnings.
void require_one_wall(const std::vector<Rows>& runs, double tolerance_mm) {
  for (std::size_t i = 0; i + 1 < runs.size(); ++i) {
    if (runs[i + 1].front().z_mm < runs[i].back().z_mm - tolerance_mm)
      refuse("has more than one wall" + near_text(runs[i + 1]) + "; choose the outer faces with --face");
  }
  for (std::size_t i = 0; i + 1 < runs.size(); ++i) {
    const double apart = std::max(std::abs(runs[i + 1].front().z_mm - runs[i].back().z_mm),
                                  std::abs(runs[i + 1].front().r_mm - runs[i].back().r_mm));
    if (apart > tolerance_mm)
      refuse("has a gap" + near_text(runs[i + 1]) + "; choose faces that follow each other with --face");
  }
}

// One run after the other. Where a section passes from face to face a row stands twice, but for rounding: a
// corner. A step within the tolerance becomes a short line between two corners.
Rows chained(const std::vector<Rows>& runs) {
  constexpr double same_place_mm = 1e-7;
  Rows rows;
  for (const Rows& run : runs) {
    for (std::size_t i = 0; i < run.size(); ++i) {
      MeridianRow row = run[i];
      const bool joins = i == 0 && !rows.empty();
      if (!rows.empty() &&
          std::hypot(row.z_mm - rows.back().z_mm, row.r_mm - rows.back().r_mm) < same_place_mm) {
        row = rows.back();
      } else if (joins) {
        rows.push_back(rows.back());
        row.z_mm = std::max(row.z_mm, rows.back().z_mm);
        rows.push_back(row);
      }
      rows.push_back(row);
    }
  }
  return rows;
}

// Distances of points from a meridian, by its nearest sample and a search beside it.
class DistanceToMeridian {
 public:
  explicit DistanceToMeridian(const Meridian& meridian) : meridian_(meridian) {
    constexpr int samples = 4000;
    for (int i = 0; i <= samples; ++i) {
      t_.push_back(meridian.first() + (meridian.last() - meridian.first()) * i / samples);
      at_.push_back(meridian.at(t_.back()));
    }
  }

  double operator()(const MeridianRow& row) const {
    const auto squared = [&](const MeridianPoint& p) {
      return (p.z_mm - row.z_mm) * (p.z_mm - row.z_mm) + (p.r_mm - row.r_mm) * (p.r_mm - row.r_mm);
    };
    std::size_t nearest = 0;
    for (std::size_t i = 1; i < at_.size(); ++i) {
      if (squared(at_[i]) < squared(at_[nearest])) nearest = i;
    }
    double lo = t_[nearest == 0 ? 0 : nearest - 1], hi = t_[std::min(nearest + 1, t_.size() - 1)];
    for (int i = 0; i < 60; ++i) {
      const double a = lo + (hi - lo) / 3, b = hi - (hi - lo) / 3;
      (squared(meridian_.at(a)) < squared(meridian_.at(b)) ? hi : lo) =
          squared(meridian_.at(a)) < squared(meridian_.at(b)) ? b : a;
    }
    return std::sqrt(squared(meridian_.at((lo + hi) / 2)));
  }

 private:
  const Meridian& meridian_;
  std::vector<double> t_;
  std::vector<MeridianPoint> at_;
};

// Every `stride`-th row of each run between corners, and no fewer than some of each.
Rows thinned(const Rows& rows, std::size_t stride, Rows& dropped) {
  constexpr std::size_t fewest = 16;
  Rows kept;
  for (std::size_t first = 0; first < rows.size();) {
    std::size_t last = first;
    const auto same = [](const MeridianRow& a, const MeridianRow& b) {
      return a.z_mm == b.z_mm && a.r_mm == b.r_mm;
    };
    while (last + 1 < rows.size() && !same(rows[last], rows[last + 1])) ++last;
    const std::size_t step = std::clamp<std::size_t>((last - first) / fewest, 1, stride);
    for (std::size_t i = first; i <= last; ++i) {
      if ((i - first) % step == 0 || i == last) kept.push_back(rows[i]);
      if (step > 1 && (i - first) % step == step / 2) dropped.push_back(rows[i]);
    }
    first = last + 1;
  }
  return kept;
}

// A section has far more rows than its spline needs, and each costs time wherever the mandrel is used: as few
// as keep the spline to those that were left out.
Meridian meridian_of(const Rows& rows) {
  constexpr double departure_mm = 1e-6;
  for (const std::size_t stride : {16, 8, 4, 2}) {
    Rows dropped;
    Meridian meridian = meridian_through(thinned(rows, stride, dropped));
    const DistanceToMeridian distance(meridian);
    if (std::all_of(dropped.begin(), dropped.end(),
                    [&](const MeridianRow& row) { return distance(row) < departure_mm; }))
      return meridian;
  }
  return meridian_through(rows);
}

// The direction from the axis to a place inside a face.
Vec3 outward_at(const Skin& skin, int face, const Axis& axis) {
  constexpr int samples = 64;
  const auto inside = area_samples(skin.part(), face, skin.trim(face), samples);
  Vec3 best = Vec3::Zero();
  for (const AreaSample& sample : inside) {
    const Vec3 p = skin.point(sample.at);
    const Vec3 arm = p - axis.foot(p);
    if (arm.norm() > best.norm()) best = arm;
  }
  if (best.norm() == 0) refuse("has a face of revolution without area; choose faces with --face");
  return best.normalized();
}

}  // namespace

SkinMandrel mandrel_from_skin(const Skin& skin, double tolerance_mm) {
  const auto [axis, face] = find_axis(skin, tolerance_mm);
  const Vec3 outward = outward_at(skin, face, axis);
  const HalfPlane half_plane(axis, outward);
  const auto runs = half_plane.cut(skin, skin.diagonal() / meridian_steps);
  if (runs.empty()) refuse("is not met by a plane through its axis; choose faces with --face");
  require_one_wall(runs, tolerance_mm);
  SkinMandrel out{meridian_of(chained(runs)), axis.origin, axis.direction, 0};
  const DistanceToMeridian distance(out.meridian);
  const Vec3 across = axis.direction.cross(outward);
  for (int k = 1; k <= compared_half_planes; ++k) {
    // An angle that no symmetry of a part is likely to share: the golden one.
    const double turn = k * std::numbers::pi * (3 - std::sqrt(5.0));
    const HalfPlane other(axis, outward * std::cos(turn) + across * std::sin(turn));
    for (const Rows& run : other.cut(skin, skin.diagonal() / compared_steps)) {
      for (const MeridianRow& row : run) {
        const double off = distance(row);
        out.deviation_mm = std::max(out.deviation_mm, off);
        if (off > tolerance_mm) {
          refuse("deviates by " + significant_text(off, 4) + " mm from a surface of revolution at " +
                 place_text(other.place(row)) + "; choose faces with --face");
        }
      }
    }
  }
  return out;
}

}  // namespace afptraj
