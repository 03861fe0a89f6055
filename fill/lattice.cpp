#include "fill/lattice.h"

#include <algorithm>
#include <cmath>

#include "geometry/error.h"

namespace afptraj {
namespace {

constexpr double half_range = 1 << 29;
constexpr double touch_units = 2;

double distance_to(const LatticeSegment& s, const LatticePoint& p) {
  const Vec2 a = s.a.real(), d = s.b.real() - a, v = p.real() - a;
  const double t = std::clamp(v.dot(d) / d.squaredNorm(), 0.0, 1.0);
  return (v - t * d).norm();
}

// Whether p lies on the segment but at none of its ends.
bool inside(const LatticeSegment& s, const LatticePoint& p, double tolerance) {
  return p != s.a && p != s.b && distance_to(s, p) <= tolerance &&
         (p.real() - s.a.real()).dot(s.b.real() - s.a.real()) > 0 &&
         (p.real() - s.b.real()).dot(s.a.real() - s.b.real()) > 0;
}

int sign(std::int64_t x) { return (x > 0) - (x < 0); }

}  // namespace

Lattice::Lattice(const std::vector<Vec2>& points, double margin_mm) {
  if (points.empty()) return;
  Vec2 lo = points.front(), hi = lo;
  for (const Vec2& p : points) lo = lo.cwiseMin(p), hi = hi.cwiseMax(p);
  half_ = (hi - lo) / 2 + Vec2::Constant(margin_mm);
  // one bit to spare for the origin, which is itself a multiple of the unit
  unit_ = std::exp2(std::ceil(std::log2(std::max(half_.maxCoeff(), 1e-6) / (half_range - 4))));
  origin_ = ((lo + hi) / (2 * unit_)).array().round() * unit_;
}

LatticePoint Lattice::snap(const Vec2& mm) const {
  const Vec2 at = (mm - origin_) / unit_;
  return {static_cast<std::int32_t>(std::lround(at.x())), static_cast<std::int32_t>(std::lround(at.y()))};
}

std::vector<LatticePoint> Lattice::frame() const {
  const auto x = static_cast<std::int32_t>(half_.x() / unit_),
             y = static_cast<std::int32_t>(half_.y() / unit_);
  return {{-x, -y}, {x, -y}, {x, y}, {-x, y}};
}

std::int64_t orientation(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c) {
  const std::int64_t abx = std::int64_t{b.x} - a.x, aby = std::int64_t{b.y} - a.y;
  const std::int64_t acx = std::int64_t{c.x} - a.x, acy = std::int64_t{c.y} - a.y;
  return abx * acy - aby * acx;
}

void for_each_close_pair(const std::vector<LatticeSegment>& segments,
                         const std::function<void(std::size_t, std::size_t)>& visit) {
  if (segments.size() < 2) return;
  Vec2 lo = segments.front().a.real(), hi = lo;
  double total = 0;
  for (const LatticeSegment& s : segments) {
    for (const LatticePoint& p : {s.a, s.b}) lo = lo.cwiseMin(p.real()), hi = hi.cwiseMax(p.real());
    total += (s.b.real() - s.a.real()).norm();
  }
  // Square cells, about as many as segments, none shorter than half the mean segment: O(n) entries.
  const double n = static_cast<double>(segments.size());
  const Vec2 size = hi - lo;
  const double cell = std::max({std::sqrt(std::max(size.x(), 1.0) * std::max(size.y(), 1.0) / n),
                                total / (2 * n), size.maxCoeff() / n, 1.0});
  const auto columns = static_cast<std::int64_t>(size.x() / cell) + 1;
  const auto rows = static_cast<std::int64_t>(size.y() / cell) + 1;
  std::vector<std::pair<std::int64_t, std::uint32_t>> entries;
  entries.reserve(2 * segments.size());
  for (std::size_t i = 0; i < segments.size(); ++i) {
    Vec2 p = segments[i].a.real() - lo, q = segments[i].b.real() - lo;
    if (p.x() > q.x()) std::swap(p, q);
    const auto first = static_cast<std::int64_t>((p.x() - 1) / cell),
               last = static_cast<std::int64_t>((q.x() + 1) / cell);
    for (std::int64_t column = std::max<std::int64_t>(first, 0); column <= std::min(last, columns - 1);
         ++column) {
      // the segment's y over this column, with a unit to spare
      const auto y_at = [&](double x) {
        return q.x() - p.x() < 1 ? p.y() : p.y() + (q.y() - p.y()) * (x - p.x()) / (q.x() - p.x());
      };
      double y0 = y_at(std::clamp(static_cast<double>(column) * cell, p.x(), q.x())),
             y1 = y_at(std::clamp(static_cast<double>(column + 1) * cell, p.x(), q.x()));
      if (q.x() - p.x() < 1) y1 = q.y();
      if (y0 > y1) std::swap(y0, y1);
      const auto low = std::max<std::int64_t>(static_cast<std::int64_t>((y0 - 4) / cell), 0),
                 high = std::min(static_cast<std::int64_t>((y1 + 4) / cell), rows - 1);
      for (std::int64_t row = low; row <= high; ++row)
        entries.emplace_back(row * columns + column, static_cast<std::uint32_t>(i));
    }
  }
  std::sort(entries.begin(), entries.end());
  const auto boxes_meet = [&](const LatticeSegment& s, const LatticeSegment& t) {
    constexpr int spare = 4;
    return std::max(s.a.x, s.b.x) + spare >= std::min(t.a.x, t.b.x) &&
           std::max(t.a.x, t.b.x) + spare >= std::min(s.a.x, s.b.x) &&
           std::max(s.a.y, s.b.y) + spare >= std::min(t.a.y, t.b.y) &&
           std::max(t.a.y, t.b.y) + spare >= std::min(s.a.y, s.b.y);
  };
  for (std::size_t begin = 0; begin < entries.size();) {
    std::size_t end = begin;
    while (end < entries.size() && entries[end].first == entries[begin].first) ++end;
    for (std::size_t i = begin; i < end; ++i) {
      for (std::size_t j = i + 1; j < end; ++j) {
        const std::size_t a = entries[i].second, b = entries[j].second;
        if (boxes_meet(segments[a], segments[b])) visit(a, b);
      }
    }
    begin = end;
  }
}

MeetingOf meeting(const LatticeSegment& first, const LatticeSegment& second) {
  MeetingOf out;
  const int a = sign(orientation(first.a, first.b, second.a)),
            b = sign(orientation(first.a, first.b, second.b));
  const int c = sign(orientation(second.a, second.b, first.a)),
            d = sign(orientation(second.a, second.b, first.b));
  const bool crosses = a * b < 0 && c * d < 0;
  // Without a crossing only exact touches matter; with one, an end that is nearly on the other is a touch.
  const double tolerance = crosses ? touch_units : 0;
  for (const LatticePoint& p : {second.a, second.b}) {
    if (out.split_first || !(crosses || orientation(first.a, first.b, p) == 0)) continue;
    if (inside(first, p, tolerance + 1e-6)) out.split_first = true, out.at_first = p;
  }
  for (const LatticePoint& p : {first.a, first.b}) {
    if (out.split_second || !(crosses || orientation(second.a, second.b, p) == 0)) continue;
    if (inside(second, p, tolerance + 1e-6)) out.split_second = true, out.at_second = p;
  }
  if (out.split_first || out.split_second) {
    out.kind = Meeting::touch;
    if (crosses && out.split_first) out.split_second = false;  // one split takes the crossing away
    return out;
  }
  if (!crosses) return out;
  const Vec2 p = first.a.real(), u = first.b.real() - p, v = second.b.real() - second.a.real();
  const Vec2 at = p + u * (cross(second.a.real() - p, v) / cross(u, v));
  out.kind = Meeting::cross;
  out.at_first = out.at_second = {static_cast<std::int32_t>(std::lround(at.x())),
                                  static_cast<std::int32_t>(std::lround(at.y()))};
  out.split_first = out.at_first != first.a && out.at_first != first.b;
  out.split_second = out.at_second != second.a && out.at_second != second.b;
  return out;
}

std::vector<LatticeSegment> split_at_meetings(std::vector<LatticeSegment> segments) {
  constexpr int most_rounds = 20;
  for (int round = 0; round < most_rounds; ++round) {
    std::erase_if(segments, [](const LatticeSegment& s) { return s.a == s.b; });
    std::vector<std::pair<std::size_t, LatticePoint>> splits;
    for_each_close_pair(segments, [&](std::size_t i, std::size_t j) {
      const MeetingOf m = meeting(segments[i], segments[j]);
      if (m.split_first) splits.emplace_back(i, m.at_first);
      if (m.split_second) splits.emplace_back(j, m.at_second);
    });
    if (splits.empty()) return segments;
    std::sort(splits.begin(), splits.end());
    splits.erase(std::unique(splits.begin(), splits.end()), splits.end());
    std::vector<LatticeSegment> next;
    next.reserve(segments.size() + splits.size());
    for (std::size_t i = 0, k = 0; i < segments.size(); ++i) {
      std::vector<LatticePoint> points{segments[i].a};
      while (k < splits.size() && splits[k].first == i) points.push_back(splits[k++].second);
      const Vec2 a = segments[i].a.real(), d = segments[i].b.real() - a;
      std::sort(points.begin() + 1, points.end(), [&](const LatticePoint& p, const LatticePoint& q) {
        return (p.real() - a).dot(d) < (q.real() - a).dot(d);
      });
      points.push_back(segments[i].b);
      for (std::size_t m = 0; m + 1 < points.size(); ++m) next.push_back({points[m], points[m + 1]});
    }
    segments = std::move(next);
  }
  throw Error(ErrorCode::no_path, "slice",
              "has edges that meet in too intricate a way; remove details smaller than a nanometre");
}

}  // namespace afptraj
