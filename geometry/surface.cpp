#include "geometry/surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "geometry/bspline_curve.h"
#include "geometry/piece_kernel.h"

namespace afptraj {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
// Up to this degree a piece is a centred monomial (Horner); above it the Bernstein form is kept,
// because the monomial coefficients of degree n lose about 2.4^n in relative accuracy.
constexpr int max_monomial_degree = 9;

using Vec4 = Eigen::Vector4d;  // homogeneous (w x, w y, w z, w)

/// The polynomial pieces of one direction: breaks, and for each span the matrix that takes the
/// degree + 1 local poles to Bernstein poles.
struct Direction {
  int degree = 1;
  std::vector<double> breaks;
  std::vector<int> first_pole;                 // by span
  std::vector<Eigen::MatrixXd> to_bernstein;   // by span
  std::vector<double> creases;
  std::vector<double> piece_lo, piece_scale;   // by span + 1: start of its interval and 2 / length
  double period = 0;
  int spans() const { return static_cast<int>(breaks.size()) - 1; }
};

/// Row i: how Bernstein pole i of [a, b] follows from the local poles; blossoming, with arguments
/// a (degree - i times) and b (i times). Source: Ramshaw 1989; The NURBS Book, ch. 5.3.
Eigen::MatrixXd bernstein_matrix(const std::vector<double>& knots, int degree, int span) {
  const auto p = static_cast<Eigen::Index>(degree);
  const double a = knots[static_cast<std::size_t>(span)], b = knots[static_cast<std::size_t>(span) + 1];
  Eigen::MatrixXd out(p + 1, p + 1);
  for (int i = 0; i <= degree; ++i) {
    Eigen::MatrixXd d = Eigen::MatrixXd::Identity(p + 1, p + 1);  // rows: de Boor points
    for (int r = 1; r <= degree; ++r) {
      const double t = r <= degree - i ? a : b;
      for (int j = degree; j >= r; --j) {
        const double lo = knots[static_cast<std::size_t>(span - degree + j)];
        const double hi = knots[static_cast<std::size_t>(span + 1 + j - r)];
        const double alpha = (t - lo) / (hi - lo);
        d.row(j) = (1 - alpha) * d.row(j - 1) + alpha * d.row(j);
      }
    }
    out.row(i) = d.row(p);
  }
  return out;
}

Direction make_direction(const std::vector<double>& knots, int degree, bool periodic) {
  Direction out;
  out.degree = degree;
  const int last = static_cast<int>(knots.size()) - degree - 1;
  for (int span = degree; span < last; ++span) {
    if (knots[static_cast<std::size_t>(span)] >= knots[static_cast<std::size_t>(span) + 1]) continue;
    out.breaks.push_back(knots[static_cast<std::size_t>(span)]);
    out.first_pole.push_back(span - degree);
    out.to_bernstein.push_back(bernstein_matrix(knots, degree, span));
  }
  out.breaks.push_back(knots[static_cast<std::size_t>(last)]);
  for (std::size_t i = 1; i + 1 < out.breaks.size(); ++i)
    if (std::count(knots.begin(), knots.end(), out.breaks[i]) >= degree) out.creases.push_back(out.breaks[i]);
  if (periodic) out.period = out.breaks.back() - out.breaks.front();
  return out;
}

/// Column j: Bernstein polynomial j of `degree` as powers of x in [-1, 1].
Eigen::MatrixXd bernstein_to_monomial(int degree) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(degree + 1, degree + 1);
  for (int j = 0; j <= degree; ++j) {
    std::vector<double> poly = {1};  // C(n, j) ((1+x)/2)^j ((1-x)/2)^(n-j)
    double binomial = 1;
    for (int k = 0; k < j; ++k) binomial = binomial * (degree - k) / (k + 1);
    for (int k = 0; k < degree; ++k) {
      const double sign = k < j ? 1 : -1;
      std::vector<double> next(poly.size() + 1, 0.0);
      for (std::size_t m = 0; m < poly.size(); ++m) {
        next[m] += 0.5 * poly[m];
        next[m + 1] += 0.5 * sign * poly[m];
      }
      poly = std::move(next);
    }
    for (int k = 0; k <= degree; ++k) out(k, j) = binomial * poly[static_cast<std::size_t>(k)];
  }
  return out;
}

/// Bernstein basis of `degree` with two derivatives with respect to x in [-1, 1].
void bernstein_basis(int degree, double x, double out[3][max_degree + 1]) {
  const double t = 0.5 * (1 + x), s = 1 - t;
  double row[max_degree + 2] = {1};
  double low[3][max_degree + 2] = {};
  for (int d = 0; d <= degree; ++d) {
    if (degree - d <= 2) std::copy(row, row + d + 1, low[degree - d]);
    if (d == degree) break;
    double saved = 0;
    for (int i = 0; i <= d; ++i) {
      const double value = row[i];
      row[i] = saved + s * value;
      saved = t * value;
    }
    row[d + 1] = saved;
  }
  const auto at = [&](int level, int i) { return i >= 0 && i <= degree - level ? low[level][i] : 0.0; };
  for (int i = 0; i <= degree; ++i) {
    out[0][i] = at(0, i);
    out[1][i] = 0.5 * degree * (at(1, i - 1) - at(1, i));
    out[2][i] = 0.25 * degree * (degree - 1) * (at(2, i - 2) - 2 * at(2, i - 1) + at(2, i));
  }
}

void evaluate_bernstein(const Vec4* c, int p, int q, double x, double y, PieceValues& out) {
  double bu[3][max_degree + 1], bv[3][max_degree + 1];
  bernstein_basis(p, x, bu);
  bernstein_basis(q, y, bv);
  Eigen::Map<Vec4> rf(out.f), rfu(out.fu), rfv(out.fv), rfuu(out.fuu), rfuv(out.fuv), rfvv(out.fvv);
  rf.setZero(), rfu.setZero(), rfv.setZero(), rfuu.setZero(), rfuv.setZero(), rfvv.setZero();
  for (int i = 0; i <= p; ++i) {
    Vec4 f = Vec4::Zero(), d = Vec4::Zero(), dd = Vec4::Zero();
    for (int j = 0; j <= q; ++j) {
      const Vec4& pole = c[i * (q + 1) + j];
      f += bv[0][j] * pole;
      d += bv[1][j] * pole;
      dd += bv[2][j] * pole;
    }
    rf += bu[0][i] * f;
    rfu += bu[1][i] * f;
    rfuu += bu[2][i] * f;
    rfv += bu[0][i] * d;
    rfuv += bu[1][i] * d;
    rfvv += bu[0][i] * dd;
  }
}

/// The linear continuation of Bernstein rows beyond an end, over a box of the neighbour's width:
/// rows of equal spacing through the end row, with the end's first derivative.
template <typename GetRow, typename SetRow>
void continue_linearly(int degree, bool beyond_last, GetRow row, SetRow set) {
  const Vec4 end = row(beyond_last ? degree : 0);
  const Vec4 step = beyond_last ? row(degree) - row(degree - 1) : row(1) - row(0);
  for (int i = 0; i <= degree; ++i) set(i, end + (beyond_last ? i : i - degree) * step);
}

int locate(const std::vector<double>& breaks, double t, double heading, bool clamp) {
  const int n = static_cast<int>(breaks.size()) - 1;
  int i = static_cast<int>(std::upper_bound(breaks.begin(), breaks.end(), t) - breaks.begin()) - 1;
  if (heading < 0 && i >= 0 && i <= n && t == breaks[static_cast<std::size_t>(i)]) --i;
  if (heading >= 0 && i == n && t == breaks.back() && heading == 0) --i;
  return clamp ? std::clamp(i, 0, n - 1) : std::clamp(i, -1, n);
}

}  // namespace

struct Surface::Data {
  SurfaceKind kind = SurfaceKind::plane;
  Frame frame;
  double radius = 0, second = 0, sin2 = 0, cos2 = 0;
  BSplineSurface spline;
  Direction u, v;
  bool rational = false, monomial = true;
  std::vector<Vec4> pieces;  // (spans_u + 2) x (spans_v + 2) pieces of (p + 1)(q + 1) coefficients

  int piece_size() const { return (u.degree + 1) * (v.degree + 1); }
  const Vec4* piece(int iu, int iv) const {
    return pieces.data() + static_cast<std::ptrdiff_t>(((iu + 1) * (v.spans() + 2) + iv + 1)) * piece_size();
  }
  static double local(const Direction& d, int i, double t) {
    return (t - d.piece_lo[static_cast<std::size_t>(i + 1)]) * d.piece_scale[static_cast<std::size_t>(i + 1)] - 1;
  }
  Vec4* piece(int iu, int iv) { return const_cast<Vec4*>(std::as_const(*this).piece(iu, iv)); }
  void build();
  void extract_pieces();
  void continue_beyond_ends();
  void to_monomials();
  double local_u(const Span& span, double t) const { return local(u, span.iu, t - span.shift_u); }
  double local_v(const Span& span, double t) const { return local(v, span.iv, t - span.shift_v); }
  SurfaceDerivatives evaluate_spline(const Span& span, const Uv& uv) const;
  Vec3 evaluate_spline_point(const Span& span, const Uv& uv) const;
  SurfaceDerivatives evaluate_analytic(const Uv& uv) const;
};

namespace {

/// The interval of a span; outer spans take the width of their neighbour.
void span_interval(const Direction& dir, int i, double& lo, double& hi) {
  const auto& b = dir.breaks;
  const int n = dir.spans();
  if (i < 0) {
    hi = b.front();
    lo = hi - (b[1] - b[0]);
  } else if (i >= n) {
    lo = b.back();
    hi = lo + (b[static_cast<std::size_t>(n)] - b[static_cast<std::size_t>(n) - 1]);
  } else {
    lo = b[static_cast<std::size_t>(i)];
    hi = b[static_cast<std::size_t>(i) + 1];
  }
}

void set_piece_intervals(Direction& dir) {
  for (int i = -1; i <= dir.spans(); ++i) {
    double lo, hi;
    span_interval(dir, i, lo, hi);
    dir.piece_lo.push_back(lo);
    dir.piece_scale.push_back(2 / (hi - lo));
  }
}

void check(const BSplineSurface& s) {
  const auto require = [](bool ok, const char* what) {
    if (!ok) throw std::invalid_argument(std::string("B-spline surface: ") + what);
  };
  require(s.degree_u >= 1 && s.degree_u <= max_degree && s.degree_v >= 1 && s.degree_v <= max_degree,
          "degrees must be 1 to 25");
  require(s.count_u() > s.degree_u && s.count_v() > s.degree_v, "fewer poles than degree + 1");
  require(s.poles.size() == static_cast<std::size_t>(s.count_u()) * static_cast<std::size_t>(s.count_v()),
          "the number of poles does not fit the knots");
  require(s.weights.empty() || s.weights.size() == s.poles.size(), "as many weights as poles are needed");
  require(std::is_sorted(s.knots_u.begin(), s.knots_u.end()) && std::is_sorted(s.knots_v.begin(), s.knots_v.end()),
          "knots must not decrease");
  for (double w : s.weights) require(w > 0 && std::isfinite(w), "weights must be positive");
  for (const Vec3& p : s.poles) require(p.allFinite(), "poles must be finite");
  const auto domain = [](const std::vector<double>& k, int p) {
    return k[k.size() - 1 - static_cast<std::size_t>(p)] - k[static_cast<std::size_t>(p)];
  };
  require(domain(s.knots_u, s.degree_u) > 0 && domain(s.knots_v, s.degree_v) > 0, "the knots span no domain");
}

}  // namespace

void Surface::Data::build() {
  u = make_direction(spline.knots_u, spline.degree_u, spline.periodic_u);
  v = make_direction(spline.knots_v, spline.degree_v, spline.periodic_v);
  set_piece_intervals(u);
  set_piece_intervals(v);
  rational = std::any_of(spline.weights.begin(), spline.weights.end(),
                         [&](double w) { return w != spline.weights.front(); });
  monomial = std::max(u.degree, v.degree) <= max_monomial_degree;
  pieces.assign(static_cast<std::size_t>((u.spans() + 2) * (v.spans() + 2) * piece_size()), Vec4::Zero());
  extract_pieces();
  continue_beyond_ends();
  if (monomial) to_monomials();
}

void Surface::Data::extract_pieces() {
  const int p = u.degree, q = v.degree, nv = spline.count_v();
  std::vector<Vec4> half(static_cast<std::size_t>(piece_size()));
  for (int iu = 0; iu < u.spans(); ++iu) {
    for (int iv = 0; iv < v.spans(); ++iv) {
      const auto& A = u.to_bernstein[static_cast<std::size_t>(iu)];
      const auto& B = v.to_bernstein[static_cast<std::size_t>(iv)];
      const int i0 = u.first_pole[static_cast<std::size_t>(iu)], j0 = v.first_pole[static_cast<std::size_t>(iv)];
      const auto pole = [&](int i, int j) {
        const auto k = static_cast<std::size_t>((i0 + i) * nv + j0 + j);
        const double w = rational ? spline.weights[k] : 1;
        Vec4 h;
        h << w * spline.poles[k], w;
        return h;
      };
      for (int i = 0; i <= p; ++i)
        for (int j = 0; j <= q; ++j) {
          Vec4 sum = Vec4::Zero();
          for (int k = 0; k <= q; ++k)
            if (B(j, k) != 0) sum += B(j, k) * pole(i, k);
          half[static_cast<std::size_t>(i * (q + 1) + j)] = sum;
        }
      Vec4* out = piece(iu, iv);
      for (int i = 0; i <= p; ++i)
        for (int j = 0; j <= q; ++j) {
          Vec4 sum = Vec4::Zero();
          for (int k = 0; k <= p; ++k) sum += A(i, k) * half[static_cast<std::size_t>(k * (q + 1) + j)];
          out[i * (q + 1) + j] = sum;
        }
    }
  }
}

void Surface::Data::continue_beyond_ends() {
  const int p = u.degree, q = v.degree, nu = u.spans(), nv = v.spans();
  for (int iu = 0; iu < nu; ++iu)
    for (const bool last : {false, true}) {
      const Vec4* in = piece(iu, last ? nv - 1 : 0);
      Vec4* out = piece(iu, last ? nv : -1);
      for (int i = 0; i <= p; ++i)
        continue_linearly(q, last, [&](int j) { return Vec4(in[i * (q + 1) + j]); },
                          [&](int j, const Vec4& value) { out[i * (q + 1) + j] = value; });
    }
  for (int iv = -1; iv <= nv; ++iv)
    for (const bool last : {false, true}) {
      const Vec4* in = piece(last ? nu - 1 : 0, iv);
      Vec4* out = piece(last ? nu : -1, iv);
      for (int j = 0; j <= q; ++j)
        continue_linearly(p, last, [&](int i) { return Vec4(in[i * (q + 1) + j]); },
                          [&](int i, const Vec4& value) { out[i * (q + 1) + j] = value; });
    }
}

void Surface::Data::to_monomials() {
  const int p = u.degree, q = v.degree;
  const Eigen::MatrixXd A = bernstein_to_monomial(p), B = bernstein_to_monomial(q);
  std::vector<Vec4> half(static_cast<std::size_t>(piece_size()));
  for (std::size_t at = 0; at < pieces.size(); at += static_cast<std::size_t>(piece_size())) {
    Vec4* c = pieces.data() + at;
    for (int i = 0; i <= p; ++i)
      for (int j = 0; j <= q; ++j) {
        Vec4 sum = Vec4::Zero();
        for (int k = 0; k <= q; ++k) sum += B(j, k) * c[i * (q + 1) + k];
        half[static_cast<std::size_t>(i * (q + 1) + j)] = sum;
      }
    for (int i = 0; i <= p; ++i)
      for (int j = 0; j <= q; ++j) {
        Vec4 sum = Vec4::Zero();
        for (int k = 0; k <= p; ++k) sum += A(i, k) * half[static_cast<std::size_t>(k * (q + 1) + j)];
        c[i * (q + 1) + j] = sum;
      }
  }
}

SurfaceDerivatives Surface::Data::evaluate_spline(const Span& span, const Uv& uv) const {
  const double su = u.piece_scale[static_cast<std::size_t>(span.iu + 1)];
  const double sv = v.piece_scale[static_cast<std::size_t>(span.iv + 1)];
  const double x = local_u(span, uv.x()), y = local_v(span, uv.y());
  const Vec4* c = piece(span.iu, span.iv);
  PieceValues values;
  if (monomial) {
    evaluate_piece(c->data(), u.degree, v.degree, x, y, values);
  } else {
    evaluate_bernstein(c, u.degree, v.degree, x, y, values);
  }
  using Row = Eigen::Map<const Vec4>;
  const struct {
    Row f, fu, fv, fuu, fuv, fvv;
  } r{Row(values.f), Row(values.fu), Row(values.fv), Row(values.fuu), Row(values.fuv), Row(values.fvv)};
  SurfaceDerivatives d;
  if (!rational) {
    d.S = r.f.head<3>();
    d.Su = r.fu.head<3>() * su;
    d.Sv = r.fv.head<3>() * sv;
    d.Suu = r.fuu.head<3>() * (su * su);
    d.Suv = r.fuv.head<3>() * (su * sv);
    d.Svv = r.fvv.head<3>() * (sv * sv);
    return d;
  }
  // Quotient rule on A / w. Source: The NURBS Book, eq. 4.20.
  const double w = 1 / r.f.w();
  const double wu = r.fu.w() * su, wv = r.fv.w() * sv;
  const double wuu = r.fuu.w() * su * su, wuv = r.fuv.w() * su * sv, wvv = r.fvv.w() * sv * sv;
  d.S = r.f.head<3>() * w;
  d.Su = (r.fu.head<3>() * su - wu * d.S) * w;
  d.Sv = (r.fv.head<3>() * sv - wv * d.S) * w;
  d.Suu = (r.fuu.head<3>() * (su * su) - 2 * wu * d.Su - wuu * d.S) * w;
  d.Suv = (r.fuv.head<3>() * (su * sv) - wu * d.Sv - wv * d.Su - wuv * d.S) * w;
  d.Svv = (r.fvv.head<3>() * (sv * sv) - 2 * wv * d.Sv - wvv * d.S) * w;
  return d;
}

Vec3 Surface::Data::evaluate_spline_point(const Span& span, const Uv& uv) const {
  if (!monomial) return evaluate_spline(span, uv).S;
  double h[4];
  evaluate_piece_point(piece(span.iu, span.iv)->data(), u.degree, v.degree, local_u(span, uv.x()), local_v(span, uv.y()),
                       h);
  const Vec3 point(h[0], h[1], h[2]);
  return rational ? Vec3(point * (1 / h[3])) : point;
}

SurfaceDerivatives Surface::Data::evaluate_analytic(const Uv& uv) const {
  const double a = uv.x(), b = uv.y();
  SurfaceDerivatives d;
  if (kind == SurfaceKind::plane) {
    d.S = frame.origin + a * frame.x + b * frame.y;
    d.Su = frame.x;
    d.Sv = frame.y;
    d.Suu = d.Suv = d.Svv = Vec3::Zero();
    return d;
  }
  // A meridian (rho(v), z(v)) turned about the axis.
  double rho = radius, rho1 = 0, rho2 = 0, z = b, z1 = 1, z2 = 0;
  if (kind == SurfaceKind::cone) {
    rho = radius + b * sin2;
    rho1 = sin2;
    z = b * cos2;
    z1 = cos2;
  } else if (kind == SurfaceKind::sphere || kind == SurfaceKind::torus) {
    const double r = kind == SurfaceKind::sphere ? radius : second;
    const double c = std::cos(b), s = std::sin(b);
    rho = (kind == SurfaceKind::sphere ? 0 : radius) + r * c;
    rho1 = -r * s;
    rho2 = -r * c;
    z = r * s;
    z1 = r * c;
    z2 = -r * s;
  }
  const double c = std::cos(a), s = std::sin(a);
  const Vec3 e = c * frame.x + s * frame.y, f = -s * frame.x + c * frame.y;
  d.S = frame.origin + rho * e + z * frame.z;
  d.Su = rho * f;
  d.Sv = rho1 * e + z1 * frame.z;
  d.Suu = -rho * e;
  d.Suv = rho1 * f;
  d.Svv = rho2 * e + z2 * frame.z;
  return d;
}

namespace {
const std::vector<double> no_breaks;
}

const char* to_string(SurfaceKind kind) {
  switch (kind) {
    case SurfaceKind::plane: return "plane";
    case SurfaceKind::cylinder: return "cylinder";
    case SurfaceKind::cone: return "cone";
    case SurfaceKind::sphere: return "sphere";
    case SurfaceKind::torus: return "torus";
    case SurfaceKind::bspline: return "B-spline";
  }
  return "";
}

namespace {
void require_positive(double value, const char* what) {
  if (!(value > 0) || !std::isfinite(value)) throw std::invalid_argument(std::string(what) + " must be positive");
}
}  // namespace

Surface Surface::plane(const Frame& frame) {
  auto data = std::make_shared<Data>();
  data->frame = frame;
  return Surface(data);
}

Surface Surface::cylinder(const Frame& frame, double radius) {
  require_positive(radius, "cylinder radius");
  auto data = std::make_shared<Data>();
  data->kind = SurfaceKind::cylinder;
  data->frame = frame;
  data->radius = radius;
  return Surface(data);
}

Surface Surface::cone(const Frame& frame, double radius, double half_angle_rad) {
  if (!(radius >= 0) || !(std::abs(half_angle_rad) < pi / 2) || half_angle_rad == 0)
    throw std::invalid_argument("cone needs a radius >= 0 and a half angle between 0 and 90 degrees");
  auto data = std::make_shared<Data>();
  data->kind = SurfaceKind::cone;
  data->frame = frame;
  data->radius = radius;
  data->second = half_angle_rad;
  data->sin2 = std::sin(half_angle_rad);
  data->cos2 = std::cos(half_angle_rad);
  return Surface(data);
}

Surface Surface::sphere(const Frame& frame, double radius) {
  require_positive(radius, "sphere radius");
  auto data = std::make_shared<Data>();
  data->kind = SurfaceKind::sphere;
  data->frame = frame;
  data->radius = radius;
  return Surface(data);
}

Surface Surface::torus(const Frame& frame, double major_radius, double minor_radius) {
  require_positive(major_radius, "torus major radius");
  require_positive(minor_radius, "torus minor radius");
  auto data = std::make_shared<Data>();
  data->kind = SurfaceKind::torus;
  data->frame = frame;
  data->radius = major_radius;
  data->second = minor_radius;
  return Surface(data);
}

Surface Surface::bspline(BSplineSurface spline) {
  check(spline);
  auto data = std::make_shared<Data>();
  data->kind = SurfaceKind::bspline;
  data->spline = std::move(spline);
  data->build();
  return Surface(data);
}

SurfaceKind Surface::kind() const { return data_->kind; }

Interval Surface::domain_u() const {
  if (data_->kind == SurfaceKind::bspline) return {data_->u.breaks.front(), data_->u.breaks.back()};
  if (data_->kind == SurfaceKind::plane) return {-infinity, infinity};
  return {0, 2 * pi};
}

Interval Surface::domain_v() const {
  switch (data_->kind) {
    case SurfaceKind::bspline: return {data_->v.breaks.front(), data_->v.breaks.back()};
    case SurfaceKind::sphere: return {-pi / 2, pi / 2};
    case SurfaceKind::torus: return {0, 2 * pi};
    default: return {-infinity, infinity};
  }
}

double Surface::period_u() const {
  if (data_->kind == SurfaceKind::bspline) return data_->u.period;
  return data_->kind == SurfaceKind::plane ? 0 : 2 * pi;
}

double Surface::period_v() const {
  if (data_->kind == SurfaceKind::bspline) return data_->v.period;
  return data_->kind == SurfaceKind::torus ? 2 * pi : 0;
}

Span Surface::span_at(const Uv& uv, const Uv& heading) const {
  Span span;
  if (data_->kind != SurfaceKind::bspline) return span;
  const auto wrap = [](const Direction& d, double t) {
    return d.period > 0 ? d.period * std::floor((t - d.breaks.front()) / d.period) : 0.0;
  };
  const auto place = [&](const Direction& d, double t, double head, int& i, double& shift) {
    shift = wrap(d, t);
    i = locate(d.breaks, t - shift, head, false);
    if (d.period > 0 && i < 0) {  // at the seam, heading back
      shift -= d.period;
      i = d.spans() - 1;
    } else if (d.period > 0 && i >= d.spans()) {
      if (head > 0) {
        shift += d.period;
        i = 0;
      } else {
        i = d.spans() - 1;
      }
    }
  };
  place(data_->u, uv.x(), heading.x(), span.iu, span.shift_u);
  place(data_->v, uv.y(), heading.y(), span.iv, span.shift_v);
  return span;
}

void Surface::span_box(const Span& span, Uv& lo, Uv& hi) const {
  lo.setConstant(-infinity);
  hi.setConstant(infinity);
  if (data_->kind != SurfaceKind::bspline) return;
  const auto box = [](const Direction& d, int i, double shift, double& a, double& b) {
    if (i >= 0) a = (i < d.spans() ? d.breaks[static_cast<std::size_t>(i)] : d.breaks.back()) + shift;
    if (i < d.spans()) b = (i < 0 ? d.breaks.front() : d.breaks[static_cast<std::size_t>(i) + 1]) + shift;
  };
  box(data_->u, span.iu, span.shift_u, lo.x(), hi.x());
  box(data_->v, span.iv, span.shift_v, lo.y(), hi.y());
}

SurfaceDerivatives Surface::derivatives(const Span& span, const Uv& uv) const {
  return data_->kind == SurfaceKind::bspline ? data_->evaluate_spline(span, uv) : data_->evaluate_analytic(uv);
}

SurfaceDerivatives Surface::derivatives(const Uv& uv) const { return derivatives(span_at(uv), uv); }

Vec3 Surface::point(const Uv& uv) const {
  if (data_->kind != SurfaceKind::bspline) return data_->evaluate_analytic(uv).S;
  return data_->evaluate_spline_point(span_at(uv), uv);
}

const std::vector<double>& Surface::breaks_u() const {
  return data_->kind == SurfaceKind::bspline ? data_->u.breaks : no_breaks;
}
const std::vector<double>& Surface::breaks_v() const {
  return data_->kind == SurfaceKind::bspline ? data_->v.breaks : no_breaks;
}

const std::vector<double>& Surface::creases_u() const {
  return data_->kind == SurfaceKind::bspline ? data_->u.creases : no_breaks;
}
const std::vector<double>& Surface::creases_v() const {
  return data_->kind == SurfaceKind::bspline ? data_->v.creases : no_breaks;
}

const BSplineSurface* Surface::spline() const {
  return data_->kind == SurfaceKind::bspline ? &data_->spline : nullptr;
}
const Frame& Surface::frame() const { return data_->frame; }
double Surface::radius() const { return data_->radius; }
double Surface::second_parameter() const { return data_->second; }

}  // namespace afptraj
