#include "courses.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <stdexcept>

namespace oracle {
namespace {

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"') {
      if (quoted && i + 1 < line.size() && line[i + 1] == '"')
        fields.back() += line[++i];
      else
        quoted = !quoted;
    } else if (c == ',' && !quoted) {
      fields.emplace_back();
    } else if (c != '\r') {
      fields.back() += c;
    }
  }
  return fields;
}

}  // namespace

std::vector<PlyPaths> read_paths(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw std::runtime_error(path + ": cannot open");
  std::string line;
  std::getline(in, line);
  std::map<std::string, std::size_t> column;
  const std::vector<std::string> header = fields_of(line);
  for (std::size_t i = 0; i < header.size(); ++i) column[header[i]] = i;
  for (const char* name :
       {"ply", "course", "segment", "s_mm", "x", "y", "z", "nx", "ny", "nz", "tx", "ty", "tz"})
    if (!column.count(name)) throw std::runtime_error(path + ": no column " + name);

  std::vector<PlyPaths> plies;
  for (int number = 2; std::getline(in, line); ++number) {
    const std::vector<std::string> f = fields_of(line);
    if (f.size() != header.size())
      throw std::runtime_error(path + ":" + std::to_string(number) + ": wrong field count");
    const auto value = [&](const char* name) {
      const std::string& text = f[column[name]];
      char* end = nullptr;
      const double v = std::strtod(text.c_str(), &end);
      if (text.empty() || *end != 0 || !std::isfinite(v))
        throw std::runtime_error(path + ":" + std::to_string(number) + ": '" + text + "' in " + name);
      return v;
    };
    if (plies.empty() || plies.back().name != f[column["ply"]]) plies.push_back({f[column["ply"]], {}});
    auto& segments = plies.back().segments;
    const int course = static_cast<int>(value("course")), segment = static_cast<int>(value("segment"));
    if (segments.empty() || segments.back().course != course || segments.back().number != segment)
      segments.push_back({course, segment, {}, false});
    Sample s;
    s.s = value("s_mm");
    s.x = Vec(value("x"), value("y"), value("z"));
    s.n = Vec(value("nx"), value("ny"), value("nz"));
    s.t = Vec(value("tx"), value("ty"), value("tz"));
    s.kg = column.count("kg_per_mm") ? value("kg_per_mm") : 0;
    s.line = number;
    segments.back().samples.push_back(s);
  }
  for (PlyPaths& ply : plies) mark_closed(ply);
  return plies;
}

void mark_closed(PlyPaths& ply) {
  for (Segment& segment : ply.segments) {
    const Sample& a = segment.samples.front();
    const Sample& b = segment.samples.back();
    segment.closed = segment.samples.size() > 3 && (a.x - b.x).Modulus() < 1e-6 && a.t * b.t > 0.999;
  }
}

Segment::Point Segment::at(double s) const {
  const double first = samples.front().s;
  if (closed) s = first + (s - first) - length() * std::floor((s - first) / length());
  std::size_t lo = 0, hi = samples.size() - 1;
  while (hi - lo > 1) {
    const std::size_t mid = (lo + hi) / 2;
    (samples[mid].s <= s ? lo : hi) = mid;
  }
  const Sample& a = samples[lo];
  const Sample& b = samples[std::min(lo + 1, samples.size() - 1)];
  const double h = b.s - a.s;
  if (!(h > 0)) return {a.x, a.t, a.kg, lo};
  const double x = std::clamp((s - a.s) / h, 0.0, 1.0);
  const double h00 = (1 + 2 * x) * (1 - x) * (1 - x), h10 = x * (1 - x) * (1 - x);
  const double h01 = x * x * (3 - 2 * x), h11 = x * x * (x - 1);
  const double d00 = 6 * x * (x - 1), d10 = (1 - x) * (1 - 3 * x), d11 = x * (3 * x - 2);
  Point p;
  p.x = a.x * h00 + a.t * (h * h10) + b.x * h01 + b.t * (h * h11);
  p.t = (a.x * d00 + a.t * (h * d10) - b.x * d00 + b.t * (h * d11)).Normalized();
  p.kg = ((b.t - a.t) * (a.n ^ a.t)) / h;
  p.i = lo;
  return p;
}

}  // namespace oracle
