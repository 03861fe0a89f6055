#include "geometry/section.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "geometry/curvature.h"
#include "geometry/section_march.h"
#include "geometry/section_seeds.h"

namespace afptraj {
namespace {

using sections::March;
using sections::MarchPoint;

/// Two places nearer than this are one: the accuracy asked of a start point.
constexpr double same_place_mm = 1e-6;
/// Steps are not made smaller than this; a section that needs it has met a singular point.
constexpr double least_step_mm = 1e-7;
constexpr std::size_t most_points = 2'000'000;

/// One trace: the march, the curve so far, and how it goes on at loops.
class Trace {
 public:
  Trace(const March& march, const SectionOptions& options)
      : march_(march), skin_(march.skin()), options_(options) {}

  SectionCurve run(const SurfacePoint& start, const Vec3& heading) {
    const std::optional<Uv> uv = march_.onto_plane(start.face, start.uv);
    if (!uv) return std::move(curve_);
    start_ = {start.face, *uv};
    start_point_ = skin_.point(start_);
    push(start_);
    sense_ = march_.sense_toward(start.face, *uv, heading);
    std::optional<MarchPoint> here = march_.at(start.face, *uv, sense_);
    double h = options_.step_mm;
    int idle = 0;  // crossings of loops without progress between them: a vertex has a few
    while (here && curve_.points.size() < most_points && idle < 16) {
      h = std::min({longest(*here), 2 * h, here->kappa > 0 ? 0.3 / here->kappa : options_.step_mm});
      if (ends_in_pole(*here)) break;
      const std::optional<March::Step> step = good_step(*here, h);
      if (!step) break;
      if (closes(*here, *step)) break;
      const auto crossing = skin_.trim(here->face).first_crossing(step->path, true);
      if (!crossing) {
        total_ += step->length;
        push({here->face, step->to.uv});
        here = step->to;
        idle = 0;
        continue;
      }
      const double before = total_;
      here = cross(*here, *step, *crossing);
      idle = total_ - before > 1e-9 ? 0 : idle + 1;
    }
    return std::move(curve_);
  }

 private:
  void push(const SurfacePoint& at) {
    curve_.points.push_back(at);
    curve_.s_mm.push_back(total_);
  }

  /// How far to go along the tangent for an arc of step_mm; a little less, as the bend may grow.
  double longest(const MarchPoint& here) const {
    const double turn = here.kappa * options_.step_mm;
    return options_.step_mm / (1 + turn * turn / 5);
  }

  /// A step of at most `h` with the arc length right to the tolerance, ending at the first knot line
  /// it would cross (the surface's higher derivatives jump there); `h` becomes its size.
  std::optional<March::Step> good_step(const MarchPoint& here, double& h) const {
    while (h >= least_step_mm) {
      std::optional<March::Step> step = march_.step(here, h, sense_);
      if (step) {
        const double knot = first_knot(here.face, step->path);
        if (knot < 1) {
          const double shorter = knot * here.tangent.dot(step->to.d.S - here.d.S);
          const std::optional<March::Step> to_knot = march_.step(here, shorter, sense_);
          if (to_knot) step = to_knot;
        }
        if (step->length > options_.step_mm) {
          h *= 0.99 * options_.step_mm / step->length;
          continue;
        }
        if (step->error <= options_.tolerance_mm * 1e-3 * step->length + march_.rounding()) return step;
      }
      h *= 0.5;
    }
    return std::nullopt;
  }

  /// Where the path first crosses a knot line, as a share of its length; 1 if it does not.
  double first_knot(int face, const UvCubic& path) const {
    const Surface& surface = skin_.face(face).surface;
    if (surface.spline() == nullptr) return 1;
    double first = 1;
    const Uv a = path.point(0), b = path.point(1);
    const auto look = [&](int axis, const std::vector<double>& knots, double period) {
      const double base = period > 0 ? period * std::floor((a[axis] - knots.front()) / period) : 0;
      const double span = 1e-6 * (b[axis] - a[axis]);
      for (const double turn : {-period, 0.0, period}) {
        const double from = std::min(a[axis], b[axis]) - base - turn,
                     to = std::max(a[axis], b[axis]) - base - turn;
        for (auto k = std::lower_bound(knots.begin(), knots.end(), from); k != knots.end() && *k <= to; ++k) {
          const double target = *k + base + turn;
          // Beginning or ending at the knot is no crossing.
          if (std::abs(target - a[axis]) <= std::abs(span) || std::abs(target - b[axis]) <= std::abs(span))
            continue;
          double x = (target - a[axis]) / (b[axis] - a[axis]);
          for (int i = 0; i < 6; ++i) {
            const double rate = path.derivative(x)[axis];
            if (rate == 0) break;
            x = std::clamp(x - (path.point(x)[axis] - target) / rate, 0.0, 1.0);
          }
          if (x > 1e-3) first = std::min(first, x);
        }
        if (period == 0) break;
      }
    };
    look(0, surface.breaks_u(), surface.period_u());
    look(1, surface.breaks_v(), surface.period_v());
    return first;
  }

  /// Ends the curve in a pole that lies right ahead on the plane: on its other side the parameters
  /// jump, so that no step leads over it.
  bool ends_in_pole(const MarchPoint& here) {
    for (const Loop& loop : skin_.face(here.face).loops) {
      for (const Coedge& coedge : loop.coedges) {
        if (!skin_.part().edges[static_cast<std::size_t>(coedge.edge)].degenerate) continue;
        const BSplineCurve2& side = coedge.pcurve;
        const Vec3 pole = skin_.face(here.face).surface.point(side.point(side.first()));
        const Vec3 way = pole - here.d.S;
        const double chord = way.norm();
        // Close enough for the arc of a circle: its error is of the fourth order in the chord.
        if (chord > 0.02 * options_.step_mm || !(way.dot(here.tangent) > 0)) continue;
        if (std::abs(march_.height(pole)) > same_place_mm) continue;
        total_ += chord * (1 + std::pow(here.kappa * chord, 2) / 24);
        push({here.face, beside(side, here.uv)});
        return true;
      }
    }
    return false;
  }

  /// The point of a pole's pcurve (a line in (u, v)) nearest to `uv`.
  static Uv beside(const BSplineCurve2& side, const Uv& uv) {
    const Uv a = side.point(side.first()), d = side.point(side.last()) - a;
    const double x = d.squaredNorm() > 0 ? std::clamp((uv - a).dot(d) / d.squaredNorm(), 0.0, 1.0) : 0.0;
    return a + x * d;
  }

  /// Ends the curve at its start if this step passes through it.
  bool closes(const MarchPoint& here, const March::Step& step) {
    if (here.face != start_.face || total_ <= 10 * same_place_mm) return false;
    const Vec3 d = start_point_ - here.d.S;
    const double h = here.tangent.dot(step.to.d.S - here.d.S);
    const double x = here.tangent.dot(d);
    if (x < -same_place_mm || x > h + same_place_mm || d.norm() > 2 * h + same_place_mm) return false;
    if (std::abs(x) <= same_place_mm) {
      if (d.norm() > same_place_mm) return false;
      push(start_);
      return curve_.closed = true;
    }
    const double share = std::clamp(x / h, 0.0, 1.0);
    const std::optional<MarchPoint> there = march_.advance(here, x, sense_, step.path.point(share));
    if (!there || (there->d.S - start_point_).norm() > same_place_mm) return false;
    const std::optional<March::Step> last = march_.step_to(here, *there, sense_);
    total_ += last ? last->length : d.norm();
    push(start_);
    return curve_.closed = true;
  }

  /// The crossing of plane and pcurve next to parameter t: Newton on the height along the edge.
  std::optional<double> edge_parameter(const EdgeUse& use, double t) const {
    const Coedge& coedge = skin_.coedge(use);
    const Surface& surface = skin_.face(use.face).surface;
    const double first = coedge.pcurve.first(), last = coedge.pcurve.last();
    for (int i = 0; i < 20; ++i) {
      const auto c = coedge.pcurve.derivatives(t);
      const SurfaceDerivatives d = surface.derivatives(c.c);
      const double f = march_.height(d.S);
      const double rate = march_.height_rate(d.Su * c.d1.x() + d.Sv * c.d1.y());
      if (f == 0) return t;
      if (rate == 0) return std::nullopt;
      const double next = std::clamp(t - f / rate, first, last);
      const bool still = std::abs(next - t) <= 1e-15 * (std::abs(first) + std::abs(last));
      t = next;
      if (still) return std::abs(f) <= same_place_mm ? std::optional<double>(t) : std::nullopt;
    }
    return std::nullopt;
  }

  /// Goes to the loop and, where there is one, over to the other side.
  std::optional<MarchPoint> cross(const MarchPoint& here, const March::Step& step,
                                  const LoopCrossing& crossing) {
    const EdgeUse use{here.face, crossing.loop, crossing.coedge};
    Uv uv = crossing.uv;
    double t = crossing.t;
    // The cubic is off the section by the fourth power of the step; the edge itself gives the point.
    const std::optional<double> exact = edge_parameter(use, t);
    if (exact) {
      const Uv there = skin_.coedge(use).pcurve.point(*exact);
      const double moved =
          (skin_.face(use.face).surface.point(there) - skin_.face(use.face).surface.point(uv)).norm();
      if (moved <= 0.5 * step.length + same_place_mm) {
        uv = there;
        t = *exact;
      }
    }
    total_ += arc_to(here, uv);
    push({here.face, uv});
    if (at_start(skin_.point({here.face, uv}))) {
      curve_.closed = true;
      return std::nullopt;
    }
    return enter(use, t, here.tangent);
  }

  double arc_to(const MarchPoint& here, const Uv& uv) const {
    if (const std::optional<MarchPoint> there = march_.at(here.face, uv, sense_)) {
      if (const std::optional<March::Step> last = march_.step_to(here, *there, sense_)) return last->length;
    }
    // No tangent there (a pole), or hardly any way to go: the arc of the circle of curvature.
    const double chord = (skin_.face(here.face).surface.point(uv) - here.d.S).norm();
    return chord * (1 + std::pow(here.kappa * chord, 2) / 24);
  }

  bool at_start(const Vec3& p) const {
    return total_ > 10 * same_place_mm && (p - start_point_).norm() <= same_place_mm;
  }

  std::optional<MarchPoint> enter(const EdgeUse& from, double t, const Vec3& heading) {
    const std::optional<EdgeUse> mate = skin_.mate(from);
    if (!mate) return std::nullopt;
    const Coedge& coedge = skin_.coedge(*mate);
    t = edge_parameter(*mate, t).value_or(t);
    const auto c = coedge.pcurve.derivatives(t);
    const int face = mate->face;
    // Into the material, which lies to the left of the loop; along a loop, as before.
    sense_ = march_.sense_toward(face, c.c, heading);
    std::optional<MarchPoint> there = march_.at(face, c.c, sense_);
    if (!there) return std::nullopt;
    const Uv along = coedge.reversed ? Uv(-c.d1) : c.d1;
    const Vec3 edge = uv_to_tangent(there->d, along);
    const double inward = (along.x() * there->velocity.y() - along.y() * there->velocity.x());
    const double sine = edge.cross(there->tangent).norm();
    if (inward < 0 && sine > 1e-6 * edge.norm()) {
      sense_ = -sense_;
      there = march_.at(face, c.c, sense_);
    }
    push({face, c.c});
    if (at_start(there->d.S)) {
      curve_.closed = true;
      return std::nullopt;
    }
    return there;
  }

  const March& march_;
  const Skin& skin_;
  const SectionOptions& options_;
  SectionCurve curve_;
  SurfacePoint start_;
  Vec3 start_point_ = Vec3::Zero();
  double total_ = 0, sense_ = 1;
};

/// The curve run through the other way.
void turn_round(SectionCurve& curve) {
  std::reverse(curve.points.begin(), curve.points.end());
  std::reverse(curve.s_mm.begin(), curve.s_mm.end());
  const double length = curve.s_mm.empty() ? 0 : curve.s_mm.front();
  for (double& s : curve.s_mm) s = length - s;
}

/// A curve with its samples in space.
struct Branch {
  SectionCurve curve;
  std::vector<Vec3> at;
};

bool passes_through(const March& march, const Branch& branch, const SurfacePoint& seed) {
  const Vec3 p = march.skin().point(seed);
  const SectionCurve& curve = branch.curve;
  for (std::size_t i = 0; i + 1 < curve.points.size(); ++i) {
    const SurfacePoint &a = curve.points[i], &b = curve.points[i + 1];
    const Vec3& from = branch.at[i];
    const double room = curve.s_mm[i + 1] - curve.s_mm[i] + same_place_mm;
    const double away = (p - from).squaredNorm();
    if (away > room * room) continue;
    if (away <= same_place_mm * same_place_mm) return true;
    if (a.face != b.face) continue;
    const Vec3 ahead = branch.at[i + 1] - from;
    const double sense = march.sense_toward(a.face, a.uv, ahead);
    const std::optional<MarchPoint> start = march.at(a.face, a.uv, sense);
    if (!start) continue;
    const double x = start->tangent.dot(p - from);
    if (x < -same_place_mm || x > room) continue;
    const double share = std::clamp(x / room, 0.0, 1.0);
    const std::optional<MarchPoint> there = march.advance(*start, x, sense, a.uv + share * (b.uv - a.uv));
    if (there && (there->d.S - p).norm() <= same_place_mm) return true;
  }
  return false;
}

void require_sensible(const SectionOptions& options) {
  if (!(options.step_mm > least_step_mm) || !(options.tolerance_mm > 0)) {
    throw std::invalid_argument("section: step and tolerance must be positive");
  }
}

}  // namespace

SectionCurve trace_section(const Skin& skin, const Plane& plane, const SurfacePoint& start,
                           const Vec3& heading, const SectionOptions& options) {
  require_sensible(options);
  const March march(skin, plane);
  return Trace(march, options).run(start, heading);
}

std::vector<SectionCurve> section(const Skin& skin, const Plane& plane, const SectionOptions& options) {
  require_sensible(options);
  const March march(skin, plane);
  std::vector<Branch> branches;
  for (const SurfacePoint& seed : sections::seeds(march, plane)) {
    const bool known = std::any_of(branches.begin(), branches.end(),
                                   [&](const Branch& branch) { return passes_through(march, branch, seed); });
    if (known) continue;
    const std::optional<MarchPoint> at = march.at(seed.face, seed.uv, 1);
    if (!at) continue;
    SectionCurve curve = Trace(march, options).run(seed, at->tangent);
    if (!curve.closed) {
      SectionCurve back = Trace(march, options).run(seed, -at->tangent);
      if (back.points.size() > 1) {
        turn_round(back);
        const double length = back.s_mm.back();
        for (std::size_t i = 1; i < curve.points.size(); ++i) {
          back.points.push_back(curve.points[i]);
          back.s_mm.push_back(length + curve.s_mm[i]);
        }
        curve = std::move(back);
      }
    }
    if (curve.points.size() < 2 || curve.length_mm() <= same_place_mm) continue;
    Branch branch{std::move(curve), {}};
    for (const SurfacePoint& point : branch.curve.points) branch.at.push_back(skin.point(point));
    branches.push_back(std::move(branch));
  }
  std::vector<SectionCurve> result;
  for (Branch& branch : branches) result.push_back(std::move(branch.curve));
  return result;
}

}  // namespace afptraj
