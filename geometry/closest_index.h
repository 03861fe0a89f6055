#pragma once

#include <memory>
#include <vector>

#include "geometry/part.h"
#include "geometry/trim_region.h"

/// The pieces a closest-point search walks over. Internal to this room; see closest_point.h.
namespace afptraj::closest {

/// An axis-aligned box of space.
struct Box {
  Vec3 lo, hi;
  Box();
  void add(const Vec3& p);
  void add(const Box& other);
  double distance2(const Vec3& p) const { return (lo - p).cwiseMax(p - hi).cwiseMax(0.0).squaredNorm(); }
};

/// A piece of one polynomial of a B-spline face: small enough to be nearly flat, inside the box
/// spanned by `half` about `centre` along the rows of `axes` (hull of its Bezier points).
struct Patch {
  int face;
  Span span;
  Uv lo, hi, span_lo, span_hi;
  bool inside;  ///< no trim loop passes through it
  Vec3 centre, half;
  Eigen::Matrix3d axes;
  Uv mid_uv;
  Vec3 mid;
  Eigen::Matrix<double, 2, 3> to_uv;  ///< (u, v) from mid_uv by an offset from `mid`, to first order

  double distance2(const Vec3& p) const {
    return ((axes * (p - centre)).cwiseAbs() - half).cwiseMax(0.0).squaredNorm();
  }
};

/// A piece of a trim loop, or of a crease inside a face (a knot line where the tangent may jump).
/// The curve lies within `radius` of the chord a-b.
struct CurvePiece {
  int face;
  std::shared_ptr<const BSplineCurve2> curve;
  double t0, t1;
  bool crease;
  Vec3 a, b;
  double radius;
  double distance(const Vec3& p) const;
};

std::vector<Patch> patches_of(const Surface& surface, int face, const TrimRegion& trim);
std::vector<CurvePiece> curves_of(const Face& face, int index, const TrimRegion& trim);
Box box_of(const Patch& patch);
Box box_of(const CurvePiece& piece);
/// A box around an analytic face, from its parameters' box.
Box box_of_analytic(const Surface& surface, const TrimRegion& trim);

/// A binary tree over boxes.
class Tree {
 public:
  explicit Tree(const std::vector<Box>& boxes);

  /// Calls visit(item) for items whose box may be nearer than sqrt(limit2()), nearer ones first.
  template <class Limit2, class Visit>
  void walk(const Vec3& p, Limit2 limit2, Visit visit) const {
    if (nodes_.empty()) return;
    struct Entry {
      double distance2;
      int node;
    };
    Entry stack[96];
    int size = 0;
    stack[size++] = {nodes_[0].box.distance2(p), 0};
    while (size > 0) {
      const Entry top = stack[--size];
      if (top.distance2 > limit2()) continue;
      const Node& node = nodes_[static_cast<std::size_t>(top.node)];
      if (node.item >= 0) {
        visit(node.item);
        continue;
      }
      const Entry left{nodes_[static_cast<std::size_t>(node.left)].box.distance2(p), node.left};
      const Entry right{nodes_[static_cast<std::size_t>(node.right)].box.distance2(p), node.right};
      const bool left_first = left.distance2 <= right.distance2;
      stack[size++] = left_first ? right : left;
      stack[size++] = left_first ? left : right;
    }
  }

 private:
  struct Node {
    Box box;
    int left = -1, right = -1, item = -1;
  };
  int build(const std::vector<Box>& boxes, std::vector<int>& items, int begin, int end);
  std::vector<Node> nodes_;
};

}  // namespace afptraj::closest
