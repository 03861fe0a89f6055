#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "geometry/closest_point.h"
#include "geometry/part.h"
#include "geometry/trim_region.h"

namespace afptraj {

/// One use of an edge by a face of a skin.
struct EdgeUse {
  int face = -1, loop = -1, coedge = -1;
  bool operator==(const EdgeUse&) const = default;
};

/// The faces to lay on, with their adjacency; an immutable value.
/// Face indices everywhere are those of the part.
class Skin {
 public:
  /// Throws std::invalid_argument when a face index is out of range or `faces` is empty.
  Skin(std::shared_ptr<const Part> part, std::vector<int> faces);

  const Part& part() const { return *part_; }
  const std::vector<int>& faces() const { return faces_; }
  const Face& face(int index) const { return part_->faces[static_cast<std::size_t>(index)]; }
  const TrimRegion& trim(int index) const { return *trim_[static_cast<std::size_t>(index)]; }
  bool has(int face) const { return trim_[static_cast<std::size_t>(face)] != nullptr; }

  /// The other use of the edge on this skin: the neighbour across it, the face itself at a seam;
  /// nothing at a free edge or a pole.
  std::optional<EdgeUse> mate(const EdgeUse& use) const;
  const Edge& edge(const EdgeUse& use) const;
  const Coedge& coedge(const EdgeUse& use) const;
  /// Where a path that stands at `p` on an edge, at parameter `t` of this use, goes on: a point of the mate's
  /// face. Where the faces meet it is p's foot; where they gap (up to the edge's tolerance) the point of the
  /// mate's pcurve nearest to p, because the foot may lie outside of the mate's loops. Only where there is a mate.
  SurfacePoint across(const EdgeUse& use, double t, const Vec3& p) const;
  /// True when the face lies on both sides of the edge.
  bool is_seam(const EdgeUse& use) const;
  /// True when the loop is an inner one (it runs clockwise in (u, v)).
  bool is_hole(int face, int loop) const {
    return holes_[static_cast<std::size_t>(face)][static_cast<std::size_t>(loop)];
  }

  Vec3 point(const SurfacePoint& at) const { return face(at.face).surface.point(at.uv); }
  SurfaceDerivatives derivatives(const SurfacePoint& at) const { return face(at.face).surface.derivatives(at.uv); }
  /// Unit normal, turned by the orientation of the face; zero at a pole.
  Vec3 normal(const SurfacePoint& at) const;

  const ClosestPointFinder& closest_point() const { return *closest_; }

  /// Corners of a box around the skin (of the surface over the trim loops, sampled and padded).
  Vec3 box_min() const { return box_min_; }
  Vec3 box_max() const { return box_max_; }
  double diagonal() const { return (box_max_ - box_min_).norm(); }
  double area() const { return area_; }

 private:
  std::shared_ptr<const Part> part_;
  std::vector<int> faces_;
  std::vector<std::shared_ptr<const TrimRegion>> trim_;
  std::vector<std::vector<EdgeUse>> uses_;  // by edge
  std::vector<std::vector<bool>> holes_;    // by face and loop
  std::shared_ptr<const ClosestPointFinder> closest_;
  Vec3 box_min_, box_max_;
  double area_ = 0;
};

/// Faces of the part reached from `seeds` over shared edges where the normals of both sides
/// nowhere differ by more than `angle_rad`. Sorted.
std::vector<int> grow_tangent(const Part& part, const std::vector<int>& seeds, double angle_rad);

/// Samples of the material of a face, each standing for `area_mm2` of it: a tensor grid of about
/// `count` Gauss points over the loops' box, those inside the loops.
struct AreaSample {
  SurfacePoint at;
  double area_mm2;
};
std::vector<AreaSample> area_samples(const Part& part, int face, const TrimRegion& trim, int count);

}  // namespace afptraj
