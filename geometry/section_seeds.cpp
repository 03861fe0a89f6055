#include "geometry/section_seeds.h"

#include <algorithm>
#include <cmath>

#include "geometry/bezier.h"
#include "geometry/bezier_net.h"

namespace afptraj::sections {
namespace {

/// Roots of a function along an edge: sign changes between samples, and between a sample and an
/// extremum that looks over to the other sign.
class EdgeRoots {
 public:
  EdgeRoots(const March& march, int face, const BSplineCurve2& curve)
      : march_(march), surface_(march.skin().face(face).surface), curve_(curve) {}

  std::vector<double> find() {
    const std::vector<double> breaks = curve_.breaks();
    std::vector<double> at;
    for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
      const int n = samples(breaks[i], breaks[i + 1]);
      for (int k = 0; k < n; ++k) at.push_back(breaks[i] + (breaks[i + 1] - breaks[i]) * k / n);
    }
    at.push_back(breaks.back());
    Sample last = sample(at.front());
    for (std::size_t i = 1; i < at.size(); ++i) {
      const Sample here = sample(at[i]);
      if ((last.height < 0) != (here.height < 0)) {
        solve(last, here);
      } else if ((last.rate < 0) != (here.rate < 0) && (last.rate < 0) == (last.height >= 0)) {
        // The height turns back toward the plane in between: does it reach over?
        const Sample turn = extremum(last, here);
        if ((turn.height < 0) != (last.height < 0)) {
          solve(last, turn);
          solve(turn, here);
        }
      }
      last = here;
    }
    return roots_;
  }

 private:
  struct Sample {
    double t, height, rate;
  };
  Sample sample(double t) const {
    const auto c = curve_.derivatives(t);
    const SurfaceDerivatives d = surface_.derivatives(c.c);
    return {t, march_.height(d.S), march_.height_rate(d.Su * c.d1.x() + d.Sv * c.d1.y())};
  }
  int samples(double t0, double t1) const {
    const Uv a = curve_.point(t0), b = curve_.point(t1);
    const auto crossed = [](const std::vector<double>& knots, double x, double y) {
      if (knots.empty()) return 2;
      const auto lo = std::lower_bound(knots.begin(), knots.end(), std::min(x, y));
      const auto hi = std::upper_bound(knots.begin(), knots.end(), std::max(x, y));
      return static_cast<int>(std::max<std::ptrdiff_t>(0, hi - lo));
    };
    return 6 * (1 + crossed(surface_.breaks_u(), a.x(), b.x()) + crossed(surface_.breaks_v(), a.y(), b.y()));
  }
  /// Newton, kept inside the bracket by bisection.
  void solve(Sample a, Sample b) {
    Sample x = std::abs(a.height) < std::abs(b.height) ? a : b;
    for (int i = 0; i < 100; ++i) {
      double next = x.t - x.height / x.rate;
      const double lo = std::min(a.t, b.t), hi = std::max(a.t, b.t);
      if (!(next > lo && next < hi) || i % 8 == 7) next = 0.5 * (a.t + b.t);
      if (next == x.t || next <= lo || next >= hi) break;
      const double moved = std::abs(next - x.t);
      x = sample(next);
      ((x.height < 0) == (a.height < 0) ? a : b) = x;
      if (x.height == 0 || moved <= 4e-16 * std::abs(next)) break;
    }
    roots_.push_back(x.t);
  }
  Sample extremum(Sample a, Sample b) const {
    for (int i = 0; i < 60; ++i) {
      const Sample middle = sample(0.5 * (a.t + b.t));
      ((middle.rate < 0) == (a.rate < 0) ? a : b) = middle;
    }
    return a;
  }

  const March& march_;
  const Surface& surface_;
  const BSplineCurve2& curve_;
  std::vector<double> roots_;
};

void edge_seeds(const March& march, std::vector<SurfacePoint>& out) {
  const Skin& skin = march.skin();
  for (const int f : skin.faces()) {
    const Face& face = skin.face(f);
    for (std::size_t l = 0; l < face.loops.size(); ++l) {
      for (std::size_t c = 0; c < face.loops[l].coedges.size(); ++c) {
        const EdgeUse use{f, static_cast<int>(l), static_cast<int>(c)};
        if (skin.edge(use).degenerate) continue;
        const std::optional<EdgeUse> mate = skin.mate(use);
        if (mate && (mate->face < f || (mate->face == f && mate->coedge < use.coedge))) continue;
        const BSplineCurve2& curve = face.loops[l].coedges[c].pcurve;
        for (const double t : EdgeRoots(march, f, curve).find()) out.push_back({f, curve.point(t)});
      }
    }
  }
}

/// A branch that ends in a pole may meet no other edge: it crosses lines beside the pole.
void pole_seeds(const March& march, std::vector<SurfacePoint>& out) {
  const Skin& skin = march.skin();
  for (const int f : skin.faces()) {
    const TrimRegion& trim = skin.trim(f);
    const double size = (trim.box_max() - trim.box_min()).minCoeff();
    for (const Loop& loop : skin.face(f).loops) {
      for (const Coedge& coedge : loop.coedges) {
        if (!skin.part().edges[static_cast<std::size_t>(coedge.edge)].degenerate) continue;
        const BSplineCurve2& pcurve = coedge.pcurve;
        Uv along = pcurve.point(pcurve.last()) - pcurve.point(pcurve.first());
        if (coedge.reversed) along = -along;
        const Uv inward = Uv(-along.y(), along.x()).normalized();
        if (!inward.allFinite()) continue;
        for (const double share : {1e-4, 0.1}) {
          BSplineCurve2 beside = pcurve;
          for (Uv& pole : beside.poles) pole += share * size * inward;
          for (const double t : EdgeRoots(march, f, beside).find()) {
            if (trim.contains(beside.point(t))) out.push_back({f, beside.point(t)});
          }
        }
      }
    }
  }
}

/// Closed branches inside of a B-spline face. On a Bezier piece the height is a polynomial in
/// Bernstein form (times a positive weight): of one sign, it is not crossed; monotone in one
/// direction, it holds no closed branch, so that any branch on it crosses the piece's border.
class SplineSeeds {
 public:
  SplineSeeds(const March& march, int face, std::vector<SurfacePoint>& out)
      : march_(march),
        face_(face),
        trim_(march.skin().trim(face)),
        out_(out),
        spline_(*march.skin().face(face).surface.spline()) {}

  void find() {
    const Surface& surface = march_.skin().face(face_).surface;
    const Uv box_lo = trim_.box_min(), box_hi = trim_.box_max();
    heights_.reserve(spline_.poles.size());
    for (const Vec3& p : spline_.poles) heights_.push_back(march_.height(p));
    const auto us = bezier::span_matrices(spline_.knots_u, spline_.degree_u);
    const auto vs = bezier::span_matrices(spline_.knots_v, spline_.degree_v);
    for (const auto& u : us) {
      for (const auto& v : vs) {
        if (!changes_sign(u, v)) continue;
        const Eigen::MatrixXd net = height_net(u, v);
        for (const double du : bezier::shifts(surface.period_u(), u.lo, u.hi, box_lo.x(), box_hi.x())) {
          for (const double dv : bezier::shifts(surface.period_v(), v.lo, v.hi, box_lo.y(), box_hi.y())) {
            visit(net, Uv(u.lo + du, v.lo + dv), Uv(u.hi + du, v.hi + dv), 0);
          }
        }
      }
    }
  }

 private:
  std::size_t pole(int i, int j) const { return static_cast<std::size_t>(i * spline_.count_v() + j); }

  bool changes_sign(const bezier::SpanMatrix& u, const bezier::SpanMatrix& v) const {
    bool above = false, below = false;
    for (int i = 0; i <= spline_.degree_u; ++i) {
      for (int j = 0; j <= spline_.degree_v; ++j) {
        (heights_[pole(u.first_pole + i, v.first_pole + j)] >= 0 ? above : below) = true;
      }
    }
    return above && below;
  }

  Eigen::MatrixXd height_net(const bezier::SpanMatrix& u, const bezier::SpanMatrix& v) const {
    Eigen::MatrixXd local(spline_.degree_u + 1, spline_.degree_v + 1);
    for (int i = 0; i <= spline_.degree_u; ++i) {
      for (int j = 0; j <= spline_.degree_v; ++j) {
        const std::size_t k = pole(u.first_pole + i, v.first_pole + j);
        local(i, j) = heights_[k] * (spline_.weights.empty() ? 1 : spline_.weights[k]);
      }
    }
    return u.to_bezier * local * v.to_bezier.transpose();
  }

  static bool monotone(const Eigen::MatrixXd& net, bool along_u) {
    const auto r = net.rows(), c = net.cols();
    const Eigen::MatrixXd d = along_u ? (net.bottomRows(r - 1) - net.topRows(r - 1)).eval()
                                      : (net.rightCols(c - 1) - net.leftCols(c - 1)).eval();
    return d.minCoeff() > 0 || d.maxCoeff() < 0;
  }

  void visit(const Eigen::MatrixXd& net, const Uv& lo, const Uv& hi, int depth) {
    if (net.minCoeff() > 0 || net.maxCoeff() < 0) return;
    if (trim_.classify(lo, hi) == TrimRegion::BoxState::outside) return;
    if (monotone(net, true) || monotone(net, false)) {
      border_roots(net, lo, hi);
      return;
    }
    if (depth == 12) {
      add(0.5 * (lo + hi));
      return;
    }
    Eigen::MatrixXd low, high;
    split_rows(net, low, high);
    const double middle_u = 0.5 * (lo.x() + hi.x()), middle_v = 0.5 * (lo.y() + hi.y());
    for (const bool upper_u : {false, true}) {
      Eigen::MatrixXd left, right;
      split_rows((upper_u ? high : low).transpose(), left, right);
      const double u0 = upper_u ? middle_u : lo.x(), u1 = upper_u ? hi.x() : middle_u;
      visit(left.transpose(), Uv(u0, lo.y()), Uv(u1, middle_v), depth + 1);
      visit(right.transpose(), Uv(u0, middle_v), Uv(u1, hi.y()), depth + 1);
    }
  }

  /// de Casteljau at the middle, along the rows.
  static void split_rows(Eigen::MatrixXd net, Eigen::MatrixXd& low, Eigen::MatrixXd& high) {
    const Eigen::Index n = net.rows();
    low.resize(n, net.cols());
    for (Eigen::Index k = 0; k < n; ++k) {
      low.row(k) = net.row(0);
      for (Eigen::Index i = 0; i + k + 1 < n; ++i) net.row(i) = (0.5 * (net.row(i) + net.row(i + 1))).eval();
    }
    high = std::move(net);
  }

  /// The low sides suffice: a closed branch that crosses a high side crosses its neighbour's low one.
  void border_roots(const Eigen::MatrixXd& net, const Uv& lo, const Uv& hi) {
    roots(
        net.row(0).transpose(), 0, 1, [&](double x) { add(Uv(lo.x(), lo.y() + x * (hi.y() - lo.y()))); }, 0);
    roots(
        net.col(0), 0, 1, [&](double x) { add(Uv(lo.x() + x * (hi.x() - lo.x()), lo.y())); }, 0);
  }

  template <class Found>
  void roots(const Eigen::VectorXd& c, double lo, double hi, const Found& found, int depth) const {
    int changes = 0;
    for (Eigen::Index i = 0; i + 1 < c.size(); ++i) changes += (c[i] < 0) != (c[i + 1] < 0) ? 1 : 0;
    if (changes == 0) return;
    if (depth == 40 || (changes == 1 && depth >= 6)) {
      // One root in a sixty-fourth of the side: the secant is a good start for Newton.
      const double a = c[0], b = c[c.size() - 1];
      const double x = a != b ? std::clamp(a / (a - b), 0.0, 1.0) : 0.5;
      found(lo + x * (hi - lo));
      return;
    }
    Eigen::MatrixXd low, high;
    split_rows(c, low, high);
    const double middle = 0.5 * (lo + hi);
    roots(low.col(0), lo, middle, found, depth + 1);
    roots(high.col(0), middle, hi, found, depth + 1);
  }

  void add(const Uv& near) {
    const std::optional<Uv> uv = march_.onto_plane(face_, near);
    if (uv && trim_.contains(*uv)) out_.push_back({face_, *uv});
  }

  const March& march_;
  int face_;
  const TrimRegion& trim_;
  std::vector<SurfacePoint>& out_;
  const BSplineSurface& spline_;
  std::vector<double> heights_;
};

/// Closed branches of plane and sphere or torus that meet no loop. A circle of a sphere that does is
/// found from any of its points. Branches of a torus lie symmetric to the meridian plane that holds
/// the plane's normal, and one that meets no seam crosses it.
void analytic_seeds(const March& march, const Plane& plane, int f, std::vector<SurfacePoint>& out) {
  const Surface& surface = march.skin().face(f).surface;
  const bool sphere = surface.kind() == SurfaceKind::sphere;
  if (!sphere && surface.kind() != SurfaceKind::torus) return;
  const TrimRegion& trim = march.skin().trim(f);
  const Frame& frame = surface.frame();
  const double nx = plane.normal.dot(frame.x), ny = plane.normal.dot(frame.y), nz = plane.normal.dot(frame.z);
  const double c0 = march.height(frame.origin);
  const double across = std::hypot(nx, ny);
  const double meridian = across > 0 ? std::atan2(ny, nx) : 0;
  const double R = sphere ? 0 : surface.radius(), r = sphere ? surface.radius() : surface.second_parameter();
  for (const double side : {1.0, -1.0}) {
    // Height along the meridian: a + b cos v + c sin v.
    const double a = c0 + side * across * R, b = side * across * r, c = nz * r;
    const double amplitude = std::hypot(b, c);
    if (!(std::abs(a) < amplitude)) continue;
    const double phase = std::atan2(c, b), half = std::acos(-a / amplitude);
    for (const double v : {phase + half, phase - half}) {
      double u = meridian + (side > 0 ? 0 : pi), w = v;
      if (sphere) {
        w = std::asin(std::clamp(std::sin(v), -1.0, 1.0));
        if (std::cos(v) < 0) u += pi;
      }
      for (int i = -2; i <= 2; ++i) {
        for (int j = sphere ? 0 : -2; j <= (sphere ? 0 : 2); ++j) {
          const Uv uv(u + 2 * pi * i, w + 2 * pi * j);
          if (trim.contains(uv)) out.push_back({f, uv});
        }
      }
    }
  }
}

}  // namespace

std::vector<SurfacePoint> seeds(const March& march, const Plane& plane) {
  std::vector<SurfacePoint> result;
  edge_seeds(march, result);
  pole_seeds(march, result);
  for (const int f : march.skin().faces()) {
    if (march.skin().face(f).surface.spline() != nullptr) SplineSeeds(march, f, result).find();
    analytic_seeds(march, plane, f, result);
  }
  return result;
}

}  // namespace afptraj::sections
