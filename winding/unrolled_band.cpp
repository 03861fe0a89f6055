#include "winding/unrolled_band.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "winding/frustum.h"

namespace afptraj {
namespace {

constexpr double longest_deg = 90;

struct Edges {
  UnrolledPoint left, right;
};

double departure(const UnrolledPoint& a, const UnrolledPoint& b, const UnrolledPoint& p, double round) {
  const double ex = b.along_mm - a.along_mm, ey = (b.turn_deg - a.turn_deg) * round;
  const double px = p.along_mm - a.along_mm, py = (p.turn_deg - a.turn_deg) * round;
  const double square = ex * ex + ey * ey;
  const double share = square > 0 ? std::clamp((px * ex + py * ey) / square, 0.0, 1.0) : 0;
  return std::hypot(px - share * ex, py - share * ey);
}

// Ramer, Douglas and Peucker's choice for both edges at once.
void thin(const std::vector<Edges>& all, std::size_t first, std::size_t last, double round,
          std::vector<Edges>& out) {
  std::size_t worst = first;
  double most = unrolled_tolerance_mm;
  for (std::size_t i = first + 1; i < last; ++i) {
    const double off = std::max(departure(all[first].left, all[last].left, all[i].left, round),
                                departure(all[first].right, all[last].right, all[i].right, round));
    if (off > most) most = off, worst = i;
  }
  if (worst == first) {
    out.push_back(all[last]);
    return;
  }
  thin(all, first, worst, round, out);
  thin(all, worst, last, round, out);
}

Edges between(const Edges& a, const Edges& b, double share) {
  const auto mix = [&](const UnrolledPoint& p, const UnrolledPoint& q) {
    return UnrolledPoint{p.along_mm + share * (q.along_mm - p.along_mm),
                         p.turn_deg + share * (q.turn_deg - p.turn_deg)};
  };
  return {mix(a.left, b.left), mix(a.right, b.right)};
}

// Cuts edges into strips.
void add_strips(const std::vector<Edges>& edges, bool back, std::vector<UnrolledStrip>& out) {
  const auto turned = [](const Edges& a, const Edges& b) {
    return std::max(std::abs(b.left.turn_deg - a.left.turn_deg),
                    std::abs(b.right.turn_deg - a.right.turn_deg));
  };
  UnrolledStrip strip;
  strip.back = back;
  const auto add = [&](const Edges& at) {
    strip.left.push_back(at.left);
    strip.right.push_back(at.right);
  };
  add(edges.front());
  for (std::size_t i = 1; i < edges.size(); ++i) {
    const double parts = std::max(1.0, std::ceil(turned(edges[i - 1], edges[i]) / longest_deg));
    for (double k = 1; k <= parts; ++k) {
      const Edges here = between(edges[i - 1], edges[i], k / parts),
                  start{strip.left.front(), strip.right.front()};
      if (turned(start, here) > longest_deg) {
        const Edges last{strip.left.back(), strip.right.back()};
        if (strip.left.size() > 1) out.push_back(strip);
        strip.left = {last.left};
        strip.right = {last.right};
      }
      add(here);
    }
  }
  if (strip.left.size() > 1) out.push_back(strip);
}

}  // namespace

UnrolledLayer unrolled_layer(const std::string& name, const Meridian& meridian, const WindTow& tow,
                             const std::vector<ContactPoint>& path) {
  UnrolledLayer layer{name, {}};
  const MeridianBand band(meridian, tow.width_mm, meridian.first(), meridian.last(), 1);
  const double round = radians(1) * meridian.at(meridian.widest()).r_mm;
  std::vector<Edges> run;
  bool back = false;
  const auto finish = [&] {
    if (run.size() > 1) {
      std::vector<Edges> kept{run.front()};
      thin(run, 0, run.size() - 1, round, kept);
      add_strips(kept, back, layer.strips);
    }
  };
  for (const ContactPoint& point : path) {
    const MeridianBand::Edge edge = band.edge_at(point);
    const Edges here{{edge.left.sigma_mm, edge.left.turn_deg}, {edge.right.sigma_mm, edge.right.turn_deg}};
    const bool returns = point.angle_rad > std::numbers::pi / 2;
    if (returns != back && !run.empty()) {
      run.push_back(here);  // no gap where it turns
      finish();
      run.clear();
    }
    back = returns;
    run.push_back(here);
  }
  finish();
  return layer;
}

UnrolledLayer unrolled_layer(const std::string& name, const WindMandrel& mandrel, const WindTow& tow,
                             const std::vector<LaidPiece>& pieces) {
  UnrolledLayer layer{name, {}};
  const double R = mandrel.diameter_mm / 2, end = mandrel.end_diameter_mm.value_or(mandrel.diameter_mm) / 2;
  const double slant = std::hypot(1, (end - R) / mandrel.length_mm), half = tow.width_mm / 2;
  for (const LaidPiece& piece : pieces) {
    const double r = R + (end - R) * (piece.z0_mm + piece.z1_mm) / 2 / mandrel.length_mm;
    const double ds = (piece.z1_mm - piece.z0_mm) * slant,
                 dt = radians(piece.angle1_deg - piece.angle0_deg) * r;
    const double length = std::hypot(ds, dt);
    if (!(length > 0)) continue;
    const double along = half * dt / length, turn = degrees(half * ds / length / r);
    const auto edges = [&](double z, double angle) {
      return Edges{{z * slant - along, angle + turn}, {z * slant + along, angle - turn}};
    };
    add_strips({edges(piece.z0_mm, piece.angle0_deg), edges(piece.z1_mm, piece.angle1_deg)}, ds < 0,
               layer.strips);
  }
  return layer;
}

}  // namespace afptraj
