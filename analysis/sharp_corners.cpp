#include "analysis/sharp_corners.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace afptraj {
namespace {

// A path whose points can be asked for the first one, onward, that is a distance away: a tree of boxes.
class Walk {
 public:
  // `points` as they follow each other; a closed path goes round as often as is asked for.
  Walk(std::vector<Vec2> points, bool closed)
      : points_(std::move(points)), n_(points_.size()), closed_(closed) {
    size_ = 1;
    while (size_ < n_) size_ *= 2;
    boxes_.resize(2 * size_);
    for (std::size_t i = 0; i < n_; ++i) boxes_[size_ + i] = {points_[i], points_[i]};
    for (std::size_t i = size_; i-- > 1;)
      boxes_[i] = {boxes_[2 * i].lo.cwiseMin(boxes_[2 * i + 1].lo),
                   boxes_[2 * i].hi.cwiseMax(boxes_[2 * i + 1].hi)};
    sums_.assign(n_ + 1, 0);
    for (std::size_t i = 0; i < n_; ++i) sums_[i + 1] = sums_[i] + cross(at(i), at(i + 1));
  }
  const Vec2& at(std::size_t i) const { return points_[i % n_]; }

  // Where the path, from point i on, first leaves the disc round it, and twice the area that it sweeps about
  // the point until there. Nothing when it does not.
  struct Exit {
    Vec2 at;
    double swept;
  };
  std::optional<Exit> exit(std::size_t i, double radius) const {
    const Vec2 p = at(i);
    std::size_t k = first_outside(1, 0, size_, i + 1, p, radius);
    if (k == n_) {
      if (!closed_) return std::nullopt;
      k = first_outside(1, 0, size_, 0, p, radius);
      if (k >= i) return std::nullopt;
      k += n_;
    }
    const Vec2 a = at(k - 1) - p, d = at(k) - at(k - 1);
    // |a + t d| = radius, the greater root: a is inside
    const double A = d.squaredNorm(), B = a.dot(d), C = a.squaredNorm() - radius * radius;
    const double t = std::clamp((-B + std::sqrt(std::max(0.0, B * B - A * C))) / A, 0.0, 1.0);
    Exit out{at(k - 1) + t * d, 0};
    // the sum of cross(q_j - p, q_{j+1} - p) over i ... k - 2, from sums of cross(q_j, q_{j+1}), and the last
    // piece
    const double sum = k - 1 <= n_ ? sums_[k - 1] - sums_[i] : sums_[n_] - sums_[i] + sums_[k - 1 - n_];
    out.swept = sum - cross(p, at(k - 1)) + cross(a, Vec2(out.at - p));
    return out;
  }

 private:
  struct Box {
    Vec2 lo = Vec2::Constant(HUGE_VAL), hi = Vec2::Constant(-HUGE_VAL);
  };
  std::size_t first_outside(std::size_t node, std::size_t begin, std::size_t count, std::size_t from,
                            const Vec2& p, double radius) const {
    if (begin >= n_ || begin + count <= from) return n_;
    const Box& box = boxes_[node];
    const Vec2 far = (p - box.lo).cwiseAbs().cwiseMax((box.hi - p).cwiseAbs());
    if (far.squaredNorm() < radius * radius) return n_;
    if (count == 1) return begin;
    const std::size_t left = first_outside(2 * node, begin, count / 2, from, p, radius);
    return left < n_ ? left : first_outside(2 * node + 1, begin + count / 2, count / 2, from, p, radius);
  }

  std::vector<Vec2> points_;
  std::size_t n_, size_ = 1;
  bool closed_;
  std::vector<Box> boxes_;
  std::vector<double> sums_;  // of cross(q_j, q_{j+1})
};

}  // namespace

std::vector<double> area_invariants(const Polyline& path, double radius_mm) {
  const std::size_t n = path.points.size();
  std::vector<double> out(n, -1);
  if (n < 3) return out;
  std::vector<Vec2> points = path.points, back;
  const Vec2 origin = points.front();  // keeps the sums small
  for (Vec2& p : points) p -= origin;
  back.assign(points.rbegin(), points.rend());
  const Walk forward(points, path.closed), backward(back, path.closed);
  for (std::size_t i = 0; i < n; ++i) {
    const auto ahead = forward.exit(i, radius_mm), behind = backward.exit(n - 1 - i, radius_mm);
    if (!ahead || !behind) continue;
    const Vec2 &p = points[i], u = ahead->at - p, v = behind->at - p;
    // left side: the sector from the way ahead, anticlockwise, to the way behind, and the areas between
    // path and radii; the way behind is walked backwards
    double angle = std::atan2(cross(u, v), u.dot(v));
    if (angle < 0) angle += 2 * pi;
    const double left = (angle * radius_mm * radius_mm + ahead->swept - behind->swept) / 2;
    const double share = left / (pi * radius_mm * radius_mm);
    out[i] = std::max(share, 1 - share);
  }
  return out;
}

std::vector<Vec2> sharp_corners(const Polyline& path, const SharpCornerOptions& options) {
  const std::vector<double> shares = area_invariants(path, options.radius_mm);
  std::vector<std::size_t> heads;  // the first point of each cluster
  std::vector<Vec2> out;
  std::size_t last = 0;
  for (std::size_t i = 0; i < shares.size(); ++i) {
    if (shares[i] < 1 - options.threshold) continue;
    if (heads.empty() || (path.points[i] - path.points[last]).norm() > options.cluster_mm) {
      heads.push_back(i);
      out.push_back(path.points[i]);
    }
    last = i;
  }
  if (path.closed && heads.size() > 1 &&
      (path.points[last] - path.points[heads.front()]).norm() <= options.cluster_mm)
    out.pop_back();
  return out;
}

}  // namespace afptraj
