#pragma once

#include <memory>
#include <vector>

#include "geometry/bspline_curve.h"
#include "geometry/geodesic.h"
#include "geometry/surface_curve.h"
#include "trajectory/geodesic_chart.h"

namespace afptraj {

/// A curve that geodesics are shot from: exact at every parameter, not only at samples.
class SourceCurve {
 public:
  virtual ~SourceCurve() = default;
  virtual double first() const = 0;
  virtual double last() const = 0;
  /// Frame, speed ds/dt and geodesic curvature; `outside` when the point lies off the trimmed skin,
  /// `in_hole` when it does so within an inner loop.
  struct Frame : CurveFrame {
    bool outside = false;
    bool in_hole = false;
  };
  virtual Frame at(double t) const = 0;
  virtual bool closed() const { return false; }
};

/// Coordinates on a stretch of a skin: (u, v) of a face, or (s, w) about a geodesic where there is one.
struct PathChart {
  int face = -1;
  int normal_sign = 1;
  std::shared_ptr<const GeodesicChart> about;

  /// `inward`: to which side of a crease, where `at` stands on one.
  GeodesicChart::Place place(const Skin& skin, const Uv& at, const Uv& inward = Uv::Zero()) const;
};

/// B-splines, one per chart, over one common parameter: the fitted reference path.
class SplinePath : public SourceCurve {
 public:
  struct Piece {
    PathChart chart;
    BSplineCurve2 curve;
  };
  SplinePath(const Skin& skin, std::vector<Piece> pieces, bool closed);
  double first() const override { return pieces_.front().curve.first(); }
  double last() const override { return pieces_.back().curve.last(); }
  Frame at(double t) const override;
  bool closed() const override { return closed_; }
  const std::vector<Piece>& pieces() const { return pieces_; }

 private:
  const Skin* skin_;
  std::vector<Piece> pieces_;
  bool closed_;
};

/// A geodesic, kept as states every few mm; points between are integrated from the nearest.
class GeodesicPath : public SourceCurve {
 public:
  /// `states` in order of arc length from 0; at(t) is the state at arc length t. With `backward` the
  /// curve runs the other way: its parameter is -arc length, its tangent turned round.
  GeodesicPath(const GeodesicTracer& tracer, std::vector<GeodesicState> states, bool backward);
  double first() const override;
  double last() const override;
  Frame at(double t) const override;

 private:
  const GeodesicTracer* tracer_;
  std::vector<GeodesicState> states_;
  bool backward_;
};

/// A stretch of a curve that has been laid: exact at its nodes, between them as close as its cubics.
class LaidPath : public SourceCurve {
 public:
  LaidPath(const Skin& skin, SurfaceCurve curve, double first, double last)
      : skin_(&skin), curve_(std::move(curve)), first_(first), last_(last) {}
  double first() const override { return first_; }
  double last() const override { return last_; }
  Frame at(double t) const override;

 private:
  const Skin* skin_;
  SurfaceCurve curve_;
  double first_, last_;
};

}  // namespace afptraj
