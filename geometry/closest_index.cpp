#include "geometry/closest_index.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "geometry/bezier_net.h"

namespace afptraj::closest {
namespace {

using bezier::Net;
using bezier::SpanMatrix;

/// A patch is split until it is thinner than this share of its width: normals turn by about 0.4
/// rad, so that a distance has hardly more than one minimum on it.
constexpr double flatness = 0.03;
constexpr int most_splits = 9;

/// Greatest second difference along the lines of one direction: how much it bends.
double bend(const std::vector<Vec3>& points, int p, int q, bool along_u) {
  double most = 0;
  const int lines = along_u ? q + 1 : p + 1;
  const int count = along_u ? p + 1 : q + 1;
  for (int l = 0; l < lines; ++l) {
    const auto at = [&](int k) -> const Vec3& {
      return points[static_cast<std::size_t>(along_u ? k * (q + 1) + l : l * (q + 1) + k)];
    };
    for (int k = 1; k + 1 < count; ++k) most = std::max(most, (at(k + 1) - 2 * at(k) + at(k - 1)).norm());
  }
  return most;
}

/// Axes along the net's mid direction and normal; any orthonormal ones where it is degenerate.
Eigen::Matrix3d axes_of(const SurfaceDerivatives& d, const std::vector<Vec3>& points, int q) {
  Vec3 x = d.Su.norm() >= d.Sv.norm() * 1e-9 ? d.Su : Vec3(points.back() - points.front());
  if (x.norm() == 0) x = points[static_cast<std::size_t>(q)] - points.front();
  if (x.norm() == 0) x = Vec3::UnitX();
  x.normalize();
  Vec3 z = d.Su.cross(d.Sv);
  z -= z.dot(x) * x;
  if (z.norm() <= 1e-12 * d.Su.norm() * d.Sv.norm() || z.norm() == 0) z = x.unitOrthogonal();
  z.normalize();
  Eigen::Matrix3d axes;
  axes.row(0) = x;
  axes.row(1) = z.cross(x);
  axes.row(2) = z;
  return axes;
}

class PatchBuilder {
 public:
  PatchBuilder(const Surface& surface, int face, const TrimRegion& trim, std::vector<Patch>& out)
      : surface_(surface),
        p_(surface.spline()->degree_u),
        q_(surface.spline()->degree_v),
        face_(face),
        trim_(trim),
        out_(out) {}

  void add(Net net, const Span& span, const Uv& lo, const Uv& hi) {
    span_ = span;
    span_lo_ = lo;
    span_hi_ = hi;
    split(std::move(net), lo, hi, 0);
  }

 private:
  void split(Net net, const Uv& lo, const Uv& hi, int depth) {
    const TrimRegion::BoxState state = trim_.classify(lo, hi);
    if (state == TrimRegion::BoxState::outside) return;
    std::vector<Vec3> points;
    points.reserve(net.size());
    for (const Eigen::Vector4d& h : net) points.push_back(h.head<3>() / h.w());
    const Uv mid = 0.5 * (lo + hi);
    const SurfaceDerivatives d = surface_.derivatives(span_, mid);
    Patch patch;
    patch.axes = axes_of(d, points, q_);
    Vec3 least = Vec3::Constant(std::numeric_limits<double>::infinity()), most = -least;
    for (const Vec3& p : points) {
      const Vec3 local = patch.axes * p;
      least = least.cwiseMin(local);
      most = most.cwiseMax(local);
    }
    const Vec3 half = 0.5 * (most - least);
    if (depth < most_splits && half.z() > flatness * std::max(half.x(), half.y())) {
      const double bend_u = bend(points, p_, q_, true), bend_v = bend(points, p_, q_, false);
      const bool along_u = bend_u >= bend_v;
      Net lower = bezier::split_net(net, p_, q_, along_u);
      Uv low_hi = hi, high_lo = lo;
      const int axis = along_u ? 0 : 1;
      low_hi[axis] = high_lo[axis] = mid[axis];
      split(std::move(lower), lo, low_hi, depth + 1);
      split(std::move(net), high_lo, hi, depth + 1);
      return;
    }
    // Rounding of the projected net: a few ulp of the coordinates.
    const double margin = 1e-14 * (least.cwiseAbs().maxCoeff() + most.cwiseAbs().maxCoeff());
    patch.half = half.array() + margin;
    patch.centre = patch.axes.transpose() * (0.5 * (least + most));
    patch.face = face_;
    patch.span = span_;
    patch.lo = lo;
    patch.hi = hi;
    patch.span_lo = span_lo_;
    patch.span_hi = span_hi_;
    patch.inside = state == TrimRegion::BoxState::inside;
    patch.mid_uv = mid;
    patch.mid = d.S;
    Eigen::Matrix<double, 3, 2> J;
    J << d.Su, d.Sv;
    Eigen::Matrix2d gram = J.transpose() * J;
    gram.diagonal().array() += 1e-12 * gram.trace() + std::numeric_limits<double>::min();
    patch.to_uv = gram.inverse() * J.transpose();
    out_.push_back(patch);
  }

  const Surface& surface_;
  int p_, q_, face_;
  const TrimRegion& trim_;
  std::vector<Patch>& out_;
  Span span_;
  Uv span_lo_, span_hi_;
};

/// Pieces of a curve on a surface, halved until nearly straight.
class CurveBuilder {
 public:
  CurveBuilder(const Surface& surface, int face, std::vector<CurvePiece>& out)
      : surface_(surface), face_(face), out_(out) {}

  void add(const std::shared_ptr<const BSplineCurve2>& curve, bool crease) {
    curve_ = curve;
    crease_ = crease;
    const std::vector<double> breaks = curve->breaks();
    for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
      // Samples see the waves of the surface only if there are some for each of its spans.
      const int parts = spans_crossed(breaks[i], breaks[i + 1]);
      const double dt = (breaks[i + 1] - breaks[i]) / parts;
      for (int k = 0; k < parts; ++k) {
        const double t1 = k + 1 == parts ? breaks[i + 1] : breaks[i] + (k + 1) * dt;
        split(breaks[i] + k * dt, t1, 0);
      }
    }
  }

 private:
  Vec3 at(double t) const { return surface_.point(curve_->point(t)); }

  int spans_crossed(double t0, double t1) const {
    Uv lo = curve_->point(t0), hi = lo;
    for (int i = 1; i <= 8; ++i) {
      const Uv p = curve_->point(t0 + (t1 - t0) * i / 8);
      lo = lo.cwiseMin(p);
      hi = hi.cwiseMax(p);
    }
    const auto inside = [](const std::vector<double>& knots, double a, double b) {
      return std::upper_bound(knots.begin(), knots.end(), b) -
             std::lower_bound(knots.begin(), knots.end(), a);
    };
    return 1 + static_cast<int>(inside(surface_.breaks_u(), lo.x(), hi.x()) +
                                inside(surface_.breaks_v(), lo.y(), hi.y()));
  }

  void split(double t0, double t1, int depth) {
    constexpr int samples = 8;
    const Vec3 a = at(t0), b = at(t1);
    CurvePiece piece{face_, curve_, t0, t1, crease_, a, b, 0};
    double deviation = 0, length = 0;
    Vec3 last = a;
    for (int i = 1; i <= samples; ++i) {
      const Vec3 p = i == samples ? b : at(t0 + (t1 - t0) * i / samples);
      deviation = std::max(deviation, piece.distance(p));
      length += (p - last).norm();
      last = p;
    }
    if (depth < 10 && deviation > flatness * length && length > 1e-9) {
      const double middle = 0.5 * (t0 + t1);
      split(t0, middle, depth + 1);
      split(middle, t1, depth + 1);
      return;
    }
    // Between samples a smooth bow rises by at most (1/8)^2 of itself; 1.5 leaves room for knots.
    piece.radius = 1.5 * deviation + 1e-14 * (a.norm() + b.norm());
    out_.push_back(std::move(piece));
  }

  const Surface& surface_;
  int face_;
  std::vector<CurvePiece>& out_;
  std::shared_ptr<const BSplineCurve2> curve_;
  bool crease_ = false;
};

/// Interior knots as often repeated as the degree: the tangent may jump there.
std::vector<double> crease_knots(const std::vector<double>& knots, int degree) {
  std::vector<double> result;
  const double first = knots[static_cast<std::size_t>(degree)];
  const double last = knots[knots.size() - 1 - static_cast<std::size_t>(degree)];
  for (std::size_t i = 0; i < knots.size();) {
    std::size_t end = i;
    while (end < knots.size() && knots[end] == knots[i]) ++end;
    if (knots[i] > first && knots[i] < last && end - i >= static_cast<std::size_t>(degree))
      result.push_back(knots[i]);
    i = end;
  }
  return result;
}

}  // namespace

Box::Box() : lo(Vec3::Constant(std::numeric_limits<double>::infinity())), hi(-lo) {}
void Box::add(const Vec3& p) {
  lo = lo.cwiseMin(p);
  hi = hi.cwiseMax(p);
}
void Box::add(const Box& other) {
  lo = lo.cwiseMin(other.lo);
  hi = hi.cwiseMax(other.hi);
}

double CurvePiece::distance(const Vec3& p) const {
  const Vec3 d = b - a, r = p - a;
  const double dd = d.squaredNorm();
  const double s = dd > 0 ? std::clamp(r.dot(d) / dd, 0.0, 1.0) : 0.0;
  return std::max(0.0, (r - s * d).norm() - radius);
}

std::vector<Patch> patches_of(const Surface& surface, int face, const TrimRegion& trim) {
  std::vector<Patch> result;
  const BSplineSurface& spline = *surface.spline();
  PatchBuilder builder(surface, face, trim, result);
  const std::vector<SpanMatrix> us = bezier::span_matrices(spline.knots_u, spline.degree_u);
  const std::vector<SpanMatrix> vs = bezier::span_matrices(spline.knots_v, spline.degree_v);
  const Uv box_lo = trim.box_min(), box_hi = trim.box_max();
  for (const SpanMatrix& u : us) {
    for (const SpanMatrix& v : vs) {
      for (const double du : bezier::shifts(surface.period_u(), u.lo, u.hi, box_lo.x(), box_hi.x())) {
        for (const double dv : bezier::shifts(surface.period_v(), v.lo, v.hi, box_lo.y(), box_hi.y())) {
          const Uv lo(u.lo + du, v.lo + dv), hi(u.hi + du, v.hi + dv);
          if (trim.classify(lo, hi) == TrimRegion::BoxState::outside) continue;
          builder.add(bezier::bezier_net(spline, u, v), Span{u.index, v.index, du, dv}, lo, hi);
        }
      }
    }
  }
  return result;
}

std::vector<CurvePiece> curves_of(const Face& face, int index, const TrimRegion& trim) {
  std::vector<CurvePiece> result;
  CurveBuilder builder(face.surface, index, result);
  for (const Loop& loop : face.loops) {
    for (const Coedge& coedge : loop.coedges) {
      builder.add(std::make_shared<const BSplineCurve2>(coedge.pcurve), false);
    }
  }
  const BSplineSurface* spline = face.surface.spline();
  if (spline == nullptr) return result;
  const Uv lo = trim.box_min(), hi = trim.box_max();
  for (const double u : crease_knots(spline->knots_u, spline->degree_u)) {
    for (const double du : bezier::shifts(face.surface.period_u(), u, u, lo.x(), hi.x())) {
      if (u + du <= lo.x() || u + du >= hi.x()) continue;
      builder.add(std::make_shared<const BSplineCurve2>(line_segment(Uv(u + du, lo.y()), Uv(u + du, hi.y()))),
                  true);
    }
  }
  for (const double v : crease_knots(spline->knots_v, spline->degree_v)) {
    for (const double dv : bezier::shifts(face.surface.period_v(), v, v, lo.y(), hi.y())) {
      if (v + dv <= lo.y() || v + dv >= hi.y()) continue;
      builder.add(std::make_shared<const BSplineCurve2>(line_segment(Uv(lo.x(), v + dv), Uv(hi.x(), v + dv))),
                  true);
    }
  }
  return result;
}

Box box_of(const Patch& patch) {
  const Vec3 reach = patch.axes.cwiseAbs().transpose() * patch.half;
  Box box;
  box.add(patch.centre - reach);
  box.add(patch.centre + reach);
  return box;
}

Box box_of(const CurvePiece& piece) {
  Box box;
  box.add(piece.a);
  box.add(piece.b);
  box.lo.array() -= piece.radius;
  box.hi.array() += piece.radius;
  return box;
}

Box box_of_analytic(const Surface& surface, const TrimRegion& trim) {
  // Bilinear interpolation between corners of cells is off by at most
  // (du^2 max|Suu| + dv^2 max|Svv|) / 8.
  constexpr int n = 32;
  const Uv lo = trim.box_min(), step = (trim.box_max() - lo) / n;
  double suu = 0, svv = 0;
  switch (surface.kind()) {
    case SurfaceKind::cylinder:
      suu = surface.radius();
      break;
    case SurfaceKind::cone: {
      const double slope = std::abs(std::sin(surface.second_parameter()));
      suu = std::abs(surface.radius()) + slope * std::max(std::abs(lo.y()), std::abs(trim.box_max().y()));
      break;
    }
    case SurfaceKind::sphere:
      suu = svv = surface.radius();
      break;
    case SurfaceKind::torus:
      suu = surface.radius() + surface.second_parameter();
      svv = surface.second_parameter();
      break;
    default:
      break;
  }
  Box box;
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) box.add(surface.point(lo + Uv(i * step.x(), j * step.y())));
  }
  const double margin = (step.x() * step.x() * suu + step.y() * step.y() * svv) / 8;
  box.lo.array() -= margin;
  box.hi.array() += margin;
  return box;
}

Tree::Tree(const std::vector<Box>& boxes) {
  if (boxes.empty()) return;
  std::vector<int> items(boxes.size());
  std::iota(items.begin(), items.end(), 0);
  nodes_.reserve(2 * boxes.size());
  build(boxes, items, 0, static_cast<int>(items.size()));
}

int Tree::build(const std::vector<Box>& boxes, std::vector<int>& items, int begin, int end) {
  const auto index = nodes_.size();
  nodes_.emplace_back();
  Box box, centres;
  for (int k = begin; k < end; ++k) {
    const Box& b = boxes[static_cast<std::size_t>(items[static_cast<std::size_t>(k)])];
    box.add(b);
    centres.add(0.5 * (b.lo + b.hi));
  }
  nodes_[index].box = box;
  if (end - begin == 1) {
    nodes_[index].item = items[static_cast<std::size_t>(begin)];
    return static_cast<int>(index);
  }
  int axis = 0;
  (centres.hi - centres.lo).maxCoeff(&axis);
  const int middle = (begin + end) / 2;
  std::nth_element(items.begin() + begin, items.begin() + middle, items.begin() + end, [&](int a, int b) {
    const Box &x = boxes[static_cast<std::size_t>(a)], &y = boxes[static_cast<std::size_t>(b)];
    const double ca = x.lo[axis] + x.hi[axis], cb = y.lo[axis] + y.hi[axis];
    return ca != cb ? ca < cb : a < b;
  });
  const int left = build(boxes, items, begin, middle);
  const int right = build(boxes, items, middle, end);
  nodes_[index].left = left;
  nodes_[index].right = right;
  return static_cast<int>(index);
}

}  // namespace afptraj::closest
