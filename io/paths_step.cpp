#include "io/paths_step.h"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "geometry/closest_point.h"
#include "geometry/curvature.h"

namespace afptraj {
namespace {

// A point where two cubic pieces meet: position and unit tangent at arc length s.
struct Node {
  double s = 0;
  Vec3 position, tangent;
  SurfacePoint at;
};

struct HermiteValue {
  Vec3 position, derivative;
};

HermiteValue hermite(const Node& a, const Node& b, double s) {
  const double h = b.s - a.s, x = (s - a.s) / h;
  const Vec3 p1 = a.position + h / 3 * a.tangent, p2 = b.position - h / 3 * b.tangent;
  const double y = 1 - x;
  return {y * y * y * a.position + 3 * y * y * x * p1 + 3 * y * x * x * p2 + x * x * x * b.position,
          (y * y * (p1 - a.position) + 2 * y * x * (p2 - p1) + x * x * (b.position - p2)) * 3 / h};
}

class SegmentFit {
 public:
  SegmentFit(const Skin& skin, const CourseSegment& segment, const PathFitOptions& options)
      : skin_(skin), options_(options) {
    for (const CourseSample& sample : segment.samples) {
      nodes_.push_back({sample.s_mm, sample.position, sample.tangent.normalized(), sample.at});
    }
  }

  std::vector<BSplineCurve3> curves() {
    std::vector<BSplineCurve3> curves;
    for (std::size_t first = 0; first + 1 < nodes_.size();) {
      std::size_t last = first + 1;
      while (last < nodes_.size() && nodes_[last].s - nodes_[last - 1].s > least_step) ++last;
      // [first, last) has no repeated place
      if (last - first >= 2) {
        chain_.assign(1, nodes_[first]);
        cover(first, last - 1);
        curves.push_back(spline());
      }
      first = last;
    }
    return curves;
  }

 private:
  static constexpr double least_step = 1e-7;  // mm; samples nearer than this are one place with a kink
  static constexpr int deepest = 10;          // halvings between two samples

  // Covers samples first ... last by pieces, appended to chain_.
  void cover(std::size_t first, std::size_t last) {
    if (holds_samples(first, last) && holds_surface(first, last)) {
      chain_.push_back(nodes_[last]);
    } else if (last - first > 1) {
      const std::size_t middle = first + (last - first) / 2;
      cover(first, middle);
      cover(middle, last);
    } else {
      halve(nodes_[first], nodes_[last], deepest);
    }
  }

  bool holds_samples(std::size_t first, std::size_t last) const {
    for (std::size_t k = first + 1; k < last; ++k) {
      const Vec3 p = hermite(nodes_[first], nodes_[last], nodes_[k].s).position;
      if ((p - nodes_[k].position).norm() > options_.sample_mm) return false;
    }
    return true;
  }

  bool holds_surface(std::size_t first, std::size_t last) const {
    for (std::size_t k = first; k < last; ++k) {
      // two places a gap: a cubic that touches the surface in the middle may still swing to both sides
      for (const double part : {0.3, 0.7}) {
        const double s = nodes_[k].s + part * (nodes_[k + 1].s - nodes_[k].s);
        const Vec3 p = hermite(nodes_[first], nodes_[last], s).position;
        if (surface_distance(p, nodes_[k].at, nodes_[k + 1].at) > options_.surface_mm) return false;
      }
    }
    return true;
  }

  // The nearest of the feet on the faces of both neighbours.
  ClosestPoint project(const Vec3& p, const SurfacePoint& a, const SurfacePoint& b) const {
    ClosestPoint best;
    for (const SurfacePoint& seed : {a, b}) {
      if (best.at.face == seed.face) continue;
      const Surface& surface = skin_.face(seed.face).surface;
      const auto uv = foot_point(surface, p, seed.uv);
      if (!uv) continue;
      const Vec3 foot = surface.point(*uv);
      const double distance = (foot - p).norm();
      if (distance < best.distance_mm) best = {{seed.face, *uv}, foot, distance, false};
    }
    if (best.distance_mm > options_.surface_mm) {
      if (const auto anywhere = skin_.closest_point().closest(p, best.distance_mm)) best = *anywhere;
    }
    return best;
  }

  double surface_distance(const Vec3& p, const SurfacePoint& a, const SurfacePoint& b) const {
    return project(p, a, b).distance_mm;
  }

  // One gap between samples in halves, with projected points between, until it lies on the surface.
  void halve(const Node& a, const Node& b, int depth) {
    const double middle = (a.s + b.s) / 2;
    const HermiteValue value = hermite(a, b, middle);
    bool holds = true;
    for (const double s : {0.7 * a.s + 0.3 * b.s, middle, 0.3 * a.s + 0.7 * b.s}) {
      holds = holds && surface_distance(hermite(a, b, s).position, a.at, b.at) <= options_.surface_mm;
    }
    const ClosestPoint foot = project(value.position, a.at, b.at);
    if (holds || depth == 0 || foot.at.face < 0) {
      chain_.push_back(b);
      return;
    }
    const Vec3 normal = unit_normal(skin_.derivatives(foot.at));
    const Vec3 tangent = value.derivative - normal * normal.dot(value.derivative);
    const Node node{middle, foot.point, tangent.normalized(), foot.at};
    halve(a, node, depth - 1);
    halve(node, b, depth - 1);
  }

  // The chain as one cubic with double knots: the poles at the joints follow from their neighbours.
  BSplineCurve3 spline() const {
    BSplineCurve3 curve;
    curve.degree = 3;
    curve.poles.push_back(chain_.front().position);
    curve.knots.assign(4, chain_.front().s);
    for (std::size_t i = 0; i + 1 < chain_.size(); ++i) {
      const double h = chain_[i + 1].s - chain_[i].s;
      curve.poles.emplace_back(chain_[i].position + h / 3 * chain_[i].tangent);
      curve.poles.emplace_back(chain_[i + 1].position - h / 3 * chain_[i + 1].tangent);
      const bool end = i + 2 == chain_.size();
      curve.knots.insert(curve.knots.end(), end ? 4 : 2, chain_[i + 1].s);
    }
    curve.poles.push_back(chain_.back().position);
    return curve;
  }

  const Skin& skin_;
  PathFitOptions options_;
  std::vector<Node> nodes_, chain_;
};

std::array<double, 3> colour(std::size_t ply, int course) {
  static constexpr std::array<std::array<double, 3>, 6> palette{{{0.12, 0.47, 0.71},
                                                                 {0.84, 0.37, 0.0},
                                                                 {0.17, 0.63, 0.17},
                                                                 {0.58, 0.40, 0.74},
                                                                 {0.55, 0.34, 0.29},
                                                                 {0.80, 0.47, 0.65}}};
  if (course == 0) return {0, 0, 0};
  std::array<double, 3> rgb = palette[ply % palette.size()];
  if (course < 0) {
    for (double& channel : rgb) channel *= 0.6;
  }
  return rgb;
}

std::string signed_number(int n) { return (n > 0 ? "+" : "") + std::to_string(n); }

}  // namespace

std::vector<BSplineCurve3> fit_segment(const Skin& skin, const CourseSegment& segment,
                                       const PathFitOptions& options) {
  return SegmentFit(skin, segment, options).curves();
}

std::vector<StepWire> path_wires(const Skin& skin, const std::vector<Ply>& plies,
                                 const PathFitOptions& options) {
  std::vector<StepWire> wires;
  for (std::size_t p = 0; p < plies.size(); ++p) {
    for (const Course& course : plies[p].courses) {
      for (std::size_t i = 0; i < course.segments.size(); ++i) {
        StepWire wire;
        wire.name = "ply " + plies[p].name + " course " + signed_number(course.number) + " segment " +
                    std::to_string(i + 1);
        wire.group = "ply " + plies[p].name;
        wire.rgb = colour(p, course.number);
        wire.curves = fit_segment(skin, course.segments[i], options);
        if (!wire.curves.empty()) wires.push_back(std::move(wire));
      }
    }
  }
  return wires;
}

}  // namespace afptraj
