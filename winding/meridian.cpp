#include "winding/meridian.h"

#include <Eigen/LU>
#include <Eigen/SparseLU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/error.h"
#include "winding/number_words.h"
#include "winding/quadrature.h"

namespace afptraj {
namespace {

constexpr int samples_per_span = 32;  // where extremes and returns are looked for

[[noreturn]] void refuse(const std::string& message) {
  throw Error(ErrorCode::bad_input, "meridian", message);
}

double chord(const MeridianRow& a, const MeridianRow& b) {
  return std::hypot(b.z_mm - a.z_mm, b.r_mm - a.r_mm);
}

// The B-spline of least degree up to 3 through the rows, by chord length.
BSplineCurve2 interpolated(const std::vector<MeridianRow>& rows) {
  const std::size_t n = rows.size();
  BSplineCurve2 curve;
  curve.degree = static_cast<int>(std::min<std::size_t>(3, n - 1));
  std::vector<double> t(n, 0);
  for (std::size_t i = 1; i < n; ++i) t[i] = t[i - 1] + chord(rows[i - 1], rows[i]);
  const auto p = static_cast<std::size_t>(curve.degree);
  // Not-a-knot: of the inner points, the first and the last are no knots.
  curve.knots.assign(p + 1, t.front());
  for (std::size_t i = 2; i + 2 < n; ++i) curve.knots.push_back(t[i]);
  curve.knots.insert(curve.knots.end(), p + 1, t.back());
  Eigen::SparseMatrix<double> matrix(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(n));
  Eigen::MatrixX2d right(static_cast<Eigen::Index>(n), 2);
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t i = 0; i < n; ++i) {
    const int span = find_span(curve.knots, curve.degree, t[i]);
    double basis[3][max_degree + 1];
    basis_functions(curve.knots, curve.degree, span, t[i], basis);
    for (int k = 0; k <= curve.degree; ++k)
      entries.emplace_back(static_cast<int>(i), span - curve.degree + k, basis[0][k]);
    right.row(static_cast<Eigen::Index>(i)) << rows[i].z_mm, rows[i].r_mm;
  }
  matrix.setFromTriplets(entries.begin(), entries.end());
  Eigen::SparseLU<Eigen::SparseMatrix<double>> solver(matrix);
  if (solver.info() != Eigen::Success) refuse("has points that no curve passes in order; check the rows");
  const Eigen::MatrixX2d poles = solver.solve(right);
  for (Eigen::Index i = 0; i < poles.rows(); ++i) curve.poles.emplace_back(poles(i, 0), poles(i, 1));
  return curve;
}

// The extreme of f in [a, b] by golden sections; f is to be greatest there.
template <typename F>
double golden(const F& f, double a, double b) {
  const double ratio = (std::sqrt(5.0) - 1) / 2;
  double x = b - ratio * (b - a), y = a + ratio * (b - a);
  double fx = f(x), fy = f(y);
  for (int i = 0; i < 80 && b - a > 0; ++i) {
    if (fx > fy) {
      b = y, y = x, fy = fx;
      x = b - ratio * (b - a), fx = f(x);
    } else {
      a = x, x = y, fx = fy;
      y = a + ratio * (b - a), fy = f(y);
    }
  }
  return fx > fy ? x : y;
}

}  // namespace

double MeridianPoint::speed() const { return std::hypot(dz, dr); }

double MeridianPoint::curvature() const { return (dr * ddz - dz * ddr) / std::pow(speed(), 3); }

Meridian::Meridian(std::vector<BSplineCurve2> pieces) : pieces_(std::move(pieces)) {
  starts_.push_back(0);
  for (const BSplineCurve2& piece : pieces_) {
    const double start = starts_.back();
    const std::vector<double> knots = piece.breaks();
    for (std::size_t i = 0; i + 1 < knots.size(); ++i) breaks_.push_back(start + (knots[i] - piece.first()));
    starts_.push_back(start + (piece.last() - piece.first()));
  }
  breaks_.push_back(starts_.back());
  std::size_t piece = 0;
  for (std::size_t i = 0; i + 1 < breaks_.size(); ++i) {
    while (breaks_[i] >= starts_[piece + 1]) ++piece;
    spans_.push_back(span_of(pieces_[piece], starts_[piece], breaks_[i], breaks_[i + 1]));
  }
  require_forward();
  for (std::size_t i = 0; i + 1 < breaks_.size(); ++i) {
    length_mm_ += integral([&](double t) { return at(t).speed(); }, breaks_[i], breaks_[i + 1], 1e-12);
  }
  widest_ = extreme(1);
  narrowest_ = extreme(-1);
}

// The polynomials through degree + 1 places of the span.
Meridian::Span Meridian::span_of(const BSplineCurve2& piece, double start, double from, double to) {
  constexpr int highest_degree = 5;  // beyond, powers lose digits
  Span span{(from + to) / 2, (to - from) / 2, {}, !piece.weights.empty()};
  if (piece.degree > highest_degree) return span;
  const int n = piece.degree + 1;
  Eigen::MatrixXd matrix(n, n), right(n, 3);
  for (int i = 0; i < n; ++i) {
    const double u = -std::cos(std::numbers::pi * i / piece.degree);
    const double t = piece.first() + (span.middle - start) + span.half * u;
    const int knot_span = find_span(piece.knots, piece.degree, piece.first() + (span.middle - start));
    double basis[3][max_degree + 1];
    basis_functions(piece.knots, piece.degree, knot_span, t, basis);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int k = 0; k < n; ++k) {
      const auto pole = static_cast<std::size_t>(knot_span - piece.degree + k);
      const double w = basis[0][k] * (span.rational ? piece.weights[pole] : 1);
      sum += Eigen::Vector3d(w * piece.poles[pole].x(), w * piece.poles[pole].y(), w);
    }
    right.row(i) = sum;
    for (int k = 0; k < n; ++k) matrix(i, k) = std::pow(u, k);
  }
  const Eigen::MatrixXd powers = matrix.fullPivLu().solve(right);
  for (int k = 0; k < n; ++k) span.powers.push_back({powers(k, 0), powers(k, 1), powers(k, 2)});
  // what is constant keeps its value to the last digit
  for (std::size_t c = 0; c < 3; ++c) {
    const auto column = right.col(static_cast<Eigen::Index>(c));
    if ((column.array() != column(0)).any()) continue;
    for (auto& power : span.powers) power[c] = 0;
    span.powers.front()[c] = column(0);
  }
  return span;
}

MeridianPoint Meridian::at(double t) const {
  t = std::clamp(t, first(), last());
  const auto next = std::upper_bound(breaks_.begin() + 1, breaks_.end() - 1, t);
  const Span& span = spans_[static_cast<std::size_t>(next - breaks_.begin()) - 1];
  if (!span.powers.empty()) {
    const double u = (t - span.middle) / span.half;
    // values, first derivatives and halves of the second, by Horner's rule
    double f[3] = {}, d[3] = {}, h[3] = {};
    const std::size_t columns = span.rational ? 3 : 2;
    for (std::size_t k = span.powers.size(); k-- > 0;) {
      for (std::size_t c = 0; c < columns; ++c) {
        h[c] = h[c] * u + d[c];
        d[c] = d[c] * u + f[c];
        f[c] = f[c] * u + span.powers[k][c];
      }
    }
    const double by = 1 / span.half;
    if (!span.rational) return {f[0], f[1], d[0] * by, d[1] * by, 2 * h[0] * by * by, 2 * h[1] * by * by};
    const double w = f[2], dw = d[2], ddw = 2 * h[2];
    const double z = f[0] / w, r = f[1] / w;
    const double dz = (d[0] - z * dw) / w, dr = (d[1] - r * dw) / w;
    const double ddz = (2 * h[0] - 2 * dz * dw - z * ddw) / w, ddr = (2 * h[1] - 2 * dr * dw - r * ddw) / w;
    return {z, r, dz * by, dr * by, ddz * by * by, ddr * by * by};
  }
  const auto after = std::upper_bound(starts_.begin(), starts_.end() - 1, t);
  const auto i = static_cast<std::size_t>(after - starts_.begin()) - 1;
  const auto d = pieces_[i].derivatives(pieces_[i].first() + (t - starts_[i]));
  return {d.c.x(), d.c.y(), d.d1.x(), d.d1.y(), d.d2.x(), d.d2.y()};
}

// The nearest of many, and Newton's method.
double Meridian::nearest(double z_mm, double r_mm) const {
  constexpr int samples = 64;
  double best = first(), least = 1e300;
  for (std::size_t i = 0; i + 1 < breaks_.size(); ++i) {
    for (int k = 0; k <= samples; ++k) {
      const double t = breaks_[i] + (breaks_[i + 1] - breaks_[i]) * k / samples;
      const MeridianPoint here = at(t);
      const double far = std::hypot(here.z_mm - z_mm, here.r_mm - r_mm);
      if (far < least) least = far, best = t;
    }
  }
  for (int i = 0; i < 20; ++i) {
    const MeridianPoint here = at(best);
    best += ((z_mm - here.z_mm) * here.dz + (r_mm - here.r_mm) * here.dr) / (here.speed() * here.speed());
    best = std::clamp(best, first(), last());
  }
  return best;
}

void Meridian::require_forward() const {
  double z = at(first()).z_mm;
  for (std::size_t i = 0; i + 1 < breaks_.size(); ++i) {
    for (int k = 1; k <= samples_per_span; ++k) {
      const MeridianPoint here = at(breaks_[i] + (breaks_[i + 1] - breaks_[i]) * k / samples_per_span);
      const bool end = i + 2 == breaks_.size() && k == samples_per_span;
      if (!(here.r_mm > 0) && !(end && here.r_mm > -1e-9)) {
        refuse("reaches the axis at z = " + significant_text(here.z_mm, 6) + "; end it before");
      }
      if (here.z_mm < z - 1e-9) {
        refuse("goes back near z = " + significant_text(here.z_mm, 6) +
               "; give points with growing z, and a corner as a row that stands twice");
      }
      z = here.z_mm;
    }
  }
}

double Meridian::extreme(double sign) const {
  const auto height = [&](double t) { return sign * at(t).r_mm; };
  // Beyond rounding: on a cylinder the first place stays.
  const auto higher = [&](double t, double than) {
    return height(t) > height(than) + 1e-12 * std::abs(height(than));
  };
  double best = first();
  for (std::size_t i = 0; i + 1 < breaks_.size(); ++i) {
    const double step = (breaks_[i + 1] - breaks_[i]) / samples_per_span;
    for (int k = 0; k <= samples_per_span; ++k) {
      const double t = breaks_[i] + step * k;
      if (higher(t, best)) best = t;
    }
  }
  const double step = (last() - first()) / static_cast<double>(samples_per_span * breaks_.size());
  const double refined = golden(height, std::max(first(), best - step), std::min(last(), best + step));
  return higher(refined, best) ? refined : best;
}

Meridian meridian_through(const std::vector<MeridianRow>& rows) {
  if (rows.size() < 2) refuse("has fewer than two points; give more rows");
  std::vector<BSplineCurve2> pieces;
  std::vector<MeridianRow> run{rows.front()};
  const auto finish = [&] {
    if (run.size() > 1) pieces.push_back(interpolated(run));
    run = {run.back()};
  };
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (chord(run.back(), rows[i]) > 0) {
      run.push_back(rows[i]);
    } else {
      finish();
    }
  }
  finish();
  if (pieces.empty()) refuse("has all its points at one place; give others");
  return Meridian(std::move(pieces));
}

}  // namespace afptraj
