#pragma once

#include <string>
#include <vector>

#include "geometry/types.h"

namespace afptraj {

/// Sorted, disjoint stretches of a line's parameter.
using Stretches = std::vector<Interval>;

/// What becomes of a piece of a tow that is shorter than the machine can lay.
enum class ShortTows { symmetric, forward, backward, drop };

/// The word for it, and back; nothing for another word.
const char* to_string(ShortTows rule);
std::vector<std::string> short_tow_words();
ShortTows short_tows_of(const std::string& word);

/// When a tow is cut and added again.
struct CutRule {
  /// p in [0, 1]: how much of the tow's width may lie off the skin. 0: it is cut where its first edge leaves (gaps), 1:
  /// where its last edge leaves (overlap).
  double coverage_rule = 0.5;
  double min_cut_length_mm = 101.6;
  ShortTows short_tows = ShortTows::symmetric;
  double min_gap_mm = 25;  ///< narrower gaps between two pieces of a tow are laid through
};

/// Where the lines of one tow are on the skin: its edges, its middle, and those within it at p of its width from the
/// left and from the right edge (edges for p = 0 and 1, the middle for 1/2).
struct TowCover {
  Stretches left, right, middle, from_left, from_right;
};

/// Where the tow is laid. With one edge off the skin the line at p of the width from that edge decides: at a straight
/// boundary the cut then lies at p between the places where the two edges leave. Where both edges are on the skin the
/// middle must be too (a hole within the tow; not for p = 1); where both are off, only p = 1 lays, on the middle.
Stretches apply_rule(const TowCover& cover, double p);

/// Lengths in mm along one tow, over [0, length]; `closed`: the end is the start.
struct TowRun {
  Interval range;
  bool closed = false;
};

/// What is cut off by minimum gap and minimum cut length: gaps below the minimum are laid through, then pieces below the
/// minimum are extended, as far as the run goes, or dropped; pieces that come closer than the minimum gap thereby are
/// joined. A piece that cannot be extended to the minimum is dropped. Doing it twice changes nothing.
/// On a closed run a piece may end beyond range.hi: it goes on from range.lo.
struct CutResult {
  Stretches pieces;
  int bridged = 0, extended = 0, dropped = 0;
};
CutResult settle_pieces(Stretches pieces, const TowRun& run, const CutRule& rule);

}  // namespace afptraj
