#pragma once

#include <optional>
#include <vector>

#include "boundary/ply.h"
#include "geometry/skin.h"

namespace afptraj {

/// A piece of a tow, as far as it lies on one face: the stretches of its left and right edge in the face's
/// (u, v), both in the tow's direction. Where an edge has left the face and the other has not, it goes on
/// straight in (u, v), off the face: cut with the face's loops the strip is what the tow covers of it.
struct TowStrip {
  int face = -1;
  std::size_t band = 0;
  int course = 0, tow = 1;
  bool turned = false;  ///< in (u, v) left is right
  bool whole = true;    ///< all of the piece; else it goes on in another chart
  std::vector<Uv> left, right;
  std::optional<Uv> start, end;  ///< the middle of a cut
  double ends_mm2 = 0;           ///< bounds what straight lines of (u, v) miss of the cuts
};

/// The strips of all tows, in the order of bands. Edges that two tows of a band share have the same points in
/// both. `chord_mm` bounds the distance of an edge's cubics from the chords between its points.
std::vector<TowStrip> tow_strips(const Skin& skin, const Ply& ply, double chord_mm);

}  // namespace afptraj
