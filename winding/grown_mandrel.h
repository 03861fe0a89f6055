#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "winding/fibre_pass.h"
#include "winding/wind_definition.h"

namespace afptraj {

/// How thick a layer lies on a mandrel.
struct LayerGrowth {
  std::function<double(double t)> thickness_mm;  ///< by the meridian's parameter; once differentiable
  std::vector<double> kinks;                     ///< where its second derivative jumps
};

/// Of `circuits` circuits, there and back: with the tow's section w h spread over the circle that they cross,
///   H = N w h / (pi r cos(alpha)),
/// which grows beyond bounds where the fibre turns. Within two tows of that, along the meridian, it levels
/// off to what it is one and a half tows away, and beyond the turn it stays so: tows slump, and the edge of
/// the opening is taken as filled. `pass` and `meridian` must outlive it.
LayerGrowth helical_growth(const Meridian& meridian, const FibrePass& pass, std::int64_t circuits,
                           const WindTow& tow);

/// Of hoops, there and back, between two places of a meridian: two tows thick. Beyond, it fades as a cosine
/// over so much of the dome that this stays convex where it was, but at least two tows: the next layer's tows
/// and resin fill the step.
LayerGrowth hoop_growth(const Meridian& meridian, double first_t, double last_t, const WindTow& tow);

/// The mandrel with a layer on it: each place moves out along its normal by the thickness there, and splines
/// are laid through them between the places where the meridian's pieces meet and the growth's kinks.
/// Throws Error(no_path, "mandrel", ...) where the grown meridian runs back or reaches the axis.
Meridian grown_mandrel(const Meridian& meridian, const LayerGrowth& growth);

}  // namespace afptraj
