#include "geometry/trim_segments.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "geometry/bezier.h"

namespace afptraj::trim {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Control = std::vector<Eigen::Vector3d>;

int exact_orientation(const Uv& a, const Uv& b, const Uv& c) {
  return CGAL::orientation(Kernel::Point_2(a.x(), a.y()), Kernel::Point_2(b.x(), b.y()),
                           Kernel::Point_2(c.x(), c.y()));
}

/// Whether the ray from p to +u crosses a chord, or p is on the curve.
enum class Ray { miss, cross, on };

Ray operator^(Ray x, Ray y) {
  if (x == Ray::on || y == Ray::on) return Ray::on;
  return x == y ? Ray::miss : Ray::cross;
}

/// The half-open rule a.v <= p.v < b.v (or the reverse) counts a vertex once.
Ray cross_chord(const Uv& p, const Uv& a, const Uv& b) {
  const bool below_a = a.y() <= p.y();
  const bool below_b = b.y() <= p.y();
  if (below_a == below_b) return Ray::miss;
  if (p.x() < std::min(a.x(), b.x())) return Ray::cross;
  if (p.x() > std::max(a.x(), b.x())) return Ray::miss;
  const int side = exact_orientation(a, b, p);
  if (side == 0) return Ray::on;
  return (side > 0) == below_a ? Ray::cross : Ray::miss;
}

/// As cross_chord for the true curve between a and b. The curve and its chord lie in one convex
/// band; from outside of it both are crossed equally often, so only a point within is refined.
Ray cross_curve(const Uv& p, const Uv& a, const Uv& b, Control control, double eps, double on, int depth) {
  const double distance = chord_distance(p, a, b);
  if (distance > eps + on) return cross_chord(p, a, b);
  if (eps <= on || depth == 60) return Ray::on;
  Control left = bezier::split_half(control);
  const Uv middle = project(left.back());
  const double eps_left = hull_deviation(left, a, middle);
  const double eps_right = hull_deviation(control, middle, b);
  return cross_curve(p, a, middle, std::move(left), eps_left, on, depth + 1) ^
         cross_curve(p, middle, b, std::move(control), eps_right, on, depth + 1);
}

/// Homogeneous Bezier points of each piece of a pcurve, with its parameter range.
struct Piece {
  Control control;
  double t0, t1;
};

std::vector<Piece> bezier_pieces(const BSplineCurve2& curve) {
  std::vector<Piece> pieces;
  const int last = static_cast<int>(curve.knots.size()) - curve.degree - 2;
  for (int span = curve.degree; span <= last; ++span) {
    const double t0 = curve.knots[static_cast<std::size_t>(span)];
    const double t1 = curve.knots[static_cast<std::size_t>(span) + 1];
    if (!(t0 < t1)) continue;
    Control poles;
    for (int i = span - curve.degree; i <= span; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double w = curve.weights.empty() ? 1 : curve.weights[k];
      poles.emplace_back(w * curve.poles[k].x(), w * curve.poles[k].y(), w);
    }
    pieces.push_back({bezier::from_span(curve.knots, curve.degree, span, poles), t0, t1});
  }
  return pieces;
}

void reverse(std::vector<Piece>& pieces) {
  std::reverse(pieces.begin(), pieces.end());
  for (Piece& piece : pieces) {
    std::reverse(piece.control.begin(), piece.control.end());
    std::swap(piece.t0, piece.t1);
  }
}

double power_of_two_scale(double length) {
  int exponent = 0;
  std::frexp(length, &exponent);
  return std::ldexp(1.0, -exponent);
}

}  // namespace

double chord_distance(const Uv& p, const Uv& a, const Uv& b) {
  const Uv d = b - a;
  const Uv r = p - a;
  const double dd = d.squaredNorm();
  const double s = dd > 0 ? std::clamp(r.dot(d) / dd, 0.0, 1.0) : 0.0;
  return (r - s * d).norm();
}

double hull_deviation(const std::vector<Eigen::Vector3d>& control, const Uv& a, const Uv& b) {
  double most = 0;
  for (const Eigen::Vector3d& c : control) most = std::max(most, chord_distance(project(c), a, b));
  return most;
}

SegmentGrid::SegmentGrid(const Face& face, double flatten_uv) : loops(face.loops) {
  if (!(flatten_uv > 0 && flatten_uv < 1))
    throw std::invalid_argument("TrimRegion: flatten_uv must be in (0, 1)");
  set_scale();
  for (std::size_t i = 0; i < loops.size(); ++i) flatten(static_cast<int>(i), loops[i], flatten_uv);
  if (segments.empty()) throw std::invalid_argument("TrimRegion: the face has no trim loop");
  build_cells();
  fill_states();
}

void SegmentGrid::set_scale() {
  constexpr double inf = std::numeric_limits<double>::infinity();
  box_lo.setConstant(inf);
  box_hi.setConstant(-inf);
  for (const Loop& loop : loops) {
    for (const Coedge& coedge : loop.coedges) {
      for (const Uv& pole : coedge.pcurve.poles) {
        box_lo = box_lo.cwiseMin(pole);
        box_hi = box_hi.cwiseMax(pole);
      }
    }
  }
  if (!box_lo.allFinite() || !box_hi.allFinite()) {
    throw std::invalid_argument("TrimRegion: the face has no trim loop, or one that is not finite");
  }
  const Uv size = box_hi - box_lo;
  const double least = std::max(size.maxCoeff(), std::numeric_limits<double>::min()) * 1e-12;
  scale.x() = power_of_two_scale(std::max(size.x(), least));
  scale.y() = power_of_two_scale(std::max(size.y(), least));
  const double most = std::max(scaled(box_lo).cwiseAbs().maxCoeff(), scaled(box_hi).cwiseAbs().maxCoeff());
  on = 1e-13 * std::max(1.0, most);
}

void SegmentGrid::flatten(int loop, const Loop& chain, double tolerance) {
  const std::size_t first = segments.size();
  const auto emit = [&](Uv a, const Uv& b, const Control& c, double eps, double t0, double t1, int coedge) {
    if (segments.size() > first) {
      const Segment last = segments.back();
      if (a != last.b) {
        if ((a - last.b).norm() > on) {
          // A gap between two coedges is closed by a straight joint, so that the polygon is closed.
          segments.push_back(
              {last.b, a, 0, last.t1, last.t1, loop, last.coedge, static_cast<int>(control.size()), 1});
          control.emplace_back(last.b.x(), last.b.y(), 1);
          control.emplace_back(a.x(), a.y(), 1);
        } else {
          a = last.b;
        }
      }
    }
    if (a == b && eps <= on) return;
    const int degree = static_cast<int>(c.size()) - 1;
    segments.push_back({a, b, eps, t0, t1, loop, coedge, static_cast<int>(control.size()), degree});
    control.insert(control.end(), c.begin(), c.end());
  };
  struct Work {
    Piece piece;
    int depth;
  };
  for (std::size_t k = 0; k < chain.coedges.size(); ++k) {
    std::vector<Piece> pieces = bezier_pieces(chain.coedges[k].pcurve);
    if (chain.coedges[k].reversed) reverse(pieces);
    for (Piece& piece : pieces) {
      for (Eigen::Vector3d& c : piece.control) c.head<2>() = c.head<2>().cwiseProduct(scale);
      std::vector<Work> stack{{std::move(piece), 0}};
      while (!stack.empty()) {
        Work work = std::move(stack.back());
        stack.pop_back();
        Piece& p = work.piece;
        const Uv a = project(p.control.front());
        const Uv b = project(p.control.back());
        const double eps = hull_deviation(p.control, a, b);
        if (eps <= tolerance || work.depth == 24) {
          emit(a, b, p.control, eps, p.t0, p.t1, static_cast<int>(k));
          continue;
        }
        Control left = bezier::split_half(p.control);
        const double middle = 0.5 * (p.t0 + p.t1);
        stack.push_back({{p.control, middle, p.t1}, work.depth + 1});
        stack.push_back({{std::move(left), p.t0, middle}, work.depth + 1});
      }
    }
  }
  if (segments.size() == first) return;
  Segment& begin = segments[first];
  Segment& end = segments.back();
  if ((begin.a - end.b).norm() <= on) {
    end.b = begin.a;
  } else {
    const Segment last = end;
    const Uv target = begin.a;
    segments.push_back(
        {last.b, target, 0, last.t1, last.t1, loop, last.coedge, static_cast<int>(control.size()), 1});
    control.emplace_back(last.b.x(), last.b.y(), 1);
    control.emplace_back(target.x(), target.y(), 1);
  }
}

void SegmentGrid::build_cells() {
  Uv hi = Uv::Constant(-std::numeric_limits<double>::infinity());
  lo = -hi;
  double widest = on;
  for (const Segment& s : segments) {
    lo = lo.cwiseMin(s.a.cwiseMin(s.b));
    hi = hi.cwiseMax(s.a.cwiseMax(s.b));
    widest = std::max(widest, s.eps);
  }
  // The loops' box: end points, and the hull where a piece is curved.
  Uv hull_lo = lo, hull_hi = hi;
  for (const Segment& s : segments) {
    for (int k = 1; s.eps > on && k < s.degree; ++k) {
      const Uv c = project(control[static_cast<std::size_t>(s.control + k)]);
      hull_lo = hull_lo.cwiseMin(c);
      hull_hi = hull_hi.cwiseMax(c);
    }
  }
  box_lo = hull_lo.cwiseQuotient(scale);
  box_hi = hull_hi.cwiseQuotient(scale);
  const double margin = 2 * (widest + on) + 1e-9;
  lo.array() -= margin;
  hi.array() += margin;
  const int n = std::clamp(static_cast<int>(2 * std::sqrt(static_cast<double>(segments.size()))), 32, 128);
  nx = ny = n;
  cells_per_unit = Uv::Constant(n).cwiseQuotient(hi - lo);

  std::vector<std::vector<int>> cell(static_cast<std::size_t>(nx * ny));
  std::vector<std::vector<int>> row(static_cast<std::size_t>(ny));
  for (std::size_t index = 0; index < segments.size(); ++index) {
    const Segment& s = segments[index];
    const double e = s.eps + on + 1e-12;
    const Uv low = s.a.cwiseMin(s.b).array() - e;
    const Uv high = s.a.cwiseMax(s.b).array() + e;
    int i0, i1, j0, j1;
    if (!cells(low, high, i0, i1, j0, j1)) continue;
    const Uv d = s.b - s.a;
    for (int j = j0; j <= j1; ++j) {
      row[static_cast<std::size_t>(j)].push_back(static_cast<int>(index));
      // The part of the chord that comes within e of this row.
      const double v0 = lo.y() + j / cells_per_unit.y() - 2 * e;
      const double v1 = lo.y() + (j + 1) / cells_per_unit.y() + 2 * e;
      double x0 = 0, x1 = 1;
      if (d.y() != 0) {
        const double p = (v0 - s.a.y()) / d.y();
        const double q = (v1 - s.a.y()) / d.y();
        x0 = std::clamp(std::min(p, q), 0.0, 1.0);
        x1 = std::clamp(std::max(p, q), 0.0, 1.0);
      }
      const double ua = s.a.x() + x0 * d.x();
      const double ub = s.a.x() + x1 * d.x();
      int a0, a1, b0, b1;
      if (!cells(Uv(std::min(ua, ub) - 2 * e, low.y()), Uv(std::max(ua, ub) + 2 * e, high.y()), a0, a1, b0,
                 b1))
        continue;
      for (int i = a0; i <= a1; ++i)
        cell[static_cast<std::size_t>(j * nx + i)].push_back(static_cast<int>(index));
    }
  }
  const auto pack = [](const std::vector<std::vector<int>>& lists, std::vector<int>& begin,
                       std::vector<int>& items) {
    begin.assign(1, 0);
    for (const std::vector<int>& list : lists) {
      items.insert(items.end(), list.begin(), list.end());
      begin.push_back(static_cast<int>(items.size()));
    }
  };
  pack(cell, cell_begin, cell_segments);
  pack(row, row_begin, row_segments);
}

void SegmentGrid::fill_states() {
  state.assign(static_cast<std::size_t>(nx * ny), CellState::mixed);
  mixed_before.assign(static_cast<std::size_t>((nx + 1) * (ny + 1)), 0);
  for (int j = 0; j < ny; ++j) {
    for (int i = 0; i < nx; ++i) {
      const auto k = static_cast<std::size_t>(j * nx + i);
      const bool empty = cell_begin[k] == cell_begin[k + 1];
      if (empty) {
        // Nothing lies between this cell and an empty one beside it.
        const bool known = i > 0 && state[k - 1] != CellState::mixed;
        const Uv centre = lo + Uv(i + 0.5, j + 0.5).cwiseQuotient(cells_per_unit);
        state[k] = known ? state[k - 1] : contains_in_row(centre, j) ? CellState::inside : CellState::outside;
      }
      const auto at = [this](int x, int y) -> int& {
        return mixed_before[static_cast<std::size_t>(y * (nx + 1) + x)];
      };
      at(i + 1, j + 1) = at(i, j + 1) + at(i + 1, j) - at(i, j) + (empty ? 0 : 1);
    }
  }
}

bool SegmentGrid::contains(const Uv& p) const {
  int i0, i1, j0, j1;
  if (!cells(p, p, i0, i1, j0, j1)) return false;
  const CellState cell = cell_state(i0, j0);
  if (cell != CellState::mixed) return cell == CellState::inside;
  return contains_in_row(p, j0);
}

bool SegmentGrid::contains_in_row(const Uv& p, int row) const {
  const auto r = static_cast<std::size_t>(row);
  Ray ray = Ray::miss;
  for (int k = row_begin[r]; k < row_begin[r + 1]; ++k) {
    const Segment& s = segments[static_cast<std::size_t>(row_segments[static_cast<std::size_t>(k)])];
    const double e = s.eps + on;
    if (p.x() > std::max(s.a.x(), s.b.x()) + e) continue;
    if (p.y() > std::max(s.a.y(), s.b.y()) + e || p.y() < std::min(s.a.y(), s.b.y()) - e) continue;
    if (p.x() < std::min(s.a.x(), s.b.x()) - e || chord_distance(p, s.a, s.b) > e) {
      ray = ray ^ cross_chord(p, s.a, s.b);
    } else if (s.eps <= on) {
      return true;
    } else {
      const auto first = control.begin() + s.control;
      ray = ray ^ cross_curve(p, s.a, s.b, Control(first, first + s.degree + 1), s.eps, on, 0);
    }
    if (ray == Ray::on) return true;
  }
  return ray == Ray::cross;
}

}  // namespace afptraj::trim
