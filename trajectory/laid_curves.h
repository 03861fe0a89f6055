#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "geometry/surface_curve.h"

namespace afptraj {

/// The curves of the levels reached so far, found by place: a hash of their nodes in space.
class LaidCurves {
 public:
  LaidCurves(const Skin& skin, double cell_mm);

  /// Adds a curve of the level `number` (left of the reference above 0, right below) and returns its index.
  /// `own_tracer` walks to and from a curve that lies farther beyond the part than other paths may; it must
  /// outlive this.
  int add(SurfaceCurve curve, int number, const GeodesicTracer* own_tracer = nullptr);
  const SurfaceCurve& curve(int index) const { return curves_[static_cast<std::size_t>(index)].curve; }
  int number(int index) const { return curves_[static_cast<std::size_t>(index)].number; }

  /// A curve nearer to a point than `limit_mm`, along the skin.
  struct Rival {
    int curve = -1;
    GeodesicFoot foot;
  };

  /// Looks for a curve that reaches `p` (normal `n`) over less than `limit_mm` of skin, other than the
  /// stretch around parameter `own_t` of curve `own`, which p was shot from. Candidates are the local
  /// minima of the distance in space; each is decided by the geodesic itself.
  std::optional<Rival> rival(const GeodesicTracer& tracer, const Vec3& p, const Vec3& n, double limit_mm,
                             int own, double own_t, double own_reach_mm) const;

  /// The least distance in space from p to the chords of the curves, with a normal not opposite to
  /// n; `limit_mm` when there is none within it.
  double distance(const Vec3& p, const Vec3& n, double limit_mm) const;

  /// Whether a node with a like normal lies within `limit_mm` of p, abreast of the direction `along`
  /// (its offset along it is at most `abreast_mm`) and off to the side by more than `abreast_mm`.
  bool abreast(const Vec3& p, const Vec3& n, const Vec3& along, double limit_mm, double abreast_mm) const;

 private:
  struct Node {
    Vec3 position, normal;
    double t;
  };
  struct Entry {
    SurfaceCurve curve;
    int number;
    const GeodesicTracer* own_tracer;
    std::vector<Node> nodes;
  };
  using Key = std::int64_t;
  Key key(const Vec3& p) const;
  template <typename Visit>
  void visit_near(const Vec3& p, double radius, Visit visit) const;

  const Skin* skin_;
  double cell_mm_;
  std::vector<Entry> curves_;
  std::unordered_map<Key, std::vector<std::pair<int, int>>> cells_;
};

}  // namespace afptraj
