#include "occt_skin.h"

#include <BRepBndLib.hxx>
#include <BRepBuilderAPI_MakeVertex.hxx>
#include <BRepExtrema_DistShapeShape.hxx>
#include <BRepTools.hxx>
#include <BRep_Tool.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Vertex.hxx>
#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

namespace oracle {
namespace {

Vec xyz(const gp_Pnt& p) { return p.XYZ(); }
Vec xyz(const gp_Vec& v) { return v.XYZ(); }

// Seeds along a direction: some per knot span, at least a dozen.
int seed_count(int spans) { return std::clamp(4 * spans, 12, 400); }

}  // namespace

Vec Jet::normal() const {
  const Vec n = Su ^ Sv;
  const double length = n.Modulus();
  const double scale = Su.Modulus() * Sv.Modulus();
  return length > 1e-12 * scale && length > 1e-300 ? n / length : Vec(0, 0, 0);
}

double Jet::normal_curvature(const Vec& t) const {
  const double E = Su * Su, F = Su * Sv, G = Sv * Sv, det = E * G - F * F;
  if (!(det > 0)) return 0;
  const double a = t * Su, b = t * Sv;
  const double du = (G * a - F * b) / det, dv = (E * b - F * a) / det;
  const double first = E * du * du + 2 * F * du * dv + G * dv * dv;
  return normal() * (Suu * (du * du) + Suv * (2 * du * dv) + Svv * (dv * dv)) / first;
}

double Jet::gaussian() const {
  const double E = Su * Su, F = Su * Sv, G = Sv * Sv, det = E * G - F * F;
  if (!(det > 0)) return 0;
  const Vec n = normal();
  const double L = Suu * n, M = Suv * n, N = Svv * n;
  return (L * N - M * M) / det;
}

Skin::Skin(const std::vector<TopoDS_Face>& faces, double join_mm) : join_mm_(join_mm) {
  Bnd_Box all;
  for (const TopoDS_Face& face : faces) {
    FaceData data;
    data.face = face;
    data.surface = BRep_Tool::Surface(face);
    while (const auto* trimmed = dynamic_cast<Geom_RectangularTrimmedSurface*>(data.surface.get()))
      data.surface = trimmed->BasisSurface();
    BRepTools::UVBounds(face, data.box[0], data.box[1], data.box[2], data.box[3]);
    double u0, u1, v0, v1;
    data.surface->Bounds(u0, u1, v0, v1);
    data.domain = {u0, u1, v0, v1};
    if (data.surface->IsUPeriodic())
      data.period_u = data.surface->UPeriod();
    else if (data.surface->IsUClosed())
      data.period_u = u1 - u0;
    if (data.surface->IsVPeriodic())
      data.period_v = data.surface->VPeriod();
    else if (data.surface->IsVClosed())
      data.period_v = v1 - v0;
    data.classifier = std::make_unique<BRepTopAdaptor_FClass2d>(face, 1e-9);
    BRepBndLib::AddOptimal(face, data.bounds, false, false);
    all.Add(data.bounds);
    add_seeds(data);
    faces_.push_back(std::move(data));
  }
  if (faces_.empty()) throw std::runtime_error("no face");
  diagonal_ = std::sqrt(all.SquareExtent());
  for (int i = 0; i < size(); ++i) add_edges(i);
}

void Skin::add_seeds(FaceData& data) const {
  int spans_u = 1, spans_v = 1;
  if (const auto* spline = dynamic_cast<Geom_BSplineSurface*>(data.surface.get())) {
    spans_u = spline->NbUKnots() - 1;
    spans_v = spline->NbVKnots() - 1;
  }
  constexpr int edge = 8;  // a block holds edge x edge seeds
  const auto rounded = [](int n) { return (n + edge - 1) / edge * edge; };
  const int nu = rounded(seed_count(spans_u)), nv = rounded(seed_count(spans_v));
  const auto& b = data.box;
  for (int i0 = 0; i0 < nu; i0 += edge) {
    for (int j0 = 0; j0 < nv; j0 += edge) {
      Block block{data.seeds.size(), 0, Vec(0, 0, 0), 0};
      for (int i = i0; i < i0 + edge; ++i) {
        for (int j = j0; j < j0 + edge; ++j) {
          const double u = b[0] + (b[1] - b[0]) * i / (nu - 1), v = b[2] + (b[3] - b[2]) * j / (nv - 1);
          data.seeds.push_back({u, v, xyz(data.surface->Value(u, v))});
          block.centre += data.seeds.back().p / (edge * edge);
        }
      }
      block.last = data.seeds.size();
      for (std::size_t k = block.first; k < block.last; ++k)
        block.radius = std::max(block.radius, (data.seeds[k].p - block.centre).Modulus());
      data.blocks.push_back(block);
    }
  }
}

void Skin::add_edges(int index) {
  const FaceData& data = faces_[static_cast<std::size_t>(index)];
  for (TopExp_Explorer it(data.face, TopAbs_EDGE); it.More(); it.Next()) {
    const TopoDS_Edge edge = TopoDS::Edge(it.Current());
    EdgeData e;
    e.face = index;
    e.pcurve = BRep_Tool::CurveOnSurface(edge, data.face, e.first, e.last);
    if (e.pcurve.IsNull()) continue;
    double first, last;
    e.curve = BRep_Tool::Curve(edge, first, last);
    e.seam = BRep_Tool::IsClosed(edge, data.face);
    e.pole = BRep_Tool::Degenerated(edge);
    constexpr int count = 400;
    for (int k = 0; k <= count; ++k) {
      const double t = e.first + (e.last - e.first) * k / count;
      const gp_Pnt2d c = e.pcurve->Value(t);
      e.t.push_back(t);
      e.samples.push_back(xyz(data.surface->Value(c.X(), c.Y())));
    }
    e.reach = 0;
    for (int k = 0; k < count; ++k)
      e.reach = std::max(
          e.reach,
          (e.samples[static_cast<std::size_t>(k) + 1] - e.samples[static_cast<std::size_t>(k)]).Modulus());
    edges_.push_back(std::move(e));
  }
}

void Skin::wrap(const FaceData& data, double& u, double& v) const {
  const auto into = [](double x, double lo, double period) {
    if (period == 0) return x;
    return x - period * std::floor((x - lo) / period);
  };
  u = into(u, data.box[0], data.period_u);
  v = into(v, data.box[2], data.period_v);
}

Jet Skin::jet(int face, double u, double v) const {
  const FaceData& data = faces_[static_cast<std::size_t>(face)];
  wrap(data, u, v);
  const double uc = data.period_u == 0 ? std::clamp(u, data.domain[0], data.domain[1]) : u;
  const double vc = data.period_v == 0 ? std::clamp(v, data.domain[2], data.domain[3]) : v;
  gp_Pnt p;
  gp_Vec su, sv, suu, svv, suv;
  if (u == uc && v == vc) {
    data.surface->D2(u, v, p, su, sv, suu, svv, suv);
    return {xyz(p), xyz(su), xyz(sv), xyz(suu), xyz(suv), xyz(svv)};
  }
  // Beyond the end of the surface it goes on straight; the end polynomial would bend away wildly.
  gp_Vec suuu, svvv, suuv, suvv;
  data.surface->D3(uc, vc, p, su, sv, suu, svv, suv, suuu, svvv, suuv, suvv);
  const double du = u - uc, dv = v - vc;
  Jet j{xyz(p) + xyz(su) * du + xyz(sv) * dv + xyz(suv) * (du * dv),
        xyz(su),
        xyz(sv),
        Vec(0, 0, 0),
        xyz(suv),
        Vec(0, 0, 0)};
  if (du == 0) {
    j.Su += xyz(suv) * dv;
    j.Suu = xyz(suu) + xyz(suuv) * dv;
    j.Suv = xyz(suv);
  } else if (dv == 0) {
    j.Sv += xyz(suv) * du;
    j.Svv = xyz(svv) + xyz(suvv) * du;
  } else {
    j.Su += xyz(suv) * dv;
    j.Sv += xyz(suv) * du;
  }
  return j;
}

Foot Skin::foot(int face, const Vec& p, double u, double v) const {
  const FaceData& data = faces_[static_cast<std::size_t>(face)];
  const double range_u = data.box[1] - data.box[0], range_v = data.box[3] - data.box[2];
  const auto limited = [&](double& x, double& y) {
    const double slack = 0.5;  // of the trim box: far enough for feet just outside
    if (data.period_u == 0) x = std::clamp(x, data.box[0] - slack * range_u, data.box[1] + slack * range_u);
    if (data.period_v == 0) y = std::clamp(y, data.box[2] - slack * range_v, data.box[3] + slack * range_v);
    wrap(data, x, y);
  };
  limited(u, v);
  Jet j = jet(face, u, v);
  Foot best{face, u, v, j.S, (j.S - p).Modulus()};
  for (int iteration = 0; iteration < 60; ++iteration) {
    const Vec r = j.S - p;
    const double g = r * j.Su, h = r * j.Sv;
    const double E = j.Su * j.Su, F = j.Su * j.Sv, G = j.Sv * j.Sv;
    double a = E + r * j.Suu, b = F + r * j.Suv, c = G + r * j.Svv;
    if (!(a > 0) || !(a * c - b * b > 1e-12 * a * c)) {
      // Gauss-Newton, damped where the surface is singular.
      const double damp = 1e-9 * std::max(E, G);
      a = E + damp, b = F, c = G + damp;
    }
    const double det = a * c - b * b;
    if (!(det > 0)) break;
    double du = (b * h - c * g) / det, dv = (b * g - a * h) / det;
    const double cut = std::max(std::abs(du) / (0.2 * range_u), std::abs(dv) / (0.2 * range_v));
    if (cut > 1) du /= cut, dv /= cut;
    const bool last = (j.Su * du + j.Sv * dv).Modulus() < 1e-11;
    // Never farther than before: without this, Newton wanders where the surface has a kink.
    bool better = false;
    for (int halving = 0; halving < 30 && !better; ++halving, du *= 0.5, dv *= 0.5) {
      double x = u + du, y = v + dv;
      limited(x, y);
      const Jet next = jet(face, x, y);
      const double distance = (next.S - p).Modulus();
      better = distance < best.distance || (last && distance <= best.distance + 1e-12);
      if (!better && last) break;
      if (better) {
        u = x, v = y, j = next;
        best = {face, u, v, j.S, distance};
      }
    }
    if (!better || last) break;
  }
  return best;
}

Foot Skin::nearest_on(int face, const Vec& p) const {
  const FaceData& data = faces_[static_cast<std::size_t>(face)];
  // The best seed of each of the nearest blocks starts one Newton.
  std::vector<std::pair<double, const Block*>> order;
  for (const Block& block : data.blocks)
    order.emplace_back((p - block.centre).Modulus() - block.radius, &block);
  std::sort(order.begin(), order.end());
  std::vector<std::pair<double, const Seed*>> starts;
  for (const auto& [bound, block] : order) {
    if (starts.size() >= 4 && bound > starts.front().first) break;
    const Seed* nearest = nullptr;
    double least = 1e300;
    for (std::size_t k = block->first; k < block->last; ++k) {
      const double d = (data.seeds[k].p - p).Modulus();
      if (d < least) least = d, nearest = &data.seeds[k];
    }
    starts.emplace_back(least, nearest);
    std::sort(starts.begin(), starts.end());
  }
  Foot best;
  for (std::size_t k = 0; k < std::min<std::size_t>(starts.size(), 4); ++k) {
    const Foot f = foot(face, p, starts[k].second->u, starts[k].second->v);
    if (f.distance < best.distance) best = f;
  }
  return best;
}

bool Skin::inside(int face, double u, double v) const {
  const FaceData& data = faces_[static_cast<std::size_t>(face)];
  wrap(data, u, v);
  return data.classifier->Perform(gp_Pnt2d(u, v), true) != TopAbs_OUT;
}

Foot Skin::nearest(const Vec& p, const Foot* hint, double good_mm) const {
  Foot best, best_inside;
  const auto take = [&](const Foot& f) {
    if (f.distance < best.distance) best = f;
    if (f.distance < best_inside.distance && inside(f.face, f.u, f.v)) best_inside = f;
  };
  if (hint && hint->face >= 0) {
    take(foot(hint->face, p, hint->u, hint->v));
    if (best_inside.distance <= good_mm) return best_inside;
  }
  for (int i = 0; i < size(); ++i) {
    const Bnd_Box& bounds = faces_[static_cast<std::size_t>(i)].bounds;
    const double reach = std::min(best.distance, best_inside.distance);
    Bnd_Box point;
    point.Add(gp_Pnt(p));
    if (reach < 1e299 && bounds.Distance(point) > reach + join_mm_) continue;
    take(nearest_on(i, p));
  }
  // Newton from seeds can end in a false minimum: before a distance is believed, OCCT's own extrema must
  // agree.
  if (std::min(best.distance, best_inside.distance) > 1e-6) {
    const TopoDS_Vertex vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(p));
    for (int i = 0; i < size(); ++i) {
      Bnd_Box point;
      point.Add(gp_Pnt(p));
      const FaceData& data = faces_[static_cast<std::size_t>(i)];
      if (data.bounds.Distance(point) > std::min(best.distance, best_inside.distance)) continue;
      BRepExtrema_DistShapeShape extrema(vertex, data.face);
      if (!extrema.IsDone() || extrema.NbSolution() == 0 || extrema.Value() > best_inside.distance) continue;
      double u, v;
      if (extrema.SupportTypeShape2(1) != BRepExtrema_IsInFace) continue;
      extrema.ParOnFaceS2(1, u, v);
      take(foot(i, p, u, v));
    }
  }
  // A foot just outside the trim loops is right for points on the boundary (pcurve against 3-D curve).
  return best_inside.distance <= best.distance + 1e-9 || best.face < 0 ? best_inside : best;
}

std::optional<Foot> Skin::other_face_at(const Vec& p, int except) const {
  std::optional<Foot> best;
  Bnd_Box point;
  point.Add(gp_Pnt(p));
  for (int i = 0; i < size(); ++i) {
    if (i == except || faces_[static_cast<std::size_t>(i)].bounds.Distance(point) > join_mm_) continue;
    const Foot f = nearest_on(i, p);
    if (f.distance > join_mm_ || (best && best->distance <= f.distance)) continue;
    if (inside(i, f.u, f.v)) {
      best = f;
      continue;
    }
    // Within the join tolerance of its boundary is at its boundary.
    const Jet j = jet(i, f.u, f.v);
    const auto& b = box(i);
    const double du = 0.5 * join_mm_ / std::max(j.Su.Modulus(), 1e-12),
                 dv = 0.5 * join_mm_ / std::max(j.Sv.Modulus(), 1e-12);
    for (int k = 0; k < 8; ++k) {
      const double u = std::clamp(f.u + du * std::cos(k * 0.785398163397448), b[0], b[1]);
      const double v = std::clamp(f.v + dv * std::sin(k * 0.785398163397448), b[2], b[3]);
      if (inside(i, u, v) && (jet(i, u, v).S - p).Modulus() <= join_mm_) {
        best = f;
        break;
      }
    }
  }
  return best;
}

BoundaryFoot Skin::boundary(const Vec& p) const {
  BoundaryFoot best;
  int best_face = -1;
  double to_pole = 1e300;
  for (const EdgeData& e : edges_) {
    const FaceData& data = faces_[static_cast<std::size_t>(e.face)];
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t k = 0; k < e.samples.size(); ++k) order.emplace_back((e.samples[k] - p).Modulus(), k);
    std::sort(order.begin(), order.end());
    if (e.pole) to_pole = std::min(to_pole, order.front().first);
    if (order.front().first > best.on_pcurve + e.reach) continue;
    const auto at = [&](double t, Vec& tangent) {
      gp_Pnt2d c;
      gp_Vec2d dc;
      e.pcurve->D1(t, c, dc);
      gp_Pnt s;
      gp_Vec du, dv;
      data.surface->D1(c.X(), c.Y(), s, du, dv);
      tangent = xyz(du) * dc.X() + xyz(dv) * dc.Y();
      return xyz(s);
    };
    for (std::size_t n = 0; n < 2; ++n) {
      // Bisection on (C(t) - p).C'(t), which is monotone between the neighbours of a nearest sample.
      const std::size_t k = order[n].second;
      double lo = e.t[k > 0 ? k - 1 : 0], hi = e.t[std::min(k + 1, e.t.size() - 1)];
      for (int i = 0; i < 90 && hi - lo > 1e-15 * (std::abs(lo) + std::abs(hi)); ++i) {
        const double t = 0.5 * (lo + hi);
        Vec tangent;
        const Vec c = at(t, tangent);
        ((c - p) * tangent < 0 ? lo : hi) = t;
      }
      const double t = 0.5 * (lo + hi);
      Vec tangent;
      double distance = (at(t, tangent) - p).Modulus();
      for (const double end : {e.first, e.last})
        distance = std::min(distance, (at(end, tangent) - p).Modulus());
      if (distance < best.on_pcurve) {
        best.on_pcurve = distance;
        best.on_curve = e.curve.IsNull() ? distance : (xyz(e.curve->Value(t)) - p).Modulus();
        best.seam = e.seam;
        best.pole = e.pole;
        best_face = e.face;
      }
    }
  }
  // The edges that run into a pole come within 1e-6 mm of what stands that near to it: that is the pole all the same.
  best.pole = best.pole || to_pole < 1e-6;
  if (best_face >= 0) best.shared = other_face_at(p, best_face).has_value();
  return best;
}

std::vector<Skin::AreaSample> Skin::area_samples(int count) const {
  // A coarse pass measures the area of each face over its trim box, a second one samples.
  const auto sample = [&](int face, int nu, int nv, std::vector<AreaSample>& out) {
    const auto& b = box(face);
    const double du = (b[1] - b[0]) / nu, dv = (b[3] - b[2]) / nv;
    for (int i = 0; i < nu; ++i) {
      for (int j = 0; j < nv; ++j) {
        const double u = b[0] + (i + 0.5) * du, v = b[2] + (j + 0.5) * dv;
        if (!inside(face, u, v)) continue;
        const Jet d = jet(face, u, v);
        out.push_back({{face, u, v, d.S, 0}, (d.Su ^ d.Sv).Modulus() * du * dv});
      }
    }
  };
  std::vector<double> areas;
  double total = 0;
  for (int i = 0; i < size(); ++i) {
    std::vector<AreaSample> coarse;
    sample(i, 24, 24, coarse);
    double area = 0;
    for (const AreaSample& s : coarse) area += s.area;
    areas.push_back(area);
    total += area;
  }
  std::vector<AreaSample> out;
  for (int i = 0; i < size(); ++i) {
    const auto& b = box(i);
    double length_u = 0, length_v = 0;
    for (int k = 0; k < 16; ++k) {
      const double x = (k + 0.5) / 16;
      length_u += jet(i, b[0] + x * (b[1] - b[0]), 0.5 * (b[2] + b[3])).Su.Modulus() * (b[1] - b[0]) / 16;
      length_v += jet(i, 0.5 * (b[0] + b[1]), b[2] + x * (b[3] - b[2])).Sv.Modulus() * (b[3] - b[2]) / 16;
    }
    const double wanted = std::max(200.0, count * areas[static_cast<std::size_t>(i)] / total);
    const double ratio = std::clamp(length_u / std::max(length_v, 1e-12), 0.01, 100.0);
    const int nu = std::max(8, static_cast<int>(std::ceil(std::sqrt(wanted * ratio))));
    const int nv = std::max(8, static_cast<int>(std::ceil(std::sqrt(wanted / ratio))));
    sample(i, nu, nv, out);
  }
  return out;
}

}  // namespace oracle
