#include "analysis/tow_coverage.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "analysis/face_overlay.h"
#include "boundary/lay_tows.h"

namespace afptraj {
namespace {

constexpr double chord_mm = 5e-4;

/// Lengths along a line between two of its parameters, over all its runs.
class LineLength {
 public:
  LineLength(const Skin& skin, const TowLine& line) : skin_(skin) {
    for (const SurfaceCurve& run : line.runs)
      for (const auto& piece : run.pieces)
        for (std::size_t i = 0; i + 1 < piece.size(); ++i) {
          spans_.push_back({&piece, i, length_});
          length_ += arc_length(skin, piece, i, 0, 1);
        }
  }
  double over(const Interval& range) const {
    return range.hi > range.lo ? up_to(range.hi) - up_to(range.lo) : 0;
  }

 private:
  struct Span {
    const std::vector<CurveNode>* piece;
    std::size_t i;
    double before;
    double first() const { return (*piece)[i].t; }
    double last() const { return (*piece)[i + 1].t; }
  };
  double up_to(double t) const {
    const auto it =
        std::partition_point(spans_.begin(), spans_.end(), [t](const Span& s) { return s.last() <= t; });
    if (it == spans_.end()) return length_;
    if (t <= it->first()) return it->before;
    return it->before +
           arc_length(skin_, *it->piece, it->i, 0, (t - it->first()) / (it->last() - it->first()));
  }

  const Skin& skin_;
  std::vector<Span> spans_;
  double length_ = 0;
};

struct LaidArea {
  double laid_mm2 = 0, off_skin_mm2 = 0, laid_error_mm2 = 0, off_error_mm2 = 0;
};

/// Area of the pieces of one band by the lengths of their lines.
LaidArea laid_area(const Skin& skin, const TowBand& band, const std::vector<const TowPiece*>& pieces) {
  LaidArea out;
  if (pieces.empty()) return out;
  struct Line {
    LineLength length;
    Stretches on_skin;
  };
  const auto measured = [&](const TowLine& line) {
    return Line{LineLength(skin, line), on_skin(skin, line)};
  };
  std::vector<Line> edges, middles;
  for (const TowLine& line : band.edges) edges.push_back(measured(line));
  for (const TowLine& line : band.middles) middles.push_back(measured(line));
  for (const TowPiece* piece : pieces) {
    const auto j = static_cast<std::size_t>(piece->tow);
    const double width = band.edges[j - 1].offset_mm - band.edges[j].offset_mm,
                 round = band.last - band.first;
    std::vector<Interval> ranges = {{piece->range.lo, std::min(piece->range.hi, band.last)}};
    if (piece->range.hi > band.last) ranges.push_back({band.first, piece->range.hi - round});
    double all[3] = {}, off[3] = {};
    const Line* lines[3] = {&edges[j - 1], &middles[j - 1], &edges[j]};
    for (int k = 0; k < 3; ++k)
      for (const Interval& range : ranges) {
        const double here = lines[k]->length.over(range);
        all[k] += here;
        off[k] += here;
        for (const Interval& on : lines[k]->on_skin)
          off[k] -= lines[k]->length.over({std::max(on.lo, range.lo), std::min(on.hi, range.hi)});
      }
    const double bend = all[0] - 2 * all[1] + all[2];
    out.laid_mm2 += width / 6 * (all[0] + 4 * all[1] + all[2]);
    if (all[1] > 0) out.laid_error_mm2 += width * bend * bend / all[1] / 180;  // Simpson's, with y'' = -K y
    out.off_skin_mm2 += width / 4 * (off[0] + 2 * off[1] + off[2]);
    // The lengths off the skin may run in any monotone way from line to line.
    out.off_error_mm2 += width / 4 * (std::abs(off[0] - off[1]) + std::abs(off[1] - off[2]));
  }
  return out;
}

}  // namespace

TowCoverage measure_tow_coverage(const Skin& skin, const Ply& ply, double line_tolerance_mm) {
  const std::vector<TowStrip> strips = tow_strips(skin, ply, chord_mm);
  const std::vector<int>& faces = skin.faces();
  const double slack = line_tolerance_mm + chord_mm;
  std::vector<FaceOverlay> overlays(faces.size());
  tbb::parallel_for(std::size_t{0}, faces.size(), [&](std::size_t i) {
    std::vector<const TowStrip*> here;
    for (const TowStrip& strip : strips)
      if (strip.face == faces[i]) here.push_back(&strip);
    overlays[i] = overlay(skin, faces[i], here, chord_mm, slack);
  });
  std::vector<std::vector<const TowPiece*>> pieces(ply.bands.size());
  for (const TowPiece& piece : ply.tows) pieces[piece.band].push_back(&piece);
  std::vector<LaidArea> laid(ply.bands.size());
  tbb::parallel_for(std::size_t{0}, laid.size(),
                    [&](std::size_t b) { laid[b] = laid_area(skin, ply.bands[b], pieces[b]); });
  std::vector<bool> one_chart(ply.bands.size(), true);
  for (const TowStrip& strip : strips)
    if (!strip.whole) one_chart[strip.band] = false;

  TowCoverage out;
  out.measured = true;
  for (std::size_t b = 0; b < laid.size(); ++b) {
    out.laid_mm2 += laid[b].laid_mm2;
    out.laid_error_mm2 += laid[b].laid_error_mm2;
    if (one_chart[b]) continue;
    out.off_skin_mm2 += laid[b].off_skin_mm2;
    out.laid_error_mm2 += laid[b].off_error_mm2;
  }
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const FaceOverlay& face = overlays[i];
    out.skin_mm2 += face.face_mm2;
    const double grid = 2 * face.grid_mm;
    out.error_mm2 += face.boundary_mm * (slack + grid) + face.loops_mm * (0.2 * chord_mm + grid) +
                     face.ends_mm2 + face.area_error_mm2;
    for (const OverlayRegion& region : face.regions) {
      if (!region.on_skin) {
        for (const std::size_t band : region.bands)
          if (one_chart[band]) out.off_skin_mm2 += region.area_mm2;
        continue;
      }
      const std::size_t layers = region.bands.size();
      (layers == 0 ? out.gap_mm2 : out.covered_mm2) += region.area_mm2;
      if (layers > 1) out.overlap_mm2 += static_cast<double>(layers - 1) * region.area_mm2;
      if (!region.wide) continue;
      TowSpot spot;
      spot.layers = static_cast<int>(layers);
      spot.area_mm2 = region.area_mm2;
      spot.length_mm = region.shape.length_mm;
      spot.width_mm = region.shape.width_mm;
      spot.where = region.shape.where;
      spot.tows = region.tows;
      spot.at_boundary = region.at_boundary;
      spot.face = faces[i];
      spot.outline = region.outline;
      out.spots.push_back(std::move(spot));
    }
  }
  out.skin_residual_mm2 = out.skin_mm2 - out.covered_mm2 - out.gap_mm2;
  out.laid_residual_mm2 = out.laid_mm2 - out.off_skin_mm2 - out.overlap_mm2 - out.covered_mm2;
  std::stable_sort(out.spots.begin(), out.spots.end(),
                   [](const TowSpot& a, const TowSpot& b) { return a.area_mm2 > b.area_mm2; });
  return out;
}

}  // namespace afptraj
