#pragma once

#include <optional>
#include <string>

#include "winding/fibre_pass.h"

namespace afptraj {

/// How a layer may be steered.
struct SteeringRule {
  double friction =
      0;  ///< greatest ratio of geodesic to normal curvature at which the tow stays; 0: geodesics
  std::optional<double> opening_first_mm = {}, opening_last_mm = {};  ///< radii at which it is to turn
  double tow_width_mm = 0;
  bool on_widest = false;  ///< turns on the widest stretch, half a tow before its ends: hoops
};

/// A pass that turns at both ends, and the ratios by which it is steered towards each: positive towards hoop.
struct SteeredPass {
  FibrePass pass;
  double ratio_first = 0, ratio_last = 0;
  double needed_friction() const;
};

/// Passes of a mandrel by their winding angle at the widest place. Towards either end a pass is
///   * steered from where the widest stretch ends, with the one ratio that makes it turn at the radius that
///   is
///     asked for;
///   * otherwise a geodesic, where that turns at this end;
///   * otherwise steered with all the friction, so that it turns half a tow before the end: a lock turn. On a
///     cylinder it begins R (1 / sin(alpha) - 1) / friction before that.
class PassMaker {
 public:
  /// Throws Error(no_path, "mandrel", ...) for an opening that the mandrel has not, or narrower than the tow.
  PassMaker(const Meridian& meridian, const SteeringRule& rule);

  /// None where there is no such pass.
  std::optional<SteeredPass> at(double angle_deg) const;
  /// Why there is none; what would do.
  std::string refusal(double angle_deg) const;
  /// The ends of the widest stretch: parameters of the meridian.
  double widest_first_t() const { return first_.edge_t; }
  double widest_last_t() const { return last_.edge_t; }

  /// Below it tows cross the axis where they turn.
  double least_angle_deg() const;

 private:
  struct Side {
    bool forward = true;
    double edge_t = 0;  // end of the widest stretch
    double end_t = 0;   // as far as the mandrel is wide enough for the tow
    double least_mm = 0;
    std::optional<double> opening_mm;
    double turn_t = 0;                         // where it is to turn, if not as a geodesic
    std::shared_ptr<const SteeringGrid> grid;  // edge to turn; of a lock turn to edge
  };
  struct Steered {
    std::optional<Steering> steering;
    double ratio = 0;
    bool turns = true;  // within the friction
  };
  Side side(bool forward) const;
  bool is_geodesic(const Side& side, double clairaut_mm) const;
  Steered steered(const Side& side, double clairaut_mm) const;
  SteeredClairaut solution(const Side& side, double start_mm, double outward_ratio) const;
  std::optional<double> opening_ratio(const Side& side, double clairaut_mm) const;
  std::optional<double> lock_ratio(const Side& side, double clairaut_mm) const;
  double reached_mm(const Side& side, double clairaut_mm, double outward_ratio) const;
  std::string side_refusal(const Side& side, double angle_deg) const;

  const Meridian& meridian_;
  SteeringRule rule_;
  double R_, middle_t_;
  Side first_, last_;
};

}  // namespace afptraj
