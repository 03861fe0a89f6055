#pragma once

#include "boundary/ply.h"
#include "geometry/skin.h"

namespace afptraj {

/// What the tows of a ply cover: gaps and overlaps as polygons of the skin, their areas, and bounds for the
/// errors of the areas.
///
/// Law (A1): covered + gap = skin, to `error_mm2`; the skin's area comes from the loops of the faces alone.
/// Law (A2): laid - off skin - overlap = covered, to `error_mm2` + `laid_error_mm2`; laid is the sum over all
/// pieces of Simpson's rule across the tow on the lengths of its edges and its middle (geodesic parallels cut
/// the surface into ds dw exactly). Off the skin is the polygons' where a band stays on one chart; on tows
/// that go on over an edge between faces or over a seam, the trapezoidal rule on the lengths of the three
/// lines off the skin. Both laws fail where tows fold (edges that cross each other), and where a face lies
/// between the edges of one tow.
///
/// `error_mm2` is the length of all boundaries times what lines and chords may be off, what cuts and grid
/// add, and the integration's estimated error.
///
/// Where a band lies over itself its pieces on one face are told apart; a piece that lies over itself within
/// one chart (a loop) counts as one layer, and (A2) shows it. A region that spans several faces is a polygon
/// on each.
///
/// `line_tolerance_mm`: what tow lines may be off, TowLineOptions::tolerance_mm.
TowCoverage measure_tow_coverage(const Skin& skin, const Ply& ply, double line_tolerance_mm = 1e-3);

}  // namespace afptraj
