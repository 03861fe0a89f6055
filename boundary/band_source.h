#pragma once

#include <optional>

#include "trajectory/source_curve.h"

namespace afptraj {

/// A centre line with geodesics before its start and after its end: what the rays of its tows leave from. Internal to
/// this room. Its parameter is the curve's; beyond the ends arc length goes on from there.
class BandSource : public SourceCurve {
 public:
  BandSource(const Skin& skin, const SurfaceCurve& curve) : skin_(&skin), curve_(&curve) {}

  /// Goes on past the start or the end over these states, which begin there.
  void extend(const GeodesicTracer& tracer, std::vector<GeodesicState> states, bool backward) {
    (backward ? before_ : after_).emplace(tracer, std::move(states), backward);
  }

  double first() const override { return curve_->first() + (before_ ? before_->first() : 0); }
  double last() const override { return curve_->last() + (after_ ? after_->last() : 0); }
  bool closed() const override { return curve_->closed; }
  Frame at(double t) const override {
    if (before_ && t < curve_->first()) return before_->at(t - curve_->first());
    if (after_ && t > curve_->last()) return after_->at(t - curve_->last());
    Frame out;
    static_cast<CurveFrame&>(out) = frame_at(*skin_, *curve_, t);
    out.outside = !skin_->trim(out.at.face).contains(out.at.uv);
    return out;
  }

 private:
  const Skin* skin_;
  const SurfaceCurve* curve_;
  std::optional<GeodesicPath> before_, after_;
};

}  // namespace afptraj
