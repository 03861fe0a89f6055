// Makes ply points on the surface of a STEP part, or lists its faces:
//   make_plies part.step --list
//   make_plies part.step --faces LIST -o plies.csv [--count 40] [--ply NAME] [--unit m]
//              [--direction x,y,z] [--angle DEG] [--axis ox,oy,oz,dx,dy,dz] [--start x,y,z]
// The direction is a vector of space, or with --axis the meridian of a body of revolution, laid into
// the tangent plane and turned by --angle about the normal. Points are spread evenly by area (Halton).
#include <BRepBndLib.hxx>
#include <BRepGProp.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <GProp_GProps.hxx>
#include <Standard_Failure.hxx>
#include <cmath>
#include <cstdio>
#include <exception>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "occt_skin.h"
#include "step_faces.h"

namespace {

using oracle::Foot;
using oracle::Skin;
using oracle::Vec;

std::vector<double> numbers(const std::string& text, std::size_t count) {
  std::vector<double> out;
  std::istringstream in(text);
  for (std::string item; std::getline(in, item, ',');) out.push_back(std::stod(item));
  if (out.size() != count)
    throw std::runtime_error("'" + text + "' is not " + std::to_string(count) + " numbers");
  return out;
}

double halton(int index, int base) {
  double f = 1, r = 0;
  for (int i = index; i > 0; i /= base) {
    f /= base;
    r += f * (i % base);
  }
  return r;
}

void list(const std::vector<oracle::StepFace>& faces) {
  for (const oracle::StepFace& f : faces) {
    GProp_GProps properties;
    BRepGProp::SurfaceProperties(f.face, properties);
    Bnd_Box box;
    BRepBndLib::Add(f.face, box);
    double x0, y0, z0, x1, y1, z1;
    box.Get(x0, y0, z0, x1, y1, z1);
    std::printf("%4d  #%-6d %-32s area %14.2f  box (%.1f %.1f %.1f) (%.1f %.1f %.1f)\n", f.number, f.step_id,
                BRep_Tool::Surface(f.face)->DynamicType()->Name(), properties.Mass(), x0, y0, z0, x1, y1, z1);
  }
}

struct Rule {
  Vec direction{1, 0, 0};
  double angle = 0;
  bool axial = false;
  Vec origin{0, 0, 0};
};

// The direction at a foot, of unit length; zero where the rule has none.
Vec direction_at(const Skin& skin, const Foot& at, const Rule& rule) {
  const Vec n = skin.jet(at.face, at.u, at.v).normal();
  Vec zero = rule.direction;
  if (rule.axial) {
    // The meridian: at right angles to the hoop, along the axis where both agree.
    const Vec radial = at.point - rule.origin - rule.direction * ((at.point - rule.origin) * rule.direction);
    zero = (rule.direction ^ radial) ^ n;
  }
  zero -= n * (zero * n);
  if (zero.Modulus() < 1e-3 * rule.direction.Modulus()) return Vec(0, 0, 0);
  zero.Normalize();
  return zero * std::cos(rule.angle) + (n ^ zero) * std::sin(rule.angle);
}

// Points spread by area: a Halton sequence over face boxes, thinned by the area element.
std::vector<Foot> spread(const Skin& skin, int count) {
  struct Piece {
    double area, greatest;
  };
  std::vector<Piece> pieces;
  double total = 0;
  for (int i = 0; i < skin.size(); ++i) {
    const auto& b = skin.box(i);
    Piece piece{0, 0};
    for (int k = 1; k <= 400; ++k) {
      const double u = b[0] + (b[1] - b[0]) * halton(k, 2), v = b[2] + (b[3] - b[2]) * halton(k, 3);
      const oracle::Jet j = skin.jet(i, u, v);
      const double element = (j.Su ^ j.Sv).Modulus();
      piece.greatest = std::max(piece.greatest, element);
      if (skin.inside(i, u, v)) piece.area += element * (b[1] - b[0]) * (b[3] - b[2]) / 400;
    }
    pieces.push_back(piece);
    total += piece.area;
  }
  std::vector<Foot> feet;
  for (int i = 0; i < skin.size(); ++i) {
    const auto& b = skin.box(i);
    const Piece& piece = pieces[static_cast<std::size_t>(i)];
    const int wanted = static_cast<int>(std::ceil(count * piece.area / total));
    int made = 0;
    for (int k = 1; made < wanted && k < 200 * wanted + 2000; ++k) {
      const double u = b[0] + (b[1] - b[0]) * halton(k, 2), v = b[2] + (b[3] - b[2]) * halton(k, 3);
      const oracle::Jet j = skin.jet(i, u, v);
      if ((j.Su ^ j.Sv).Modulus() < piece.greatest * halton(k, 5) || !skin.inside(i, u, v)) continue;
      feet.push_back({i, u, v, j.S, 0});
      ++made;
    }
  }
  return feet;
}

void write(const Skin& skin, const Rule& rule, int count, const std::string& ply, const Vec* start,
           const std::string& file) {
  std::vector<std::pair<Foot, Vec>> rows;
  Vec middle(0, 0, 0);
  for (const Foot& foot : spread(skin, count)) {
    const Vec d = direction_at(skin, foot, rule);
    if (d.Modulus() == 0) continue;
    rows.emplace_back(foot, d);
    middle += foot.point;
  }
  if (rows.empty()) throw std::runtime_error("no point with a direction");
  middle /= static_cast<double>(rows.size());
  const Vec target = start ? *start : middle;
  std::size_t first = 0;
  for (std::size_t i = 1; i < rows.size(); ++i)
    if ((rows[i].first.point - target).Modulus() < (rows[first].first.point - target).Modulus()) first = i;
  std::ofstream out(file);
  out << "ply,x,y,z,dx,dy,dz,start\n";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto& [foot, d] = rows[i];
    char line[256];
    std::snprintf(line, sizeof line, ",%.9f,%.9f,%.9f,%.9f,%.9f,%.9f,%d\n", foot.point.X(), foot.point.Y(),
                  foot.point.Z(), d.X(), d.Y(), d.Z(), i == first ? 1 : 0);
    out << ply << line;
  }
}

int run(int argc, char** argv) {
  std::string part, output;
  std::map<std::string, std::string> value;
  bool listing = false;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--list")
      listing = true;
    else if (word == "-o" && i + 1 < argc)
      output = argv[++i];
    else if (word.rfind("--", 0) == 0 && i + 1 < argc)
      value[word.substr(2)] = argv[++i];
    else
      part = word;
  }
  if (part.empty() || (!listing && output.empty())) {
    std::fputs("usage: make_plies part.step --list | --faces LIST -o plies.csv [--direction x,y,z] ...\n",
               stderr);
    return 2;
  }
  const auto all = oracle::read_step_faces(part, value["unit"]);
  if (listing) {
    list(all);
    return 0;
  }
  std::vector<TopoDS_Face> faces;
  for (const oracle::StepFace& f : oracle::choose_faces(all, value["faces"])) faces.push_back(f.face);
  Rule rule;
  if (value.count("direction")) {
    const auto d = numbers(value["direction"], 3);
    rule.direction = Vec(d[0], d[1], d[2]);
  }
  if (value.count("axis")) {
    const auto d = numbers(value["axis"], 6);
    rule.axial = true;
    rule.origin = Vec(d[0], d[1], d[2]);
    rule.direction = Vec(d[3], d[4], d[5]).Normalized();
  }
  if (value.count("angle")) rule.angle = std::stod(value["angle"]) * 3.14159265358979323846 / 180;
  Vec start;
  if (value.count("start")) {
    const auto d = numbers(value["start"], 3);
    start = Vec(d[0], d[1], d[2]);
  }
  write(Skin(faces), rule, value.count("count") ? std::stoi(value["count"]) : 40,
        value.count("ply") ? value["ply"] : "P1", value.count("start") ? &start : nullptr, output);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const Standard_Failure& failure) {
    std::fprintf(stderr, "make_plies: %s\n", failure.GetMessageString());
  } catch (const std::exception& failure) {
    std::fprintf(stderr, "make_plies: %s\n", failure.what());
  }
  return 1;
}
