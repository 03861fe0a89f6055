#include "io/fill_programs.h"

#include <algorithm>

#include "io/number_text.h"

namespace afptraj {

std::string fill_gcode(const Fill& fill, const GcodeOptions& options) {
  constexpr int places = 4, e_places = 5;
  std::string text = "G21\nG90\n";
  if (options.extrusion_mm_per_mm > 0) text += "M83\n";
  const auto xy = [&](const Vec2& p) {
    text += " X";
    append_number(text, p.x(), places);
    text += " Y";
    append_number(text, p.y(), places);
  };
  double owed = 0;  // of E, by rounding
  for (std::size_t k = 0; k < fill.paths.size(); ++k) {
    const Polyline& line = fill.paths[k].line;
    if (line.points.empty()) continue;
    text += "; path " + std::to_string(k) + "\nG0";
    xy(line.points.front());
    if (k == 0) text += " Z" + number_text(options.z_mm, places);
    text += '\n';
    const std::size_t n = line.points.size();
    for (std::size_t i = 1; i < n + (line.closed ? 1 : 0); ++i) {
      const Vec2 &from = line.points[i - 1], &to = line.points[i % n];
      text += "G1";
      xy(to);
      if (options.extrusion_mm_per_mm > 0) {
        owed += (to - from).norm() * options.extrusion_mm_per_mm;
        const std::string now = number_text(std::max(owed, 0.0), e_places);
        owed -= parse_number(now).value_or(0);
        text += " E" + now;
      }
      if (i == 1) text += " F" + number_text(options.feed_mm_per_min, places);
      text += '\n';
    }
  }
  return text + "M2\n";
}

std::string fill_vtp(const Fill& fill, double z_mm) {
  std::size_t points = 0;
  for (const FillPath& path : fill.paths) points += path.line.points.size();
  const std::string lines = std::to_string(fill.paths.size());
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"0.1\" "
      "byte_order=\"LittleEndian\">\n<PolyData>\n"
      "<Piece NumberOfPoints=\"" +
      std::to_string(points) + "\" NumberOfVerts=\"0\" NumberOfLines=\"" + lines +
      "\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n";
  const auto array = [&](const std::string& type, const std::string& name, const auto& content) {
    text += "<DataArray type=\"" + type + "\" Name=\"" + name + "\" format=\"ascii\"" +
            (name == "points" ? " NumberOfComponents=\"3\"" : "") + ">\n";
    content();
    text += "</DataArray>\n";
  };
  const auto cells = [&](const std::string& name, const auto& value) {
    array("Int32", name, [&] {
      for (std::size_t k = 0; k < fill.paths.size(); ++k) text += std::to_string(value(k)) + "\n";
    });
  };
  text += "<Points>\n";
  array("Float64", "points", [&] {
    const std::string z = " " + number_text(z_mm) + "\n";
    for (const FillPath& path : fill.paths) {
      for (const Vec2& p : path.line.points) {
        append_number(text, p.x());
        text += ' ';
        append_number(text, p.y());
        text += z;
      }
    }
  });
  text += "</Points>\n<Lines>\n";
  array("Int64", "connectivity", [&] {
    std::size_t first = 0;
    for (const FillPath& path : fill.paths) {
      const std::size_t n = path.line.points.size();
      for (std::size_t i = 0; i < n; ++i) text += std::to_string(first + i) + " ";
      text += path.line.closed ? std::to_string(first) + "\n" : "\n";
      first += n;
    }
  });
  array("Int64", "offsets", [&] {
    std::size_t end = 0;
    for (const FillPath& path : fill.paths)
      text += std::to_string(end += path.line.points.size() + (path.line.closed ? 1 : 0)) + "\n";
  });
  text += "</Lines>\n<CellData>\n";
  cells("path", [&](std::size_t k) { return k; });
  cells("kind", [&](std::size_t k) { return static_cast<int>(fill.paths[k].kind); });
  cells("level", [&](std::size_t k) { return fill.paths[k].level; });
  return text + "</CellData>\n</Piece>\n</PolyData>\n</VTKFile>\n";
}

}  // namespace afptraj
