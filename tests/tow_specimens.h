#pragma once

#include <cmath>
#include <memory>

#include "boundary/lay_tows.h"
#include "tests/specimens.h"

namespace afptraj {

/// A circle of the (u, v) plane as four rational arcs; clockwise it is a hole.
inline Loop circle_loop(const Uv& centre, double radius, bool clockwise, int edge) {
  BSplineCurve2 c;
  c.degree = 2;
  c.knots = {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4};
  const double root = std::sqrt(0.5);
  for (int i = 0; i <= 8; ++i) {
    const double a = (clockwise ? -1 : 1) * i * pi / 4, r = i % 2 == 0 ? radius : radius / root;
    c.poles.push_back(centre + r * Uv(std::cos(a), std::sin(a)));
    c.weights.push_back(i % 2 == 0 ? 1 : root);
  }
  return {{{c, false, edge}}};
}

/// A closed polygon of the (u, v) plane.
inline Loop polygon_loop(const std::vector<Uv>& corners, int edge) {
  BSplineCurve2 c;
  c.degree = 1;
  for (std::size_t i = 0; i <= corners.size(); ++i) {
    c.poles.push_back(corners[i % corners.size()]);
    c.knots.push_back(static_cast<double>(i));
  }
  c.knots.insert(c.knots.begin(), 0);
  c.knots.push_back(static_cast<double>(corners.size()));
  return {{{c, false, edge}}};
}

/// The rectangle [0, width] x [0, height] of the plane z = 0 with further loops.
inline Skin plate(double width, double height, const std::vector<Loop>& holes = {}) {
  Part part = make_rectangular_part(Surface::plane({}), {0, width}, {0, height});
  for (Loop loop : holes) {
    for (Coedge& coedge : loop.coedges) coedge.edge = static_cast<int>(part.edges.size());
    part.faces[0].loops.push_back(loop);
    part.edges.push_back({});
  }
  return Skin(std::make_shared<const Part>(part), {0});
}

/// A straight line of (u, v) from a to b with speed `speed` (length in space by length in (u, v)): a centre line.
inline SurfaceCurve straight_uv(const Uv& a, const Uv& b, double length_mm, double step_mm = 4) {
  SurfaceCurve curve;
  curve.pieces.emplace_back();
  const int spans = std::max(2, static_cast<int>(length_mm / step_mm));
  for (int i = 0; i <= spans; ++i) {
    CurveNode node;
    node.t = length_mm * i / spans;
    node.at = {0, a + (b - a) * (static_cast<double>(i) / spans)};
    node.duv = (b - a) / length_mm;
    curve.pieces[0].push_back(node);
  }
  return curve;
}

inline LevelCurve straight_course(int number, const Uv& a, const Uv& b) {
  return {number, {straight_uv(a, b, (b - a).norm())}};
}

/// A circle of the plane, anticlockwise from angle a0 over `turn`, in cubics whose error is below 1e-9 mm.
inline SurfaceCurve arc_curve(const Uv& centre, double radius, double a0, double turn, bool closed) {
  SurfaceCurve curve;
  curve.closed = closed;
  curve.pieces.emplace_back();
  const int spans = static_cast<int>(turn * 200);  // error r (turn / spans)^4 / 384
  for (int i = 0; i <= spans; ++i) {
    CurveNode node;
    const double a = a0 + turn * i / spans;
    node.t = radius * (a - a0);
    node.at = {0, centre + radius * Uv(std::cos(a), std::sin(a))};
    node.duv = Uv(-std::sin(a), std::cos(a));
    node.kg_per_mm = 1 / radius;
    curve.pieces[0].push_back(node);
  }
  return curve;
}

/// Lays whatever there is: no minimum gap or length.
inline CutRule bare_rule(double p) {
  CutRule rule;
  rule.coverage_rule = p;
  rule.min_cut_length_mm = 0;
  rule.min_gap_mm = 0;
  return rule;
}

inline LaidTows lay(const Skin& skin, const std::vector<LevelCurve>& levels, int tows, double width_mm,
                    const CutRule& rule) {
  TowLineOptions options;
  options.tow_width_mm = width_mm;
  options.tows = tows;
  options.coverage_rule = rule.coverage_rule;
  options.beyond_mm = rule.short_tows == ShortTows::drop ? 0 : rule.min_cut_length_mm;
  return lay_tows(skin, levels, options, rule);
}

/// The pieces of one tow.
inline std::vector<const TowPiece*> pieces_of(const LaidTows& tows, int course, int tow) {
  std::vector<const TowPiece*> out;
  for (const TowPiece& piece : tows.pieces)
    if (piece.course == course && piece.tow == tow) out.push_back(&piece);
  return out;
}

}  // namespace afptraj
