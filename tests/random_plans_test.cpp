// Plans on parts drawn at random, judged: what holds on the samples must hold on parts nobody has seen.
//
// AFPTRAJ_RANDOM_PLANS=first:count plans that many, from that seed on, instead of the quick subset. A seed's
// thousands tell the kind of part: 0 smooth ones, 1 rough panels, 2 with holes, 3 closed ones, 4 of two
// faces.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <sstream>
#include <string>

#include "analysis/judge_ply.h"
#include "boundary/plan_ply.h"
#include "tests/specimens.h"

namespace afptraj {
namespace {

class Draw {
 public:
  explicit Draw(unsigned seed) : engine_(seed) {}
  // Not std::uniform_real_distribution, whose numbers differ between libraries.
  double number(double lo, double hi) {
    return lo + (hi - lo) * static_cast<double>(engine_()) / 4294967295.0;
  }
  int whole(int lo, int hi) { return lo + static_cast<int>(engine_() % static_cast<unsigned>(hi - lo + 1)); }

 private:
  std::mt19937 engine_;
};

struct Drawn {
  std::string name;
  Skin skin;
};

/// Sums of a few waves, as high as a share of their length.
Surface drawn_waves(Draw& draw, double lowest, double highest) {
  const double width = draw.number(400, 1600), depth = width * draw.number(0.3, 1);
  const int waves = draw.whole(1, 4), nu = draw.whole(6, 24), nv = draw.whole(6, 24);
  std::vector<std::array<double, 4>> wave;
  for (int i = 0; i < waves; ++i) {
    const double length = draw.number(0.4, 2) * width, way = draw.number(0, pi);
    const double height = draw.number(lowest, highest) * length;
    wave.push_back(
        {height, 2 * pi / length * std::cos(way), 2 * pi / length * std::sin(way), draw.number(0, 2 * pi)});
  }
  return height_field(width, depth, nu, nv, [&](double x, double y) {
    double sum = 0;
    for (const auto& w : wave) sum += w[0] * std::sin(w[1] * x + w[2] * y + w[3]);
    return sum;
  });
}

Drawn drawn_panel(Draw& draw, double lowest = 0.005, double highest = 0.04) {
  const Surface surface = drawn_waves(draw, lowest, highest);
  const Interval u{draw.number(0, 0.1), draw.number(0.9, 1)}, v{draw.number(0, 0.1), draw.number(0.9, 1)};
  return {"panel", make_skin(surface, u, v)};
}

/// A closed curve in (u, v), clockwise: the material lies outside.
BSplineCurve2 hole_curve(const Uv& centre, const Uv& radii) {
  BSplineCurve2 c;  // periodic, of twelve poles
  c.degree = 3;
  constexpr int n = 12;
  for (int i = 0; i < n + 7; ++i) c.knots.push_back(i - 3);
  for (int i = 0; i < n + 3; ++i) {
    const double a = -2 * pi * i / n;
    c.poles.push_back(centre + radii.cwiseProduct(Uv(std::cos(a), std::sin(a))));
  }
  return c;
}

Drawn drawn_panel_with_holes(Draw& draw) {
  Part part = make_rectangular_part(drawn_waves(draw, 0.005, 0.04), {0.05, 0.95}, {0.05, 0.95});
  const int holes = draw.whole(1, 2);
  for (int i = 0; i < holes; ++i) {
    const Uv centre(draw.number(0.2, 0.35) + 0.42 * i, draw.number(0.25, 0.75));
    const int edge = static_cast<int>(part.edges.size());
    const Uv radii(draw.number(0.02, 0.13), draw.number(0.02, 0.18));
    part.edges.push_back({});
    part.faces[0].loops.push_back({{{hole_curve(centre, radii), false, edge}}});
  }
  return {"holes", Skin(std::make_shared<const Part>(part), {0})};
}

/// Closed round an axis, some with a pole.
Drawn drawn_closed(Draw& draw) {
  const double r = draw.number(150, 500), z = draw.number(300, 1500);
  switch (draw.whole(0, 2)) {
    case 0:
      return {"tube", make_skin(Surface::cylinder({}, r), {0, 2 * pi}, {0, z})};
    case 1: {
      const double angle = draw.number(0.05, 0.6);
      return {"frustum",
              make_skin(Surface::cone({}, r, angle), {0, 2 * pi}, {-0.4 * r / std::sin(angle), z})};
    }
    default:
      return {"dome", make_skin(Surface::sphere({}, 2 * r), {0, 2 * pi}, {draw.number(-0.2, 0.8), pi / 2})};
  }
}

/// One surface cut in two faces.
Drawn drawn_two_faces(Draw& draw) {
  const Surface surface = drawn_waves(draw, 0.005, 0.04);
  const double cut = draw.number(0.3, 0.7);
  Part part = make_rectangular_part(surface, {0, cut}, {0, 1});
  RectangularFace second =
      make_rectangular_face(surface, {cut, 1}, {0, 1}, static_cast<int>(part.edges.size()));
  part.edges.insert(part.edges.end(), second.edges.begin(), second.edges.end());
  const int right = 1, left = 3;  // sides in the order of the loop
  second.face.loops[0].coedges[left].edge = part.faces[0].loops[0].coedges[right].edge;
  part.faces.push_back(std::move(second.face));
  return {"two faces", Skin(std::make_shared<const Part>(part), {0, 1})};
}

Drawn drawn_sphere(Draw& draw) {
  const double radius = draw.number(300, 1500), u = draw.number(0.3, 1.2), v = draw.number(-0.9, 0);
  return {"sphere", make_skin(Surface::sphere({}, radius), {-u, u}, {v, v + draw.number(0.4, 1)})};
}

Drawn drawn_torus(Draw& draw) {
  const double major = draw.number(600, 1500), minor = draw.number(0.15, 0.6) * major;
  const double u = draw.number(0.2, 0.8), v = draw.number(-pi, pi);
  return {"torus", make_skin(Surface::torus({}, major, minor), {-u, u}, {v, v + draw.number(0.6, 2.4)})};
}

Drawn drawn_cone(Draw& draw) {
  const double radius = draw.number(150, 600), angle = draw.number(0.05, 0.7), u = draw.number(-3, 0);
  const double least = -0.8 * radius / std::sin(angle);
  const double v0 = std::max(least, -draw.number(0, 500));
  return {"cone", make_skin(Surface::cone({}, radius, angle), {u, u + draw.number(1, 4)},
                            {v0, v0 + draw.number(400, 1500)})};
}

Drawn drawn_cylinder(Draw& draw) {
  const double u = draw.number(-3, 0);
  return {"cylinder", make_skin(Surface::cylinder({}, draw.number(150, 600)), {u, u + draw.number(1, 5)},
                                {0, draw.number(300, 1500)})};
}

Drawn drawn_part(unsigned seed, Draw& draw) {
  switch (seed / 1000) {
    case 1:
      return drawn_panel(draw, 0.03, 0.08);
    case 2:
      return drawn_panel_with_holes(draw);
    case 3:
      return drawn_closed(draw);
    case 4:
      return drawn_two_faces(draw);
    default:
      break;
  }
  switch (seed % 8) {
    case 0:
      return drawn_sphere(draw);
    case 1:
      return drawn_torus(draw);
    case 2:
      return drawn_cone(draw);
    case 3:
      return drawn_cylinder(draw);
    default:
      return drawn_panel(draw);
  }
}

/// Points all over the face, with directions that swing by a few degrees about one angle to u.
PlyOrientation drawn_ply(const Skin& skin, Draw& draw) {
  PlyOrientation ply{"P", {}, 0};
  const Uv lo = skin.trim(0).box_min(), hi = skin.trim(0).box_max();
  const double angle = draw.number(0, pi), swing = draw.number(0, 4) * pi / 180;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 4; ++j) {
      const SurfacePoint at{0, lo + (hi - lo).cwiseProduct(Uv(0.05 + 0.9 * i / 5, 0.05 + 0.9 * j / 3))};
      if (!skin.trim(0).contains(at.uv)) continue;  // in a hole
      const SurfaceDerivatives d = skin.derivatives(at);
      const double a = angle + swing * std::sin(1.1 * i + 0.7 * j);
      const Vec3 e1 = d.Su.normalized(), e2 = skin.normal(at).cross(e1);
      ply.points.push_back({d.S, std::cos(a) * e1 + std::sin(a) * e2, 0});
    }
  ply.start = static_cast<std::size_t>(draw.whole(0, 23)) % ply.points.size();
  return ply;
}

std::string describe(const Drawn& drawn, const Ply& ply) {
  const PlyReport& r = ply.report;
  std::ostringstream out;
  out << drawn.name << ", W " << r.band_width_mm << ", " << ply.courses.size() << " courses, E "
      << r.spacing_error_mm << " at (" << r.spacing.where.transpose() << ") on course "
      << r.spacing.worst_course << ", covered " << r.covered_share << ", reached " << r.reached_share;
  for (const LooseEnd& end : r.loose_ends)
    out << "\n  loose end of course " << end.course << " at (" << end.where.transpose() << ")";
  return out.str();
}

class RandomPlans : public testing::TestWithParam<unsigned> {};

TEST_P(RandomPlans, HoldTheirLaws) {
  Draw draw(GetParam());
  const Drawn drawn = drawn_part(GetParam(), draw);
  PlanOptions options;
  options.tows = draw.whole(4, 16);
  options.range_mm = drawn.skin.diagonal() / 3;
  options.sample_mm = std::min(4.0, options.band_width_mm() / 12);
  Ply ply = plan_ply(drawn.skin, drawn_ply(drawn.skin, draw), options);
  JudgeOptions judge;
  judge.band_width_mm = options.band_width_mm();
  judge_ply(drawn.skin, judge, ply);
  const PlyReport& r = ply.report;
  double named = 0;
  for (const UncoveredSpot& spot : r.uncovered) {
    named += spot.area_mm2;
    EXPECT_FALSE(spot.reason.empty());
  }
  SCOPED_TRACE(describe(drawn, ply));
  EXPECT_LT(r.spacing_error_mm, 1e-3);
  EXPECT_EQ(r.spacing.unresolved, 0u);
  EXPECT_TRUE(r.crossings.empty());
  EXPECT_TRUE(r.loose_ends.empty());
  EXPECT_GE(r.covered_share + named / r.skin_area_mm2, 0.999);
}

/// The quick subset: of each kind a few, and those that showed a fault once. Sanitizers, ten times slower,
/// see the first only: the same code with other numbers.
std::vector<unsigned> seeds() {
  if (const char* text = std::getenv("AFPTRAJ_RANDOM_PLANS")) {
    unsigned first = 1, count = 16;
    std::sscanf(text, "%u:%u", &first, &count);
    std::vector<unsigned> out(count);
    std::iota(out.begin(), out.end(), first);
    return out;
  }
  return {
      0,    1,    2,    3,   4,  // sphere, torus, cone, cylinder, panel
      1001, 1004, 1008,          // panels where fronts fold
      2000, 2003, 2007,          // with holes
      3000, 3003, 3007,          // closed
      4000, 4003, 4007,          // of two faces
#ifndef __SANITIZE_ADDRESS__
      19,   122,  130,  234, 243, 258, 290, 307, 330, 362,  // a path beyond the one rim came upon the other
      45,               // rays ended or not by the rounding of whole bands
      183,              // an extension without the end it started from
      82,               // the end of the faired path had a kink
      1013,             // slivers where three fronts meet nearly in one point
      26,   43,   306,  // the judge at focal points
#endif
  };
}
INSTANTIATE_TEST_SUITE_P(Seeds, RandomPlans, testing::ValuesIn(seeds()));

}  // namespace
}  // namespace afptraj
