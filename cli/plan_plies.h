#pragma once

#include <vector>

#include "boundary/plan_ply.h"
#include "cli/arguments.h"
#include "io/job_toml.h"
#include "io/plies_csv.h"

namespace afptraj::cli {

/// Plans and judges all plies, side by side. A stop asked for, seen by a planner, becomes Stopped; of several
/// plies that cannot be planned the first is the one thrown, whichever failed first.
std::vector<Ply> plan_plies(const Skin& skin, const std::vector<PlyOrientation>& orientations,
                            const Arguments& arguments, const Job& job);

}  // namespace afptraj::cli
