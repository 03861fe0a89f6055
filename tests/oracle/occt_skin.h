#pragma once

#include <BRepTopAdaptor_FClass2d.hxx>
#include <Bnd_Box.hxx>
#include <Geom2d_Curve.hxx>
#include <Geom_Curve.hxx>
#include <Geom_Surface.hxx>
#include <TopoDS_Face.hxx>
#include <array>
#include <gp_XYZ.hxx>
#include <memory>
#include <optional>
#include <vector>

namespace oracle {

using Vec = gp_XYZ;

/// Position and derivatives by OCCT's evaluators.
struct Jet {
  Vec S, Su, Sv, Suu, Suv, Svv;
  Vec normal() const;                           ///< S_u x S_v normalised, zero at a pole
  double normal_curvature(const Vec& t) const;  ///< II(t, t) / I(t, t) about normal()
  double gaussian() const;
};

/// A place on a face (index into the skin) and how far the asked point was from it.
struct Foot {
  int face = -1;
  double u = 0, v = 0;
  Vec point{0, 0, 0};
  double distance = 1e300;
};

/// What lies nearest to a point among the edges of the skin.
struct BoundaryFoot {
  double on_pcurve = 1e300;  ///< distance to S(c(t)), the nearest over all edges
  double on_curve = 1e300;   ///< distance to the 3-D curve of that edge
  bool seam = false;         ///< the edge joins a face with itself
  bool pole = false;         ///< the edge is a point in space
  bool shared = false;       ///< another face of the skin comes within the join tolerance there
};

/// A set of OCCT faces. Only OCCT evaluates: no code of the product is used here.
class Skin {
 public:
  /// `join_mm`: faces nearer than this along an edge count as joined there.
  explicit Skin(const std::vector<TopoDS_Face>& faces, double join_mm = 0.05);

  int size() const { return static_cast<int>(faces_.size()); }
  /// Beyond a non-periodic end of the surface: its straight (C1) continuation.
  Jet jet(int face, double u, double v) const;

  /// Newton from (u, v) for the foot of the perpendicular on the untrimmed surface; a closed
  /// direction wraps. The best point met, whether or not it converged.
  Foot foot(int face, const Vec& p, double u, double v) const;
  /// Nearest foot inside (or within `slack_mm` of) the material of any face; `hint` is tried first and taken
  /// when it lies within `good_mm`.
  Foot nearest(const Vec& p, const Foot* hint = nullptr, double good_mm = 1e-7) const;
  /// Nearest foot over the untrimmed surfaces of all faces, by seeds from grids.
  Foot nearest_on(int face, const Vec& p) const;

  bool inside(int face, double u, double v) const;
  /// A face other than `except` whose material has a foot within the join tolerance of `p`.
  std::optional<Foot> other_face_at(const Vec& p, int except) const;
  BoundaryFoot boundary(const Vec& p) const;

  /// Area-weighted samples of the material: about `count` in all.
  struct AreaSample {
    Foot at;
    double area;
  };
  std::vector<AreaSample> area_samples(int count) const;

  double diagonal() const { return diagonal_; }
  /// Extent of the trim box of a face: u0, u1, v0, v1.
  const std::array<double, 4>& box(int face) const { return faces_[static_cast<std::size_t>(face)].box; }
  double period_u(int face) const { return faces_[static_cast<std::size_t>(face)].period_u; }
  double period_v(int face) const { return faces_[static_cast<std::size_t>(face)].period_v; }

 private:
  struct Seed {
    double u, v;
    Vec p;
  };
  struct Block {
    std::size_t first, last;
    Vec centre;
    double radius;
  };
  struct FaceData {
    TopoDS_Face face;
    Handle(Geom_Surface) surface;
    std::unique_ptr<BRepTopAdaptor_FClass2d> classifier;
    std::array<double, 4> box, domain;  ///< of the trim loops, of the surface
    double period_u = 0, period_v = 0;
    Bnd_Box bounds;
    std::vector<Seed> seeds;
    std::vector<Block> blocks;
  };
  struct EdgeData {
    int face;
    Handle(Geom2d_Curve) pcurve;
    Handle(Geom_Curve) curve;
    double first, last;
    bool seam, pole;
    std::vector<double> t;
    std::vector<Vec> samples;
    double reach;  ///< greatest distance of the curve from its samples' chords, roughly
  };
  void add_seeds(FaceData& data) const;
  void add_edges(int index);
  void wrap(const FaceData& data, double& u, double& v) const;

  std::vector<FaceData> faces_;
  std::vector<EdgeData> edges_;
  double join_mm_;
  double diagonal_ = 0;
};

}  // namespace oracle
