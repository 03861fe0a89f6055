#pragma once

#include <string>

#include "winding/machine_profile.h"

namespace afptraj {

/// Reads a machine profile (docs/winding.md, "Machines"). Throws Error(usage, "file:line:column", what is
/// wrong; what to do) for what is not TOML, unknown keys (with the nearest known), wrong types and values out
/// of range, letters that two axes share or that mean something else.
MachineProfile read_machine(const std::string& path);

}  // namespace afptraj
