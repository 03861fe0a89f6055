#include "winding/pattern_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <tuple>

#include "winding/frustum.h"
#include "winding/layer_rules.h"
#include "winding/pattern.h"

namespace afptraj {
namespace {

// Passes there and passes back turn the mandrel the same way, and so cross once per turn of both together.
std::int64_t crossings_of(const WindMandrel& mandrel, double angle_deg, std::int64_t circuits) {
  const double turn_deg = mandrel.is_cone() ? ConeGeodesic(mandrel, angle_deg).turn_deg(mandrel.length_mm)
                                            : 360 * mandrel.length_mm * std::tan(radians(angle_deg)) /
                                                  (std::numbers::pi * mandrel.diameter_mm);
  const double N = static_cast<double>(circuits);
  return std::llround(std::min(N * N * 2 * turn_deg / 360, 9e15));
}

bool fiberpath_takes(const WindMandrel& mandrel, const WindTow& tow, const FoundPattern& found) {
  WindDefinition definition;
  definition.mandrel = mandrel;
  definition.tow = tow;
  HelicalLayer layer;
  layer.angle_deg = found.angle_deg;
  layer.pattern = found.pattern;
  layer.skip = found.skip;
  layer.lock_deg = found.lock_deg;
  definition.layers = {layer};  // its leads are the user's own matter
  return !first_fault(definition, WindMode::fiberpath);
}

class Search {
 public:
  Search(const WindMandrel& mandrel, const WindTow& tow, const PatternQuery& query)
      : mandrel_(mandrel), tow_(tow), query_(query) {
    lowest_ = std::max(query.angle_deg - query.tolerance_deg, 0.0);
    highest_ = std::min(query.angle_deg + query.tolerance_deg, steepest_angle_deg(mandrel));
  }

  std::vector<FoundPattern> found() {
    if (!(lowest_ < highest_ || (lowest_ == highest_ && lowest_ > 0)) || highest_ >= 90.0 + 1e-12) return {};
    const double around = std::numbers::pi * mandrel_.diameter_mm / tow_.width_mm;
    const std::int64_t few = circuits_at(highest_), many = circuits_at(lowest_);
    if (query_.angle_deg <= highest_ && query_.angle_deg > 0 && query_.angle_deg < 90) add_asked_angle();
    for (std::int64_t N = std::max<std::int64_t>(few, 1); N <= many; ++N) {
      const double cosine = static_cast<double>(N) / around;
      if (cosine > 1) break;
      const double touching = std::ceil(degrees(std::acos(cosine)) / angle_step_deg) * angle_step_deg;
      if (touching >= lowest_ && touching <= highest_ && touching > 0 && touching < 90)
        add_circuits(N, touching);
    }
    std::stable_sort(out_.begin(), out_.end(), [&](const FoundPattern& a, const FoundPattern& b) {
      return std::tuple(std::abs(a.angle_deg - query_.angle_deg), a.overlap, a.pattern, a.skip) <
             std::tuple(std::abs(b.angle_deg - query_.angle_deg), b.overlap, b.pattern, b.skip);
    });
    return std::move(out_);
  }

 private:
  std::int64_t circuits_at(double angle_deg) const {
    HelicalLayer layer;
    layer.angle_deg = angle_deg;
    return circuits(mandrel_, tow_, layer, WindMode::fiberpath);
  }

  // Every pattern fits the asked angle when its circuits are rounded up, at the price of overlap.
  void add_asked_angle() {
    const std::int64_t needed = circuits_at(query_.angle_deg);
    for (std::int64_t p = 1; p <= std::min(needed, query_.largest_pattern); ++p)
      add_pattern((needed + p - 1) / p * p, p, query_.angle_deg);
  }

  void add_circuits(std::int64_t N, double angle_deg) {
    for (std::int64_t p = 1; p <= std::min(N, query_.largest_pattern); ++p) {
      if (N % p == 0) add_pattern(N, p, angle_deg);
    }
  }

  void add_pattern(std::int64_t N, std::int64_t p, double angle_deg) {
    for (std::int64_t d = 1; d < std::max<std::int64_t>(p, 2); ++d) {
      if (std::gcd(d, p) == 1) add(N, p, d, angle_deg);
    }
  }

  void add(std::int64_t N, std::int64_t p, std::int64_t d, double angle_deg) {
    FoundPattern pattern;
    pattern.circuits = N;
    pattern.pattern = p;
    pattern.skip = d;
    pattern.angle_deg = angle_deg;
    // With whole half turns at the ends d alone is the stride, whatever p is.
    pattern.lock_deg = std::max(1.0, std::nearbyint(query_.lock_deg / 180)) * 180;
    pattern.overlap = overlap(mandrel_, tow_, angle_deg, N);
    pattern.crossings = crossings_of(mandrel_, angle_deg, N);
    pattern.fiberpath = fiberpath_takes(mandrel_, tow_, pattern);
    out_.push_back(pattern);
  }

  const WindMandrel& mandrel_;
  const WindTow& tow_;
  const PatternQuery& query_;
  double lowest_ = 0, highest_ = 0;
  std::vector<FoundPattern> out_;
};

}  // namespace

double steepest_angle_deg(const WindMandrel& mandrel) {
  if (!mandrel.is_cone()) return 90;
  return degrees(std::asin(std::min(1.0, *mandrel.end_diameter_mm / mandrel.diameter_mm)));
}

std::vector<FoundPattern> find_patterns(const WindMandrel& mandrel, const WindTow& tow,
                                        const PatternQuery& query) {
  return Search(mandrel, tow, query).found();
}

}  // namespace afptraj
