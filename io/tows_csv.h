#pragma once

#include <string>
#include <vector>

#include "boundary/ply.h"
#include "io/text_sink.h"

namespace afptraj {

/// The content of tows.csv: a header and one row per sample of the middle line of every tow piece, in the order of plies,
/// courses, tows, segments, points. `event` is "add" in the first row of a piece, "cut" in the last.
/// Columns: ply,course,tow,segment,point,event,s_mm,x,y,z,nx,ny,nz,tx,ty,tz.
/// Lengths and unit vectors to 1e-9. Throws Error(internal) for a NaN.
///
/// It may be far larger than the plies' own data: it is handed on some 10 MB at a time, put into text by several threads.
void tows_csv(const std::vector<Ply>& plies, const TextSink& sink);

/// The same as one text.
std::string tows_csv(const std::vector<Ply>& plies);

}  // namespace afptraj
