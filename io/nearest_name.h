#pragma once

#include <string>
#include <vector>

namespace afptraj {

/// The candidate nearest to `name` in spelling (insertions, deletions, changes and swaps of
/// neighbours, case ignored), empty when none is near enough to be a slip: more than a third of
/// the letters, or more than three, would have to change. The first wins where two are as near.
std::string nearest_name(const std::string& name, const std::vector<std::string>& candidates);

/// "; did you mean 'x'?" or nothing: the tail of a message about an unknown name.
std::string did_you_mean(const std::string& name, const std::vector<std::string>& candidates);

}  // namespace afptraj
