#pragma once

#include <string>
#include <vector>

#include "boundary/ply.h"

namespace afptraj {

/// `text` as a CSV field: quoted where RFC 4180 needs it, and where a spreadsheet would take the
/// field for a formula or a reader for a comment.
std::string csv_field(const std::string& text);

/// The content of paths.csv: a header and one row per sample of each course's centre line, in the
/// order of plies, courses, segments, points. Segments and points are numbered from 1.
/// Columns: ply,course,segment,point,s_mm,x,y,z,nx,ny,nz,tx,ty,tz,kn_per_mm,kg_per_mm,deviation_deg.
/// Lengths and unit vectors to 1e-9, curvatures to 1e-12. Throws Error(internal) for a NaN.
std::string paths_csv(const std::vector<Ply>& plies);

}  // namespace afptraj
