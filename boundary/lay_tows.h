#pragma once

#include <optional>
#include <vector>

#include "boundary/ply.h"
#include "boundary/tow_cuts.h"
#include "trajectory/parallels.h"

namespace afptraj {

/// The tows of a ply and what they came to.
struct LaidTows {
  std::vector<TowBand> bands;    ///< empty unless asked for
  std::vector<TowPiece> pieces;  ///< by course, tow, segment
  TowReport report;
};

/// Cuts the tows of all courses: lines of each tow (tow_lines.h) clipped against all loops of the skin (clip.h: exact in
/// (u, v)), the rule of tow_cuts.h, then minimum gap and minimum cut length along the tow's middle line. A tow is cut
/// square to its course. Where lines break off (no ray leads on) the tow does.
///
/// Samples stand at the ends and at the nodes of the middle line, at most `options.station_mm` apart along the course.
///
/// Lines take three times the memory of the samples; a band's are freed as soon as its tows are cut, but for `keep_bands`.
LaidTows lay_tows(const Skin& skin, const std::vector<LevelCurve>& levels, const TowLineOptions& options,
                  const CutRule& rule, bool keep_bands = true);

/// Where a line is on the skin. A closed line is cut where it begins.
Stretches on_skin(const Skin& skin, const TowLine& line);

/// The frame of a line at t; nothing where it has no run.
std::optional<CurveFrame> frame_on(const Skin& skin, const TowLine& line, double t);

}  // namespace afptraj
