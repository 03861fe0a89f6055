#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "winding/meridian.h"
#include "winding/steered_clairaut.h"

namespace afptraj {

/// Where a fibre's pass along a mandrel ends.
struct PassEnd {
  double t = 0;  ///< of the meridian
  double z_mm = 0, r_mm = 0;
  /// The fibre turns back there, where r = r sin(alpha). Otherwise the mandrel ends before: its opening is
  /// wider than that, and the fibre runs off.
  bool turns = false;
};

struct FibrePoint {
  double t = 0, z_mm = 0, r_mm = 0;
  double turn_rad = 0;   ///< of the mandrel, from the pass's first end
  double length_mm = 0;  ///< of the fibre, from there
  double angle_rad = 0;  ///< winding angle: 0 axial, pi / 2 where it turns
};

/// How a fibre is steered towards one end of its pass.
struct Steering {
  double from_t = 0;                                ///< from there on towards the end
  std::shared_ptr<const SteeredClairaut> clairaut;  ///< r sin(alpha) there
  std::optional<double> turn_t = {};  ///< where it turns, if that is known; otherwise it is looked for
};

/// A fibre's path on a mandrel from end to end, given by q(t) = r sin(alpha): a constant K between the places
/// from which it is steered, and beyond as steered. With sigma the way along the meridian
///   d theta / d sigma = q / (r sqrt(r^2 - q^2)),   d s / d sigma = r / sqrt(r^2 - q^2).
/// Both grow beyond bounds where the fibre turns; with t = (a + b)/2 - (b - a)/2 cos(phi) between the ends a
/// and b their integrals have smooth integrands, and are taken from knot to knot. The way back is the mirror
/// image: its winding angle keeps to the same q, and needs the same friction.
class FibrePass {
 public:
  /// REQUIRES: 0 < K < r at `through`; steering begins beyond `through` towards its end.
  FibrePass(const Meridian& meridian, double clairaut_mm, double through,
            std::optional<Steering> steering_first, std::optional<Steering> steering_last);

  double clairaut_at(double t) const;  ///< r sin(alpha)
  const PassEnd& first() const { return first_; }
  const PassEnd& last() const { return last_; }
  double turn_rad() const { return turn_rad_; }    ///< of the mandrel over the pass
  double length_mm() const { return length_mm_; }  ///< of the fibre
  /// The pass in `count` + 1 points, closer where it turns.
  std::vector<FibrePoint> points(int count) const;

  /// A place of the pass: phi grows from 0 to pi along it, t = (a + b)/2 - (b - a)/2 cos(phi).
  struct Phase {
    double phi = 0, t = 0;
  };
  /// Where the meridian's polynomials meet, and where steering begins: the path's curvature may jump there.
  const std::vector<double>& breaks() const { return breaks_; }
  /// `count` + 1 even phases, and those of the breaks, with their very parameters.
  std::vector<Phase> phases_and_breaks(int count) const;
  Phase between(const Phase& a, const Phase& b) const;
  /// The first counts as the pass's first end. REQUIRES: growing.
  std::vector<FibrePoint> points_at(const std::vector<Phase>& phases) const;
  /// The place at a phase, counted on from the one at an earlier phase.
  FibrePoint next_point(const FibrePoint& before, const Phase& from, const Phase& to) const;

 private:
  enum class Quantity { turn, length };
  SteeredClairaut::Value clairaut(double t) const;
  double height(double t) const;
  FibrePoint place(const Phase& phase) const;
  double over(Quantity quantity, double phi0, double phi1) const;
  double rate(Quantity quantity, double phi) const;
  double above_clairaut(double phi, double t, const MeridianPoint& at) const;
  double smooth_way(bool near_first) const;
  double parameter(double phi) const;
  double phase(double t) const;
  PassEnd end_of(double from, bool forward) const;
  double root(double outside, double inside) const;

  const Meridian& meridian_;
  double K_;
  std::optional<Steering> steering_first_, steering_last_;
  std::vector<double> breaks_;
  PassEnd first_, last_;
  double turn_rad_ = 0, length_mm_ = 0;
};

}  // namespace afptraj
