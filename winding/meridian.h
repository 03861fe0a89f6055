#pragma once

#include <array>
#include <vector>

#include "geometry/bspline_curve.h"

namespace afptraj {

/// A place on a meridian, with first and second derivatives by its parameter.
struct MeridianPoint {
  double z_mm = 0, r_mm = 0;  ///< along the axis, from it
  double dz = 0, dr = 0;
  double ddz = 0, ddr = 0;
  double speed() const;      ///< |(dz, dr)|: way along the meridian by parameter
  double curvature() const;  ///< of the meridian, positive where it bends towards the axis
};

/// The curve (z, r) that turns about the axis to a mandrel: B-spline pieces end to end, z growing along it.
/// Where pieces meet there may be a corner; within a piece the curve is as smooth as its B-spline.
class Meridian {
 public:
  /// REQUIRES: at least one piece, each beginning where the one before ends.
  /// Throws Error(bad_input, "meridian", ...) where r is not positive (but for the ends, where it may be 0),
  /// or z goes back.
  explicit Meridian(std::vector<BSplineCurve2> pieces);

  double first() const { return starts_.front(); }
  double last() const { return starts_.back(); }
  /// The parameter is clamped to [first, last].
  MeridianPoint at(double t) const;
  /// Where pieces and polynomials meet, first and last included.
  const std::vector<double>& breaks() const { return breaks_; }
  const std::vector<BSplineCurve2>& pieces() const { return pieces_; }
  double length_mm() const { return length_mm_; }
  /// The parameter of the place nearest to (z, r).
  double nearest(double z_mm, double r_mm) const;
  /// Places of the greatest and the least radius.
  double widest() const { return widest_; }
  double narrowest() const { return narrowest_; }

 private:
  // A span between breaks by powers of u = (t - middle) / half in [-1, 1]: z w, r w, and w where it is
  // rational.
  struct Span {
    double middle = 0, half = 0;
    std::vector<std::array<double, 3>> powers;  // none where the degree is high: then the B-spline is asked
    bool rational = false;
  };
  static Span span_of(const BSplineCurve2& piece, double start, double from, double to);
  void require_forward() const;
  double extreme(double sign) const;

  std::vector<BSplineCurve2> pieces_;
  std::vector<double> starts_;  // parameter where each piece begins, and where the last ends
  std::vector<double> breaks_;
  std::vector<Span> spans_;
  double length_mm_ = 0, widest_ = 0, narrowest_ = 0;
};

/// A row of a meridian file.
struct MeridianRow {
  double z_mm = 0, r_mm = 0;
};

/// The meridian through points (z, r): between corners an interpolating cubic spline, twice continuously
/// differentiable, not-a-knot at its ends (its error falls with the fourth power of the points' distance;
/// lines and cubics are met exactly), parametrised by chord length. A row that stands twice is a corner; two
/// points between corners are joined by a straight line, three by a parabola. Throws Error(bad_input,
/// "meridian", ...) for fewer than two points, and as Meridian does.
Meridian meridian_through(const std::vector<MeridianRow>& rows);

}  // namespace afptraj
