#include "fill/planar.h"

#include <algorithm>
#include <cmath>

namespace afptraj {
namespace {

// The angle that a piece sweeps, signed.
double sweep(const ArcRing::Piece& piece, const Vec2& to) {
  if (piece.turn == 0) return 0;
  const Vec2 a = piece.from - piece.centre, b = to - piece.centre;
  double angle = std::atan2(cross(a, b), a.dot(b));
  // Ends that coincide up to rounding are a piece of no length, not a full circle.
  if (piece.turn > 0 && angle < -1e-7) angle += 2 * pi;
  if (piece.turn < 0 && angle > 1e-7) angle -= 2 * pi;
  return angle;
}

const Vec2& end_of(const ArcRing& ring, std::size_t i) {
  return ring.pieces[i + 1 == ring.pieces.size() ? 0 : i + 1].from;
}

}  // namespace

double length_mm(const Polyline& line) {
  double sum = 0;
  const std::size_t n = line.points.size();
  for (std::size_t i = 0; i + 1 < n; ++i) sum += (line.points[i + 1] - line.points[i]).norm();
  if (line.closed && n > 1) sum += (line.points.front() - line.points.back()).norm();
  return sum;
}

double signed_area(const std::vector<Vec2>& points) {
  double sum = 0;
  if (points.empty()) return 0;
  const Vec2 origin = points.front();  // keeps the products small
  for (std::size_t i = 1; i + 1 < points.size(); ++i)
    sum += cross(points[i] - origin, points[i + 1] - origin);
  return sum / 2;
}

Polyline simplified(const Polyline& line, double tolerance_mm) {
  std::vector<Vec2> points = line.points;
  if (points.size() < 3) return line;
  if (line.closed) points.push_back(points.front());
  std::vector<char> keep(points.size(), 0);
  keep.front() = keep.back() = 1;
  std::vector<std::pair<std::size_t, std::size_t>> open{{0, points.size() - 1}};
  while (!open.empty()) {
    const auto [from, to] = open.back();
    open.pop_back();
    const Vec2 &a = points[from], d = points[to] - a;
    const double squared = d.squaredNorm();
    double worst = tolerance_mm;
    std::size_t at = from;
    for (std::size_t i = from + 1; i < to; ++i) {
      const Vec2 v = points[i] - a;
      const double t = squared > 0 ? std::clamp(v.dot(d) / squared, 0.0, 1.0) : 0.0;
      const double off = (v - t * d).norm();
      if (off > worst) worst = off, at = i;
    }
    if (at == from) continue;
    keep[at] = 1;
    open.emplace_back(from, at);
    open.emplace_back(at, to);
  }
  Polyline out{{}, line.closed};
  for (std::size_t i = 0; i + (line.closed ? 1 : 0) < points.size(); ++i) {
    if (keep[i]) out.points.push_back(points[i]);
  }
  return out;
}

double length_mm(const ArcRing& ring) {
  double sum = 0;
  for (std::size_t i = 0; i < ring.pieces.size(); ++i) {
    const ArcRing::Piece& piece = ring.pieces[i];
    const Vec2& to = end_of(ring, i);
    sum += piece.turn == 0 ? (to - piece.from).norm()
                           : std::abs(sweep(piece, to)) * (piece.from - piece.centre).norm();
  }
  return sum;
}

double signed_area(const ArcRing& ring) {
  std::vector<Vec2> corners;
  double sum = 0;
  for (std::size_t i = 0; i < ring.pieces.size(); ++i) {
    const ArcRing::Piece& piece = ring.pieces[i];
    corners.push_back(piece.from);
    if (piece.turn == 0) continue;
    const double angle = sweep(piece, end_of(ring, i));
    sum += (piece.from - piece.centre).squaredNorm() * (angle - std::sin(angle)) / 2;
  }
  return sum + signed_area(corners);
}

ArcRing reversed(const ArcRing& ring) {
  ArcRing out;
  out.pieces.reserve(ring.pieces.size());
  for (std::size_t i = ring.pieces.size(); i-- > 0;)
    out.pieces.push_back({end_of(ring, i), ring.pieces[i].centre, -ring.pieces[i].turn});
  return out;
}

ArcRing moved_back(const ArcRing& level, double by_mm) {
  ArcRing out;
  const std::size_t n = level.pieces.size();
  for (std::size_t i = 0; i < n; ++i) {
    const ArcRing::Piece& piece = level.pieces[i];
    const Vec2 &from = piece.from, &to = end_of(level, i);
    if ((to - from).norm() < 1e-12) continue;
    // the direction to the nearest place of the boundary
    const auto outward = [&](const Vec2& at) -> Vec2 {
      if (piece.turn == 0) return -left_of(to - from).normalized();
      return (piece.centre - at).normalized() * (piece.turn < 0 ? 1 : -1);
    };
    out.pieces.push_back({from + by_mm * outward(from), piece.centre, piece.turn});
    // the corner's arc, up to the next piece
    out.pieces.push_back({to + by_mm * outward(to), to, 1});
  }
  return out;
}

Polyline flattened(const ArcRing& ring, double tolerance_mm) {
  Polyline out{{}, true};
  const auto add = [&](const Vec2& p) {
    if (out.points.empty() || (p - out.points.back()).norm() > 1e-9) out.points.push_back(p);
  };
  for (std::size_t i = 0; i < ring.pieces.size(); ++i) {
    const ArcRing::Piece& piece = ring.pieces[i];
    add(piece.from);
    if (piece.turn == 0) continue;
    const Vec2 arm = piece.from - piece.centre;
    const double angle = sweep(piece, end_of(ring, i)), radius = arm.norm();
    // the sagitta of a chord over the angle a is r (1 - cos(a / 2))
    const double step = 2 * std::acos(std::clamp(1 - tolerance_mm / radius, 0.0, 1.0));
    const int count = static_cast<int>(std::ceil(std::abs(angle) / std::max(step, 1e-4)));
    for (int k = 1; k < count; ++k) add(piece.centre + Eigen::Rotation2Dd(angle * k / count) * arm);
  }
  while (out.points.size() > 1 && (out.points.back() - out.points.front()).norm() <= 1e-9)
    out.points.pop_back();
  return out;
}

}  // namespace afptraj
