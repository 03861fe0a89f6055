#pragma once

#include <array>
#include <vector>

#include "geometry/trim_region.h"
#include "geometry/trim_segments.h"

/// Crossings of a cubic with flattened loops. Internal to this room; see trim_region.h.
namespace afptraj::trim {

/// Finds crossings in order; `accept` is asked for each and stops the search by returning true.
class CrossingSearch {
 public:
  CrossingSearch(const SegmentGrid& grid, const UvCubic& path);

  /// All crossings; with `first_only`, the first one of the given sense and no others.
  std::vector<LoopCrossing> run(bool first_only = false, bool outward = true);

 private:
  /// A place where the path and a loop meet, or (segment < 0) where they run too close to tell.
  struct Candidate {
    double x;
    int segment;
    double s;
  };
  struct PathPiece {
    std::array<Uv, 4> p;
    double x0, x1;
    Uv low() const { return p[0].cwiseMin(p[1]).cwiseMin(p[2].cwiseMin(p[3])); }
    Uv high() const { return p[0].cwiseMax(p[1]).cwiseMax(p[2].cwiseMax(p[3])); }
    PathPiece split_left();
  };
  struct CurvePiece {
    std::vector<Eigen::Vector3d> control;
    Uv a, b;
    double eps, s0, s1;
  };

  void gather(PathPiece piece, int depth);
  void meet(const PathPiece& path, int segment);
  void meet(PathPiece path, CurvePiece curve, int segment, int depth);
  bool may_meet(const PathPiece& path, const Uv& a, const Uv& b, double eps) const;
  static bool at_most_one(const PathPiece& path, const std::vector<Eigen::Vector3d>& control);
  enum class Solve { found, none, failed };
  Solve newton(const PathPiece& path, const CurvePiece& curve, int segment, double& x, double& s) const;

  Uv point(double x) const { return path_.point(x); }
  LoopCrossing crossing_at(const Candidate& candidate) const;
  LoopCrossing crossing_between(double x0, bool inside0, double x1) const;

  const SegmentGrid& grid_;
  UvCubic path_;  // scaled
  double size_ = 0;
  std::vector<Candidate> candidates_;
  int budget_ = 0;
};

/// The point of the loops nearest to the scaled point `p` in the metric of the scaled plane.
LoopCrossing nearest_on_loops(const SegmentGrid& grid, const Uv& p, const Eigen::Matrix2d& metric);

}  // namespace afptraj::trim
