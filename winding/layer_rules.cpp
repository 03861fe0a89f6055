#include "winding/layer_rules.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "winding/frustum.h"
#include "winding/number_words.h"
#include "winding/pattern.h"

namespace afptraj {
namespace {

using Fault = std::optional<LayerFault>;

// Judges one helical layer; `number` counts from 1.
class HelicalJudge {
 public:
  HelicalJudge(const WindDefinition& definition, const HelicalLayer& layer, std::size_t number, WindMode mode)
      : mandrel_(definition.mandrel),
        tow_(definition.tow),
        layer_(layer),
        number_(number),
        native_(mode == WindMode::native),
        mode_(mode) {}

  Fault fault() const {
    for (const auto rule : {&HelicalJudge::angle, &HelicalJudge::cone, &HelicalJudge::skip_below_pattern,
                            &HelicalJudge::coprime, &HelicalJudge::lead_in, &HelicalJudge::circuit_count,
                            &HelicalJudge::slots, &HelicalJudge::aliases}) {
      if (const Fault found = (this->*rule)()) return found;
    }
    return std::nullopt;
  }

 private:
  Fault say(ErrorCode code, const std::string& fiberpath, const std::string& native) const {
    return LayerFault{number_, native_ ? native : fiberpath, code};
  }
  Fault say(ErrorCode code, const std::string& both) const { return say(code, both, both); }

  Fault angle() const {
    const double a = layer_.angle_deg;
    if (native_ ? a > 0 && a < 90 : a >= 1 && a <= 89) return std::nullopt;
    const std::string text = "wind angle " + shortest_text(a) + "° must be between ";
    return say(ErrorCode::bad_input, text + "1.0° and 89.0°",
               text + "0° and 90°, from the axis; at 90° use a hoop layer");
  }

  Fault cone() const {
    if (!mandrel_.is_cone()) return std::nullopt;
    const double r0 = mandrel_.diameter_mm / 2, r1 = *mandrel_.end_diameter_mm / 2;
    if (r1 > r0) {
      return say(ErrorCode::bad_input,
                 "cone requires a reducing frustum with r0 > r1 (got r0=" + shortest_text(r0) +
                     ", r1=" + shortest_text(r1) +
                     "); the wind angle anchors at the large end r0, so mount the large end at z=0");
    }
    const double K = r0 * std::sin(radians(layer_.angle_deg));
    if (K <= r1) return std::nullopt;
    return say(ErrorCode::no_path,
               "wind angle " + shortest_text(layer_.angle_deg) +
                   "° is too steep for the cone: the geodesic (Clairaut C=" + significant_text(K, 4) +
                   "mm) cannot reach the small-end radius " + significant_text(r1, 4) +
                   "mm. Reduce the wind angle to <= " + significant_text(degrees(std::asin(r1 / r0)), 4) +
                   "°");
  }

  Fault skip_below_pattern() const {
    if (layer_.skip < layer_.pattern || (native_ && layer_.pattern == 1)) return std::nullopt;
    return say(ErrorCode::no_path, "skipIndex must be less than patternNumber",
               "skipIndex " + std::to_string(layer_.skip) + " must be less than patternNumber " +
                   std::to_string(layer_.pattern) + "; use " + nearest_skips());
  }

  Fault coprime() const {
    if (std::gcd(layer_.skip, layer_.pattern) == 1) return std::nullopt;
    return say(ErrorCode::no_path, "skipIndex and patternNumber must be coprime for full coverage",
               "skipIndex " + std::to_string(layer_.skip) + " and patternNumber " +
                   std::to_string(layer_.pattern) +
                   " have a common divisor, which leaves bare strips; use skipIndex " + nearest_skips());
  }

  // The nearest indices below and above that are below p and have no common divisor with it.
  std::string nearest_skips() const {
    const std::int64_t p = layer_.pattern;
    const auto fits = [&](std::int64_t d) { return d > 0 && d < p && std::gcd(d, p) == 1; };
    std::int64_t below = std::min(layer_.skip, p - 1), above = layer_.skip + 1;
    while (below > 1 && !fits(below)) --below;
    while (above < p && !fits(above)) ++above;
    return std::to_string(below) + (above < p ? " or " + std::to_string(above) : "");
  }

  Fault lead_in() const {
    if (layer_.lead_in_mm < mandrel_.length_mm) return std::nullopt;
    return say(ErrorCode::bad_input,
               "leadInMM (" + shortest_text(layer_.lead_in_mm) +
                   "mm) must be less than the mandrel windLength (" + shortest_text(mandrel_.length_mm) +
                   "mm); a longer lead-in drives the carriage off the mandrel into negative coordinates");
  }

  Fault circuit_count() const {
    if (native_) {
      HelicalLayer single = layer_;
      single.pattern = 1;
      const std::int64_t N = circuits(mandrel_, tow_, single, mode_);
      if (layer_.pattern <= N) return std::nullopt;
      return say(ErrorCode::no_path, {},
                 "patternNumber " + std::to_string(layer_.pattern) + " is more than the " +
                     std::to_string(N) + " circuits that cover the mandrel; use at most " +
                     std::to_string(N));
    }
    const std::int64_t N = circuits(mandrel_, tow_, layer_, mode_);
    if (N % layer_.pattern == 0) return std::nullopt;
    return say(ErrorCode::no_path, "computed circuit count is not divisible by patternNumber (" +
                                       std::to_string(N) + " % " + std::to_string(layer_.pattern) + " != 0)");
  }

  std::string listed_locks() const {
    const auto locks = closing_locks(layer_.lock_deg, layer_.skip, layer_.pattern, mode_);
    if (locks.empty()) return "multiples of 180°";
    std::string text;
    for (const double lock : locks) {
      text += (text.empty() ? "" : ", ") + (native_ ? shortest_lock(lock) : significant_text(lock, 6)) + "°";
    }
    return text;
  }

  // As many digits as it takes to fall into a slot when it is typed in again.
  std::string shortest_lock(double lock) const {
    for (int digits = 6; digits < 17; ++digits) {
      const std::string text = significant_text(lock, digits);
      if (lock_remainder_deg(std::stod(text), layer_.pattern, mode_) <= 1e-7) return text;
    }
    return shortest_text(lock);
  }

  Fault slots() const {
    const std::int64_t p = layer_.pattern;
    if (p == 1 && !native_) return std::nullopt;
    if (lock_remainder_deg(layer_.lock_deg, p, mode_) <= (native_ ? 1e-6 : 5e-7)) return std::nullopt;
    const double slots = static_cast<double>(p);
    return say(ErrorCode::no_path,
               "lockDegrees " + shortest_text(layer_.lock_deg) +
                   "° produces a per-circuit mandrel advance of " +
                   significant_text(modulo(2 * layer_.lock_deg, 360), 6) +
                   "° (mod 360°), which is not divisible by the in-pattern slot width of " +
                   significant_text(360 / slots, 6) + "° (= 360 / patternNumber " + std::to_string(p) +
                   "). Circuits will overlap and leave bare mandrel strips. lockDegrees must be a multiple "
                   "of " +
                   significant_text(180 / slots, 6) + "°. Nearest valid values: " + listed_locks(),
               "lockDegrees " + shortest_text(layer_.lock_deg) + "° is not a multiple of " +
                   significant_text(180 / slots, 10) +
                   "° (180 / patternNumber), which leaves bare strips; use " + listed_locks());
  }

  Fault aliases() const {
    const std::int64_t p = layer_.pattern;
    if (p == 1) return std::nullopt;
    const std::int64_t stride = slot_stride(layer_.lock_deg, layer_.skip, p);
    const std::int64_t common = std::gcd(stride, p);
    if (common == 1) return std::nullopt;
    const std::string start = "lockDegrees " + shortest_text(layer_.lock_deg) + "° with skipIndex " +
                              std::to_string(layer_.skip) + " and patternNumber " + std::to_string(p);
    return say(ErrorCode::no_path,
               start + " produces an intra-pattern slot stride of " + std::to_string(stride) +
                   " (in units of " + significant_text(360 / static_cast<double>(p), 6) +
                   "°), which is not coprime with patternNumber (gcd = " + std::to_string(common) +
                   "). All in-pattern circuits will alias onto fewer positions, leaving bare strips. "
                   "Nearest valid lockDegrees values: " +
                   listed_locks(),
               start + " puts " + std::to_string(p) + " circuits into " + std::to_string(p / common) +
                   " slots, which leaves bare strips; use lockDegrees " + listed_locks());
  }

  const WindMandrel& mandrel_;
  const WindTow& tow_;
  const HelicalLayer& layer_;
  std::size_t number_;
  bool native_;
  WindMode mode_;
};

bool is_terminal(const WindLayer& layer) {
  const auto* hoop = std::get_if<HoopLayer>(&layer);
  return hoop != nullptr && hoop->terminal;
}

}  // namespace

Fault first_fault(const WindDefinition& definition, WindMode mode) {
  for (std::size_t i = 0; i < definition.layers.size(); ++i) {
    const WindLayer& layer = definition.layers[i];
    const std::size_t number = i + 1;
    if (i > 0 && is_terminal(definition.layers[i - 1])) {
      return LayerFault{number, "terminal layer must be the final entry in the definition",
                        ErrorCode::bad_input};
    }
    if (std::holds_alternative<HoopLayer>(layer) && definition.mandrel.is_cone()) {
      return LayerFault{number, "hoop layers on a cone are not supported yet", ErrorCode::no_path};
    }
    if (const auto* helical = std::get_if<HelicalLayer>(&layer)) {
      if (Fault found = HelicalJudge(definition, *helical, number, mode).fault()) return found;
    }
  }
  return std::nullopt;
}

}  // namespace afptraj
