#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "geometry/part.h"

namespace afptraj {

struct StepReadOptions {
  /// "" obeys the file; "mm", "cm", "m", "in" or "ft" takes its numbers in that unit, whatever it declares.
  std::string unit_override;
  /// Free edges of loose faces and open shells that lie within this of each other are joined; 0
  /// joins nothing. Negative is automatic: 1e-4 of the part's diagonal, at most 0.1 mm. An edge
  /// shorter than 20 tolerances is joined only within a twentieth of its length.
  double sew_tolerance_mm = -1;
  /// The importer is stopped after this time, or when it asks for more memory than this.
  double timeout_s = 120;
  std::uint64_t memory_limit_bytes = std::uint64_t{4} << 30;
  /// Larger files are refused; OpenCASCADE needs about ten times the size of the file.
  std::uintmax_t max_file_bytes = 500u * 1000u * 1000u;
  /// Run OpenCASCADE in a child process, so that its crash becomes an Error. Off only for debuggers.
  bool isolate = true;
  /// Asked about ten times a second while the child works; true stops it (an interrupt).
  std::function<bool()> stop;
};

/// What a STEP file becomes: the part in mm, and what had to be assumed or repaired on the way.
struct StepModel {
  Part part;
  std::string schema;               ///< first FILE_SCHEMA entry, as written
  std::string declared_unit;        ///< name of the file's length unit, empty when it declares none
  double unit_scale_to_mm = 1;      ///< mm per unit of the numbers, the override included
  std::string sha256;               ///< of the bytes of the file, lower-case hexadecimal
  int solids = 0, shells = 0;       ///< as the file has them; each placed instance counts
  double sew_tolerance_mm = 0;      ///< tolerance used, 0 when there was nothing to join
  int sewn_edges = 0;               ///< edges that joining made shared
  double greatest_sewn_gap_mm = 0;  ///< greatest distance between the two sides of a joined edge
  double greatest_edge_gap_mm = 0;  ///< the same over all edges shared by two uses
  std::vector<std::optional<std::array<double, 3>>> colours;  ///< one per face: sRGB in [0, 1]
  std::vector<std::string> warnings;                          ///< one line each, for people
};

/// Reads AP203, AP214, AP242 (and the B-rep of AP209): solids, shells, loose faces, assemblies with
/// every instance placed. Every face comes with its loops closed in (u, v), material on the left.
///
/// Planes, cylinders, cones, spheres, tori and B-splines are kept as they are; every other kind
/// becomes a B-spline in the same parametrisation, within 1e-10 of the size of the face, at most
/// 1e-9 mm up to 5 m (beyond, rounding allows 2e-13 of the size).
///
/// Throws Error: bad_input for a file that is not a readable STEP part (one line: what, what to
/// do); resource_limit when OpenCASCADE ran out of time or memory, or crashed.
///
/// Not to be called from two threads at once: OpenCASCADE keeps the state of its readers global.
StepModel read_step(const std::filesystem::path& path, const StepReadOptions& options = {});

}  // namespace afptraj
