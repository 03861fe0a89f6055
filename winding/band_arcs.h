#pragma once

#include <cstdint>
#include <vector>

namespace afptraj {

/// How a mandrel is covered by the tow that was laid on it.
struct BandCoverage {
  double covered_share = 0;  ///< of the wound length's surface
  double overlap_share = 0;  ///< surface laid more than once, each further time counted, by the covered one
  double widest_gap_mm = 0;  ///< bare between two tows, round the mandrel at one place along it
  double gap_z_mm = 0, gap_deg = 0;  ///< where the widest is: along the axis, and its middle round it
};

/// The part of a circle round a mandrel that a piece of a band covers.
struct BandArc {
  double from_deg = 0, to_deg = 0;  ///< unbounded
  std::int64_t piece = 0;           ///< that laid it, or its last part
};

/// Adds an arc to those of a circle, in the order of laying. Where a path bends, its pieces leave a wedge
/// between them on the outer side, which the tow spans: the arcs of a piece and the next on one circle are
/// one.
void cover(std::vector<BandArc>& arcs, const BandArc& arc);

/// Sums up circles, each for a strip of the surface along it.
class CoverageSum {
 public:
  void add(double z_mm, double r_mm, double strip_mm, const std::vector<BandArc>& arcs);
  BandCoverage coverage() const;

 private:
  BandCoverage out_;
  double surface_ = 0, covered_ = 0, laid_ = 0;
};

}  // namespace afptraj
