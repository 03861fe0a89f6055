#pragma once

#include <TopoDS_Shape.hxx>
#include <filesystem>
#include <gp_Pnt.hxx>
#include <gp_Vec.hxx>
#include <string>
#include <vector>

namespace samples {

/// One row of plies.csv.
struct PlyRow {
  std::string ply;
  gp_Pnt position;
  gp_Vec direction;
  bool start = false;
};

/// Writes the shape as AP214 in millimetres. The header carries `name` and a fixed date, so that the
/// same shape gives the same bytes.
void write_part(const std::filesystem::path& file, const std::string& name, const TopoDS_Shape& shape);

void write_plies(const std::filesystem::path& file, const std::vector<PlyRow>& rows);

}  // namespace samples
