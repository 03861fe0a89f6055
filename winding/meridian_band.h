#pragma once

#include <vector>

#include "winding/band_arcs.h"
#include "winding/meridian.h"
#include "winding/thread_contact.h"

namespace afptraj {

/// The band that paths lay on a mandrel with a meridian, between two places of it: each step of a path is a
/// quadrilateral whose corners lie half a tow beside the path in the tangent plane, dropped onto the surface.
/// The union is exact along `circles` circles, evenly spread along the meridian.
class MeridianBand {
 public:
  MeridianBand(const Meridian& meridian, double tow_width_mm, double first_t, double last_t, int circles);

  void lay(const std::vector<ContactPoint>& path);
  BandCoverage coverage() const;

  /// A place on the mandrel; sigma: way along the meridian from its first end.
  struct Corner {
    double t, sigma_mm, turn_deg;
  };
  struct Edge {
    Corner left, right;
  };
  /// The band's edges beside a place of its path.
  Edge edge_at(const ContactPoint& point) const;

 private:
  Corner corner(const ContactPoint& point, double beside_mm) const;
  double sigma(double t) const;
  void lay_step(const Edge& a, const Edge& b);

  const Meridian& meridian_;
  double half_width_mm_, step_mm_;
  std::vector<double> table_t_, table_sigma_;  // way along the meridian from its first end
  double first_sigma_mm_;
  std::int64_t piece_ = 0;
  std::vector<double> circle_t_;
  std::vector<std::vector<BandArc>> arcs_;  // by circle
};

}  // namespace afptraj
