// A picture of courses on their part:
//   render_paths part.step paths.csv out.png --band MM [--tows N] [--faces LIST] [--unit m] [--ply NAME]
//                [--view x,y,z] [--up x,y,z] [--size 1600x1000] [--plies plies.csv]
// Each course is the band of its true width on the skin: what lies within W/2 of a centre line.
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRep_Tool.hxx>
#include <Poly_Triangulation.hxx>
#include <Standard_Failure.hxx>
#include <TopExp_Explorer.hxx>
#include <TopLoc_Location.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "checks.h"
#include "chord_index.h"
#include "png.h"
#include "step_faces.h"

namespace {

using oracle::Skin;
using oracle::Vec;
using Colour = std::array<double, 3>;

constexpr int oversampling = 2;

struct Vertex {
  Vec p, n;
};
struct Triangle {
  std::array<int, 3> v;
  int face;
};
struct Mesh {
  std::vector<Vertex> vertices;
  std::vector<Triangle> triangles;
};

Mesh mesh_of(const std::vector<TopoDS_Face>& faces, const Skin& skin) {
  Mesh mesh;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    BRepMesh_IncrementalMesh(faces[f], 2e-4 * skin.diagonal(), false, 0.05);
    TopLoc_Location location;
    const Handle(Poly_Triangulation) t = BRep_Tool::Triangulation(faces[f], location);
    if (t.IsNull()) continue;
    const int base = static_cast<int>(mesh.vertices.size());
    for (int i = 1; i <= t->NbNodes(); ++i) {
      const gp_Pnt2d uv = t->UVNode(i);
      const oracle::Jet j = skin.jet(static_cast<int>(f), uv.X(), uv.Y());
      mesh.vertices.push_back({t->Node(i).Transformed(location).XYZ(), j.normal()});
    }
    for (int i = 1; i <= t->NbTriangles(); ++i) {
      int a, b, c;
      t->Triangle(i).Get(a, b, c);
      mesh.triangles.push_back({{base + a - 1, base + b - 1, base + c - 1}, static_cast<int>(f)});
    }
  }
  return mesh;
}

// Orthographic: x to the right, y up, z toward the eye.
struct Camera {
  Vec right, up, toward;
  double scale = 1, x0 = 0, y0 = 0;
  int width = 0, height = 0;
  Vec project(const Vec& p) const {
    return Vec((p * right - x0) * scale + 0.5 * width, 0.5 * height - (p * up - y0) * scale, p * toward);
  }
};

Camera look(const Mesh& mesh, const Vec& toward, const Vec& up, int width, int height) {
  Camera camera;
  camera.toward = toward.Normalized();
  camera.right = (up ^ camera.toward).Normalized();
  camera.up = camera.toward ^ camera.right;
  camera.width = width;
  camera.height = height;
  double lo[2] = {1e300, 1e300}, hi[2] = {-1e300, -1e300};
  for (const Vertex& v : mesh.vertices) {
    const double c[2] = {v.p * camera.right, v.p * camera.up};
    for (int k = 0; k < 2; ++k) lo[k] = std::min(lo[k], c[k]), hi[k] = std::max(hi[k], c[k]);
  }
  camera.x0 = 0.5 * (lo[0] + hi[0]);
  camera.y0 = 0.5 * (lo[1] + hi[1]);
  camera.scale = 0.93 * std::min(width / (hi[0] - lo[0]), height / (hi[1] - lo[1]));
  return camera;
}

// What is seen in a pixel.
struct Fragment {
  float depth = -1e30f;
  int triangle = -1;
  float b1 = 0, b2 = 0;
};

std::vector<Fragment> rasterise(const Mesh& mesh, const Camera& camera) {
  std::vector<Fragment> image(static_cast<std::size_t>(camera.width) *
                              static_cast<std::size_t>(camera.height));
  std::vector<Vec> screen;
  for (const Vertex& v : mesh.vertices) screen.push_back(camera.project(v.p));
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& v = mesh.triangles[t].v;
    const Vec &a = screen[static_cast<std::size_t>(v[0])], &b = screen[static_cast<std::size_t>(v[1])],
              &c = screen[static_cast<std::size_t>(v[2])];
    const double area = (b.X() - a.X()) * (c.Y() - a.Y()) - (b.Y() - a.Y()) * (c.X() - a.X());
    if (std::abs(area) < 1e-12) continue;
    const int x0 = std::max(0, static_cast<int>(std::floor(std::min({a.X(), b.X(), c.X()}))));
    const int x1 = std::min(camera.width - 1, static_cast<int>(std::ceil(std::max({a.X(), b.X(), c.X()}))));
    const int y0 = std::max(0, static_cast<int>(std::floor(std::min({a.Y(), b.Y(), c.Y()}))));
    const int y1 = std::min(camera.height - 1, static_cast<int>(std::ceil(std::max({a.Y(), b.Y(), c.Y()}))));
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        const double px = x + 0.5 - a.X(), py = y + 0.5 - a.Y();
        const double b1 = (px * (c.Y() - a.Y()) - py * (c.X() - a.X())) / area;
        const double b2 = (py * (b.X() - a.X()) - px * (b.Y() - a.Y())) / area;
        if (b1 < -1e-9 || b2 < -1e-9 || b1 + b2 > 1 + 1e-9) continue;
        const float depth = static_cast<float>(a.Z() + b1 * (b.Z() - a.Z()) + b2 * (c.Z() - a.Z()));
        Fragment& f = image[static_cast<std::size_t>(y) * static_cast<std::size_t>(camera.width) +
                            static_cast<std::size_t>(x)];
        if (depth > f.depth) f = {depth, static_cast<int>(t), static_cast<float>(b1), static_cast<float>(b2)};
      }
    }
  }
  return image;
}

Colour mix(const Colour& a, const Colour& b, double x) {
  return {a[0] + (b[0] - a[0]) * x, a[1] + (b[1] - a[1]) * x, a[2] + (b[2] - a[2]) * x};
}

// The reference course stands out; left blue to violet, right teal to green; neighbours differ in lightness.
Colour course_colour(int course, int greatest) {
  if (course == 0) return {0.95, 0.55, 0.18};
  const double x = std::min(1.0, std::abs(course) / std::max(1.0, static_cast<double>(greatest)));
  const Colour base = course > 0 ? mix({0.25, 0.52, 0.86}, {0.50, 0.34, 0.72}, x)
                                 : mix({0.16, 0.62, 0.66}, {0.40, 0.68, 0.30}, x);
  return course % 2 == 0 ? mix(base, {1, 1, 1}, 0.22) : base;
}

struct Painter {
  const Skin& skin;
  const Mesh& mesh;
  const Camera& camera;
  const oracle::PlyPaths& ply;
  std::vector<double> sense;  // of each face: +1 where S_u x S_v is the courses' normal
  double band;
  int tows;
  int greatest = 1;
  oracle::ChordIndex index;

  static std::vector<int> all_segments(const oracle::PlyPaths& ply) {
    std::vector<int> all;
    for (std::size_t i = 0; i < ply.segments.size(); ++i) all.push_back(static_cast<int>(i));
    return all;
  }

  Painter(const Skin& s, const Mesh& m, const Camera& c, const oracle::PlyPaths& p, double band_mm,
          int tow_count)
      : skin(s),
        mesh(m),
        camera(c),
        ply(p),
        sense(static_cast<std::size_t>(s.size()), 0),
        band(band_mm),
        tows(tow_count),
        index(p, 0.5 * band_mm, all_segments(p)) {
    for (const oracle::Segment& segment : ply.segments) {
      greatest = std::max(greatest, std::abs(segment.course));
      for (const oracle::Sample& sample : segment.samples)
        if (sample.at.face >= 0)
          sense[static_cast<std::size_t>(sample.at.face)] +=
              skin.jet(sample.at.face, sample.at.u, sample.at.v).normal() * sample.n;
    }
  }

  Colour shaded(const Colour& colour, const Vec& n) const {
    const Vec key = (camera.toward + camera.up * 0.9 - camera.right * 0.7).Normalized();
    const Vec fill = (camera.toward + camera.right * 0.9).Normalized();
    const double diffuse = 0.34 + 0.56 * std::max(0.0, n * key) + 0.18 * std::max(0.0, n * fill);
    const double shine = 0.16 * std::pow(std::max(0.0, n * (key + camera.toward).Normalized()), 40);
    return {colour[0] * diffuse + shine, colour[1] * diffuse + shine, colour[2] * diffuse + shine};
  }

  Colour colour_at(const Vec& p, const Vec& normal, int face) const {
    const Colour bare = {0.80, 0.79, 0.76};
    const double f = sense[static_cast<std::size_t>(face)];
    const oracle::ChordHit hit = index.nearest(
        p, 0.5 * band, [&](const oracle::Sample& c) { return c.n * normal * (f < 0 ? -1 : 1) > 0.3; });
    if (hit.segment < 0) return bare;
    const oracle::Segment& segment = ply.segments[static_cast<std::size_t>(hit.segment)];
    const oracle::Sample& c = segment.samples[hit.i];
    const double side = (p - hit.point) * (c.n ^ c.t) < 0 ? -1 : 1;
    const double across = (0.5 + 0.5 * side * hit.distance / (0.5 * band)) * tows;  // 0 ... tows
    Colour colour = course_colour(segment.course, greatest);
    const double pixel = 1 / camera.scale, tow = band / tows;
    const double to_line = std::abs(across - std::round(across)) * tow;
    const bool edge = std::round(across) == 0 || std::round(across) == tows;
    if (edge && to_line < std::max(0.9 * pixel * oversampling, 0.004 * band))
      return mix(colour, {0, 0, 0}, 0.55);
    if (!edge && tow > 4 * oversampling * pixel && to_line < 0.5 * oversampling * pixel)
      colour = mix(colour, {0, 0, 0}, 0.16);
    if (hit.distance < 0.6 * oversampling * pixel) colour = mix(colour, {0, 0, 0}, 0.6);
    return colour;
  }

  std::vector<Colour> paint(const std::vector<Fragment>& image) const {
    std::vector<Colour> out(image.size(), Colour{1, 1, 1});
    for (std::size_t i = 0; i < image.size(); ++i) {
      const Fragment& f = image[i];
      if (f.triangle < 0) continue;
      const Triangle& t = mesh.triangles[static_cast<std::size_t>(f.triangle)];
      const Vertex &a = mesh.vertices[static_cast<std::size_t>(t.v[0])],
                   &b = mesh.vertices[static_cast<std::size_t>(t.v[1])],
                   &c = mesh.vertices[static_cast<std::size_t>(t.v[2])];
      const Vec p = a.p + (b.p - a.p) * f.b1 + (c.p - a.p) * f.b2;
      Vec n = a.n + (b.n - a.n) * f.b1 + (c.n - a.n) * f.b2;
      if (n.Modulus() > 0) n.Normalize();
      const Colour colour = colour_at(p, n, t.face);
      if (n * camera.toward < 0) n.Reverse();
      out[i] = shaded(colour, n);
    }
    return out;
  }
};

// A line of the drawing, where it is not hidden.
void stroke(const Camera& camera, const std::vector<Fragment>& image, std::vector<Colour>& out, const Vec& a,
            const Vec& b, double width_px, const Colour& colour, double opacity, double bias) {
  const Vec pa = camera.project(a), pb = camera.project(b);
  const int steps = static_cast<int>(std::hypot(pb.X() - pa.X(), pb.Y() - pa.Y())) * 2 + 1;
  const double r = 0.5 * width_px;
  for (int k = 0; k <= steps; ++k) {
    const Vec p = pa + (pb - pa) * (static_cast<double>(k) / steps);
    for (int y = static_cast<int>(p.Y() - r); y <= static_cast<int>(p.Y() + r); ++y) {
      for (int x = static_cast<int>(p.X() - r); x <= static_cast<int>(p.X() + r); ++x) {
        if (x < 0 || y < 0 || x >= camera.width || y >= camera.height) continue;
        if (std::hypot(x + 0.5 - p.X(), y + 0.5 - p.Y()) > r) continue;
        const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(camera.width) +
                              static_cast<std::size_t>(x);
        if (image[i].depth > p.Z() + bias) continue;
        out[i] = opacity >= 1 ? colour : mix(out[i], colour, opacity);
      }
    }
  }
}

void outline(const std::vector<TopoDS_Face>& faces, const Skin& skin, const Camera& camera,
             const std::vector<Fragment>& image, std::vector<Colour>& out) {
  for (std::size_t f = 0; f < faces.size(); ++f) {
    for (TopExp_Explorer it(faces[f], TopAbs_EDGE); it.More(); it.Next()) {
      const TopoDS_Edge edge = TopoDS::Edge(it.Current());
      if (BRep_Tool::Degenerated(edge)) continue;
      double first, last;
      const Handle(Geom2d_Curve) curve = BRep_Tool::CurveOnSurface(edge, faces[f], first, last);
      if (curve.IsNull()) continue;
      const auto at = [&](double t) {
        const gp_Pnt2d uv = curve->Value(t);
        return skin.jet(static_cast<int>(f), uv.X(), uv.Y()).S;
      };
      const bool joined = BRep_Tool::IsClosed(edge, faces[f]) ||
                          skin.other_face_at(at(0.5 * (first + last)), static_cast<int>(f)).has_value();
      constexpr int count = 300;
      for (int k = 0; k < count; ++k) {
        const Vec a = at(first + (last - first) * k / count),
                  b = at(first + (last - first) * (k + 1) / count);
        stroke(camera, image, out, a, b, (joined ? 1.0 : 2.2) * oversampling, {0.12, 0.12, 0.14},
               joined ? 0.5 : 1, 2e-3 * skin.diagonal());
      }
    }
  }
}

// Ply points as short strokes with a dot.
void draw_plies(const std::string& file, const std::string& ply, const Skin& skin, const Camera& camera,
                const std::vector<Fragment>& image, std::vector<Colour>& out, double band) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::istringstream row(line);
    std::string name, field;
    std::getline(row, name, ',');
    if (name != ply) continue;
    double v[6];
    for (double& x : v) {
      std::getline(row, field, ',');
      x = std::stod(field);
    }
    const Vec p(v[0], v[1], v[2]), d = Vec(v[3], v[4], v[5]).Normalized() * (0.6 * band);
    const double bias = 5e-3 * skin.diagonal();
    stroke(camera, image, out, p - d, p + d, 4 * oversampling, {1, 1, 1}, 1, bias);
    stroke(camera, image, out, p - d, p + d, 2 * oversampling, {0.1, 0.1, 0.12}, 1, bias);
    stroke(camera, image, out, p, p, 8 * oversampling, {1, 1, 1}, 1, bias);
    stroke(camera, image, out, p, p, 5.5 * oversampling, {0.1, 0.1, 0.12}, 1, bias);
  }
}

Vec vector_of(const std::string& text) {
  std::istringstream in(text);
  std::string item;
  double v[3] = {0, 0, 0};
  for (double& x : v) {
    std::getline(in, item, ',');
    x = std::stod(item);
  }
  return Vec(v[0], v[1], v[2]);
}

// Toward the eye: over the mean normal, from below and the left; a closed body from a corner.
Vec default_view(const Mesh& mesh, const std::vector<double>& sense, Vec& up) {
  Vec mean(0, 0, 0);
  double area = 0;
  for (const Triangle& t : mesh.triangles) {
    const Vec &a = mesh.vertices[static_cast<std::size_t>(t.v[0])].p,
              &b = mesh.vertices[static_cast<std::size_t>(t.v[1])].p,
              &c = mesh.vertices[static_cast<std::size_t>(t.v[2])].p;
    Vec n = (b - a) ^ (c - a);
    if (n * mesh.vertices[static_cast<std::size_t>(t.v[0])].n < 0) n.Reverse();
    if (sense[static_cast<std::size_t>(t.face)] < 0) n.Reverse();
    mean += n;
    area += n.Modulus();
  }
  if (mean.Modulus() < 0.3 * area) {
    up = Vec(0, 0, 1);
    return Vec(0.55, -0.75, 0.6);
  }
  mean.Normalize();
  up = std::abs(mean.Z()) > 0.8 ? Vec(0, 1, 0) : Vec(0, 0, 1);
  const Vec right = (up ^ mean).Normalized();
  return mean - (mean ^ right) * 0.75 - right * 0.3;
}

std::vector<std::uint8_t> reduced(const std::vector<Colour>& image, int width, int height) {
  std::vector<std::uint8_t> rgb(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (std::size_t k = 0; k < 3; ++k) {
        double sum = 0;
        for (int j = 0; j < oversampling; ++j)
          for (int i = 0; i < oversampling; ++i)
            sum += std::clamp(image[static_cast<std::size_t>((y * oversampling + j) * width * oversampling +
                                                             x * oversampling + i)][k],
                              0.0, 1.0);
        rgb[static_cast<std::size_t>(y * width + x) * 3 + k] =
            static_cast<std::uint8_t>(std::lround(255 * sum / (oversampling * oversampling)));
      }
  return rgb;
}

int run(int argc, char** argv) {
  std::vector<std::string> files;
  std::map<std::string, std::string> value = {{"size", "1600x1000"}, {"tows", "8"}};
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word.rfind("--", 0) == 0 && i + 1 < argc)
      value[word.substr(2)] = argv[++i];
    else
      files.push_back(word);
  }
  if (files.size() != 3 || !value.count("band")) {
    std::fputs(
        "usage: render_paths part.step paths.csv out.png --band MM [--tows N] [--faces LIST] [--unit m]\n"
        "  [--ply NAME] [--view x,y,z] [--up x,y,z] [--size 1600x1000] [--plies plies.csv]\n",
        stderr);
    return 2;
  }
  const auto all = oracle::read_step_faces(files[0], value["unit"]);
  std::vector<TopoDS_Face> faces;
  for (const oracle::StepFace& f : oracle::choose_faces(all, value["faces"])) faces.push_back(f.face);
  const Skin skin(faces);
  std::vector<oracle::PlyPaths> plies = oracle::read_paths(files[1]);
  if (plies.empty()) throw std::runtime_error(files[1] + ": no paths");
  oracle::PlyPaths* ply = &plies.front();
  for (oracle::PlyPaths& p : plies)
    if (p.name == value["ply"]) ply = &p;
  oracle::check_on_surface(skin, *ply);

  const Mesh mesh = mesh_of(faces, skin);
  int width = 0, height = 0;
  if (std::sscanf(value["size"].c_str(), "%dx%d", &width, &height) != 2)
    throw std::runtime_error("--size WxH");
  Camera camera;
  Painter painter(skin, mesh, camera, *ply, std::stod(value["band"]), std::stoi(value["tows"]));
  Vec up;
  Vec view = default_view(mesh, painter.sense, up);
  if (value.count("view")) view = vector_of(value["view"]);
  if (value.count("up")) up = vector_of(value["up"]);
  camera = look(mesh, view, up, width * oversampling, height * oversampling);

  const std::vector<Fragment> image = rasterise(mesh, camera);
  std::vector<Colour> colours = painter.paint(image);
  outline(faces, skin, camera, image, colours);
  if (value.count("plies")) draw_plies(value["plies"], ply->name, skin, camera, image, colours, painter.band);
  picture::write_png(files[2], width, height, reduced(colours, width, height));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const Standard_Failure& failure) {
    std::fprintf(stderr, "render_paths: %s\n", failure.GetMessageString());
  } catch (const std::exception& failure) {
    std::fprintf(stderr, "render_paths: %s\n", failure.what());
  }
  return 1;
}
