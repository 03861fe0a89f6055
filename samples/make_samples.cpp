// Writes the sample parts and their ply points: make_samples <directory>. Same bytes every time.
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_PrinterOStream.hxx>
#include <Standard_Failure.hxx>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "sample_files.h"
#include "sample_surfaces.h"

namespace {

using samples::Obround;
using samples::PlyRow;

constexpr double pi = 3.14159265358979323846;
constexpr double degree = pi / 180;

// A place on the surface with its unit normal S_u x S_v, which is outside on every sample.
struct Place {
  gp_Pnt point;
  gp_Vec normal;
};

Place place_at(const Handle(Geom_Surface)& surface, double u, double v) {
  gp_Vec du, dv;
  Place place;
  surface->D1(u, v, place.point, du, dv);
  place.normal = du.Crossed(dv).Normalized();
  return place;
}

// The direction `axis` laid into the tangent plane and turned by `angle` about the normal.
gp_Vec laid(const Place& place, const gp_Vec& axis, double angle) {
  const gp_Vec zero = (axis - axis.Dot(place.normal) * place.normal).Normalized();
  return std::cos(angle) * zero + std::sin(angle) * place.normal.Crossed(zero);
}

// The asked angle at a point, in degrees, and what it is measured from.
struct Field {
  std::string ply;
  gp_Vec axis;
  std::function<double(const gp_Pnt&)> angle_deg;
};

struct Spot {
  double u, v;
  bool start;
};

std::vector<PlyRow> plies_of(const Handle(Geom_Surface)& surface, const std::vector<Spot>& spots,
                             const std::vector<Field>& fields) {
  std::vector<PlyRow> rows;
  for (const Field& field : fields) {
    for (const Spot& spot : spots) {
      const Place place = place_at(surface, spot.u, spot.v);
      rows.push_back({field.ply, place.point, laid(place, field.axis, field.angle_deg(place.point) * degree),
                      spot.start});
    }
  }
  return rows;
}

// count_u x count_v places, each a little off its grid point by a fixed pattern, as measured or
// hand-set points are; `start` is the nearest to the middle.
std::vector<Spot> scattered(double u0, double u1, double v0, double v1, int count_u, int count_v) {
  std::vector<Spot> spots;
  for (int i = 0; i < count_u; ++i) {
    for (int j = 0; j < count_v; ++j) {
      const double a = 0.3 * std::sin(12.9898 * i + 78.233 * j),
                   b = 0.3 * std::sin(39.346 * i + 11.135 * j + 1);
      spots.push_back({u0 + (u1 - u0) * (i + 0.5 + a) / count_u, v0 + (v1 - v0) * (j + 0.5 + b) / count_v,
                       i == count_u / 2 && j == count_v / 2});
    }
  }
  return spots;
}

// The spots outside of the holes.
std::vector<Spot> on_material(const std::vector<Spot>& spots, const std::vector<Obround>& holes) {
  std::vector<Spot> kept;
  for (const Spot& spot : spots) {
    bool inside = false;
    for (const Obround& hole : holes) {
      const double du = hole.u1 - hole.u0, dv = hole.v1 - hole.v0, length2 = du * du + dv * dv;
      double x = length2 > 0 ? ((spot.u - hole.u0) * du + (spot.v - hole.v0) * dv) / length2 : 0;
      x = std::clamp(x, 0.0, 1.0);
      inside = inside || std::hypot(spot.u - hole.u0 - x * du, spot.v - hole.v0 - x * dv) < hole.r + 5;
    }
    if (!inside) kept.push_back(spot);
  }
  return kept;
}

std::function<double(const gp_Pnt&)> constant(double angle_deg) {
  return [angle_deg](const gp_Pnt&) { return angle_deg; };
}

void panel(const std::filesystem::path& to) {
  const Handle(Geom_BSplineSurface) surface = samples::panel_surface();
  samples::write_part(to / "part.step", "panel", samples::whole_face(surface));
  const auto smooth = [](double base) {
    return [base](const gp_Pnt& p) {
      return base + 4 * std::sin(2 * pi * p.X() / 1000) * std::cos(pi * p.Y() / 600);
    };
  };
  samples::write_plies(to / "plies.csv", plies_of(surface, scattered(0, 1000, 0, 600, 8, 5),
                                                  {{"P1 +45", gp_Vec(1, 0, 0), smooth(45)},
                                                   {"P2 0", gp_Vec(1, 0, 0), smooth(0)},
                                                   {"P3 90", gp_Vec(1, 0, 0), smooth(90)}}));
}

void wing(const std::filesystem::path& to) {
  const Handle(Geom_BSplineSurface) surface = samples::wing_surface();
  samples::write_part(to / "part.step", "wing",
                      samples::split_and_sewn(surface, {0, 1, 2}, {0, 750, 1375, 2000}));
  // u is the square root of the chord: the spots stand closer round the leading edge, where the skin turns.
  std::vector<Spot> spots = scattered(0.04, 1.96, 40, 1960, 9, 9);
  for (Spot& spot : spots) spot.start = false;
  spots[7 * 9 + 4].start = true;  // above, half way along the span
  samples::write_plies(to / "plies.csv", plies_of(surface, spots,
                                                  {{"P1 0", gp_Vec(0.09, 1, 0), constant(0)},
                                                   {"P2 +45", gp_Vec(0.09, 1, 0), constant(45)}}));
}

void hole(const std::filesystem::path& to) {
  const Handle(Geom_BSplineSurface) surface = samples::hole_surface();
  const std::vector<Obround> holes = {{270, 260, 270, 260, 75}, {520, 210, 620, 290, 40}};
  samples::write_part(to / "part.step", "hole", samples::face_with_holes(surface, holes));
  samples::write_plies(
      to / "plies.csv",
      plies_of(surface, on_material(scattered(0, 800, 0, 500, 7, 5), holes),
               {{"P1 +45", gp_Vec(1, 0, 0), constant(45)}, {"P2 0", gp_Vec(1, 0, 0), constant(0)}}));
}

void dome(const std::filesystem::path& to) {
  const Handle(Geom_BSplineSurface) surface = samples::dome_surface();
  samples::write_part(to / "part.step", "dome", samples::whole_face(surface));
  samples::write_plies(to / "plies.csv", plies_of(surface, scattered(0, 4, 0.05, 0.95, 12, 5),
                                                  {{"P1 0", gp_Vec(1, 0.2, 0), constant(0)}}));
}

void vessel(const std::filesystem::path& to) {
  samples::write_part(to / "part.step", "vessel", samples::vessel_shell());
}

void duct(const std::filesystem::path& to) {
  const Handle(Geom_BSplineSurface) surface = samples::duct_surface();
  samples::write_part(to / "part.step", "duct", samples::whole_face(surface));
  samples::write_plies(to / "plies.csv", plies_of(surface, scattered(0, 16, 0, 1200, 10, 6),
                                                  {{"P1 +45", gp_Vec(1, 0, 0), constant(45)},
                                                   {"P2 0", gp_Vec(1, 0, 0), constant(0)}}));
}

void saddle(const std::filesystem::path& to) {
  const Handle(Geom_BSplineSurface) surface = samples::saddle_surface();
  samples::write_part(to / "part.step", "saddle", samples::whole_face(surface));
  samples::write_plies(to / "plies.csv", plies_of(surface, scattered(0, 700, 0, 700, 6, 6),
                                                  {{"P1 +45", gp_Vec(1, 0, 0), constant(45)},
                                                   {"P2 -30", gp_Vec(1, 0, 0), constant(-30)}}));
}

void make_all(const std::filesystem::path& directory) {
  const std::pair<const char*, void (*)(const std::filesystem::path&)> all[] = {
      {"panel", panel}, {"wing", wing},     {"hole", hole},    {"dome", dome},
      {"duct", duct},   {"saddle", saddle}, {"vessel", vessel}};
  for (const auto& [name, make] : all) {
    std::filesystem::create_directories(directory / name);
    make(directory / name);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: make_samples <directory>\n");
    return 2;
  }
  Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_PrinterOStream));
  try {
    make_all(argv[1]);
  } catch (const Standard_Failure& failure) {
    std::fprintf(stderr, "make_samples: %s\n", failure.GetMessageString());
    return 1;
  } catch (const std::exception& failure) {
    std::fprintf(stderr, "make_samples: %s\n", failure.what());
    return 1;
  }
  return 0;
}
