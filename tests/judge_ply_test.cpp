#include "analysis/judge_ply.h"

#include <cmath>
#include <functional>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "boundary/clip.h"
#include "geometry/curvature.h"
#include "tests/specimens.h"

// Plies written down by hand, whose faults are known in closed form.
namespace afptraj {
namespace {

constexpr double W = 50.8;

JudgeOptions options() {
  JudgeOptions o;
  o.band_width_mm = W;
  return o;
}

Skin plate(double width, double depth) {
  return make_skin(Surface::plane({}), {-width / 2, width / 2}, {-depth / 2, depth / 2});
}

/// A segment through (u, v)(a ... b), with derivatives by differences of sixth order.
CourseSegment segment(const Skin& skin, const std::function<Uv(double)>& uv, double a, double b, int count = 250,
                      bool closed = false) {
  CourseSegment out;
  out.closed = closed;
  const double h = 1e-3 * (b - a);
  double s = 0;
  for (int i = 0; i <= count; ++i) {
    const double x = a + (b - a) * i / count;
    const auto position = [&](double y) { return skin.point({0, uv(y)}); };
    const auto velocity = [&](double y) {
      return Vec3((45 * (position(y + h) - position(y - h)) - 9 * (position(y + 2 * h) - position(y - 2 * h)) +
                   (position(y + 3 * h) - position(y - 3 * h))) /
                  (60 * h));
    };
    CourseSample sample;
    sample.at = {0, uv(x)};
    sample.position = position(x);
    sample.normal = skin.normal(sample.at);
    sample.tangent = velocity(x).normalized();
    const Vec3 turn = (velocity(x + h).normalized() - velocity(x - h).normalized()) / (2 * h) / velocity(x).norm();
    sample.kg_per_mm = turn.dot(sample.normal.cross(sample.tangent));
    if (i > 0) {
      const double before = x - (b - a) / count, middle = 0.5 * (before + x);
      s += (velocity(before).norm() + 4 * velocity(middle).norm() + velocity(x).norm()) * (x - before) / 6;  // Simpson
    }
    sample.s_mm = s;
    out.samples.push_back(sample);
  }
  return out;
}

CourseSegment line(const Skin& skin, const Uv& a, const Uv& b, int count = 250) {
  return segment(skin, [&](double x) { return Uv(a + x * (b - a)); }, 0, 1, count);
}

/// Straight courses -n ... n across a plate, `height(k)` above its middle.
Ply rows(const Skin& skin, double width, int n, const std::function<double(int)>& height) {
  Ply ply;
  for (int k = -n; k <= n; ++k)
    ply.courses.push_back({k, {line(skin, Uv(-width / 2, height(k)), Uv(width / 2, height(k)))}});
  return ply;
}

TEST(JudgePly, FindsNothingWhereNothingIsWrong) {
  const Skin skin = plate(1000, 11 * W);
  Ply ply = rows(skin, 1000, 5, [](int k) { return k * W; });
  judge_ply(skin, options(), ply);
  const PlyReport& r = ply.report;
  EXPECT_LT(r.spacing_error_mm, 1e-9);
  EXPECT_GE(r.spacing.measured, 10u * 250u);
  EXPECT_EQ(r.spacing.beyond_end + r.spacing.unresolved + r.spacing.off_skin, 0u);
  EXPECT_TRUE(r.crossings.empty());
  EXPECT_TRUE(r.loose_ends.empty());
  EXPECT_DOUBLE_EQ(r.covered_share, 1);
  EXPECT_TRUE(r.violations.empty());
  EXPECT_TRUE(r.warnings.empty());
}

// A bump of 0.01 mm over 40 mm in one course, between the probes of any coarse spread: its own distance
// is W + 0.01 there, and that of the course beyond it W - 0.01.
TEST(JudgePly, FindsASmallBumpBetweenCoarseProbes) {
  const Skin skin = plate(1000, 11 * W);
  Ply ply = rows(skin, 1000, 5, [](int k) { return k * W; });
  for (CourseSegment& s : ply.courses[8].segments)  // course 3
    s = segment(skin, [](double x) { return Uv(x, 3 * W + 0.01 * std::exp(-(x - 111) * (x - 111) / 1600)); }, -500, 500);
  for (const int budget : {20, 4000}) {
    JudgeOptions o = options();
    o.spacing_samples = budget;
    const SpacingError e = measure_spacing(skin, ply, o);
    EXPECT_NEAR(e.worst_mm, 0.01, 1e-6) << budget;
    EXPECT_NEAR(e.where.x(), 111, 1) << budget;
    EXPECT_TRUE(e.worst_course == 3 || e.worst_course == 4);
    EXPECT_EQ(e.unresolved, 0u);
  }
}

// No distance is too wrong to be one: the neighbour far too near, or far too far away.
TEST(JudgePly, GreatErrorsAreErrors) {
  const Skin skin = plate(1000, 11 * W);
  for (const double factor : {0.2, 0.7, 1.04, 1.3, 1.9}) {
    const Ply ply = rows(skin, 1000, 1, [&](int k) { return k == 1 ? factor * W : k * W; });
    const SpacingError e = measure_spacing(skin, ply, options());
    EXPECT_NEAR(e.worst_mm, std::abs(factor - 1) * W, 1e-8) << factor;
    EXPECT_EQ(e.worst_course, 1);
  }
}

/// A course over a plate of 600 x 600 along v = u + c, raised by `bow` in the middle.
CourseSegment oblique(const Skin& skin, double c, double bow = 0) {
  const double lo = std::max(-300.0, -300 - c), hi = std::min(300.0, 300 - c);
  return segment(skin, [&](double x) {
    const double u = lo + x * (hi - lo);
    return Uv(u, u + c + bow * 4 * x * (1 - x));
  }, 0, 1);
}

// Near a corner of the plate the neighbour is the shorter one: of the course beside it, a band's width at
// both ends has its foot past the neighbour's ends, also where another segment is farther away.
TEST(JudgePly, AFootPastAnEndOnTheBoundaryIsNoError) {
  const Skin skin = plate(600, 600);
  const double step = W * std::sqrt(2.0), c = 450;
  Ply ply;
  ply.courses.push_back({0, {oblique(skin, c)}});
  // The bow puts the twenty worst chords, which are looked at closer, in the middle, and not where rounding does.
  ply.courses.push_back({1, {oblique(skin, c - step, 5e-9)}});
  const double length = ply.courses[1].length_mm();
  for (const bool another : {false, true}) {
    if (another) ply.courses[0].segments.push_back(oblique(skin, c - 2.5 * step));
    const SpacingError e = measure_spacing(skin, ply, options());
    EXPECT_LT(e.worst_mm, 1e-8);
    EXPECT_NEAR(static_cast<double>(e.beyond_end), 250 * 2 * W / length, 2);
    EXPECT_EQ(e.beyond_end + e.measured, 250u + 80u);  // every chord, and four places on the worst twenty
  }
}

// Where the neighbour ends inside instead, its end is its nearest point, and that is too far away.
TEST(JudgePly, AFootPastAnEndInsideIsAnError) {
  const Skin skin = plate(1000, 11 * W);
  Ply ply = rows(skin, 1000, 1, [](int k) { return k * W; });
  ply.courses[1].segments = {line(skin, Uv(-500, 0), Uv(480, 0))};
  const SpacingError e = measure_spacing(skin, ply, options());
  const double last = 500 - 0.1 * 4 - 480;  // along, to the outermost probe of the last chord
  EXPECT_NEAR(e.worst_mm, std::sqrt(last * last + W * W) - W, 1e-6);
  EXPECT_EQ(e.beyond_end, 0u);
}

// A reference with a corner (two segments that meet): on the concave side the next course has a corner
// too, on the convex side an arc of radius W about it, whose points are W from the corner itself.
TEST(JudgePly, CornersWhereFrontsMeetKeepTheLaw) {
  const Skin skin = plate(1200, 800);
  const double slope = 0.5, secant = std::sqrt(1 + slope * slope), sine = slope / secant, cosine = 1 / secant;
  const auto legs = [&](double lift) {
    const Uv corner(0, lift);
    return std::vector<CourseSegment>{line(skin, Uv(-600, 600 * slope + lift), corner),
                                      line(skin, corner, Uv(600, 600 * slope + lift))};
  };
  Ply ply;
  const double drop = -W * secant;
  const double a = std::atan(slope);
  ply.courses.push_back(
      {-1,
       {line(skin, Uv(-600, 600 * slope + drop), Uv(-W * sine, -W * cosine)),
        segment(skin, [&](double x) { return Uv(W * std::sin(x), -W * std::cos(x)); }, -a, a, 20),
        line(skin, Uv(W * sine, -W * cosine), Uv(600, 600 * slope + drop))}});
  ply.courses.push_back({0, legs(0)});
  ply.courses.push_back({1, legs(W * secant)});
  judge_ply(skin, options(), ply);
  const PlyReport& r = ply.report;
  EXPECT_LT(r.spacing_error_mm, 1e-5);
  EXPECT_GT(r.spacing.beyond_end, 0u);  // of course 1 at both sides of the plate
  EXPECT_LT(r.spacing.beyond_end, 60u);
  EXPECT_EQ(r.spacing.unresolved, 0u);
  EXPECT_TRUE(r.loose_ends.empty());
  EXPECT_TRUE(r.crossings.empty());
  // The arc moved by 0.1 mm is out by as much.
  for (CourseSample& sample : ply.courses[0].segments[1].samples) {
    sample.at.uv.y() -= 0.1;
    sample.position.y() -= 0.1;
  }
  EXPECT_NEAR(measure_spacing(skin, ply, options()).worst_mm, 0.1, 1e-4);
}

TEST(JudgePly, CoursesThatCrossAreFound) {
  const Skin skin = plate(1000, 11 * W);
  Ply ply = rows(skin, 1000, 1, [](int k) { return k * W; });
  ply.courses[2].segments = {line(skin, Uv(-500, 30), Uv(500, -90))};  // meets y = 0 at x = -250, y = -W at 173.3
  judge_ply(skin, options(), ply);
  const PlyReport& r = ply.report;
  ASSERT_EQ(r.crossings.size(), 2u);
  EXPECT_EQ(r.crossings[0].course + r.crossings[1].course + r.crossings[0].other + r.crossings[1].other, 1);
  const bool first_is_reference = r.crossings[0].course == 0 || r.crossings[0].other == 0;
  EXPECT_NEAR(r.crossings[first_is_reference ? 0 : 1].where.x(), -250, 1e-6);
  EXPECT_NEAR(r.crossings[first_is_reference ? 1 : 0].where.x(), -500 + 1000 * (30 + W) / 120, 1e-6);
  ASSERT_EQ(r.violations.size(), 1u);
  EXPECT_NE(r.violations[0].find("cross at 2 places"), std::string::npos) << r.violations[0];
}

TEST(JudgePly, ACourseThatCrossesItselfIsFound) {
  const Skin skin = plate(1000, 11 * W);
  Ply ply = rows(skin, 1000, 1, [](int k) { return k * W; });
  // x = t - 2 a sin(t / a) doubles back: a loop about x = 0, once over.
  const auto loop = [](double x) { return Uv(x - 120 * std::sin(x / 40), W - 20 + 20 * std::cos(x / 40)); };
  ply.courses[2].segments = {segment(skin, loop, -40 * pi, 40 * pi, 400)};
  const auto found = find_crossings(skin, ply, options());
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].course, 1);
  EXPECT_EQ(found[0].other, 1);
  EXPECT_NEAR(found[0].where.x(), 0, 0.1);
}

TEST(JudgePly, AnEndInsideTheSkinIsFound) {
  const Skin skin = plate(1000, 11 * W);
  Ply ply = rows(skin, 1000, 1, [](int k) { return k * W; });
  ply.courses[2].segments = {line(skin, Uv(-500, W), Uv(123, W))};
  judge_ply(skin, options(), ply);
  ASSERT_EQ(ply.report.loose_ends.size(), 1u);
  EXPECT_EQ(ply.report.loose_ends[0].course, 1);
  EXPECT_LT((ply.report.loose_ends[0].where - Vec3(123, W, 0)).norm(), 1e-9);
  ASSERT_EQ(ply.report.violations.size(), 1u);
  // Another segment that goes on there makes it a meeting; one 0.01 mm off does not.
  for (const double gap : {0.0, 0.01}) {
    Ply both = ply;
    both.courses[2].segments.push_back(line(skin, Uv(123 + gap, W), Uv(500, W)));
    EXPECT_EQ(find_loose_ends(skin, both, options()).size(), gap > 0 ? 2u : 0u);
  }
}

// A spiral reference ends beside its own last turn, inside the skin; one that turns wider than W ends loose.
TEST(JudgePly, ASpiralMayEndBesideItself) {
  const Skin skin = plate(2000, 40 * W);
  for (const double pitch : {0.9 * W, 1.1 * W}) {
    Ply ply = rows(skin, 1000, 0, [](int) { return 0.0; });
    const auto spiral = [&](double a) { return Uv((2 * W + pitch * a / (2 * pi)) * Uv(std::cos(a), std::sin(a))); };
    ply.courses[0].segments = {segment(skin, spiral, 0, 4 * pi, 400)};
    EXPECT_EQ(find_loose_ends(skin, ply, options()).size(), pitch < W ? 0u : 2u) << pitch;
  }
}

// Hoops W apart on a cylinder of ten bands: all of it is covered.
TEST(JudgePly, ACylinderFullyCovered) {
  const Skin skin = make_skin(Surface::cylinder({}, 350), {0, 2 * pi}, {0, 10 * W});
  Ply ply;
  for (int k = -4; k <= 5; ++k) {
    const double v = (k + 4.5) * W;
    ply.courses.push_back({k, {segment(skin, [&](double u) { return Uv(u, v); }, 0, 2 * pi, 400, true)}});
  }
  judge_ply(skin, options(), ply);
  const PlyReport& r = ply.report;
  EXPECT_DOUBLE_EQ(r.covered_share, 1);
  EXPECT_TRUE(r.uncovered.empty());
  EXPECT_LT(r.spacing_error_mm, 1e-8);
  EXPECT_EQ(r.spacing.beyond_end + r.spacing.unresolved, 0u);
  EXPECT_TRUE(r.crossings.empty());
  EXPECT_TRUE(r.loose_ends.empty());
}

// Eleven bands, one missing: ten elevenths are covered, the rest is one strip up to W away.
TEST(JudgePly, AMissingCourseIsAStripOfOneBand) {
  const Skin skin = plate(1000, 11 * W);
  Ply ply = rows(skin, 1000, 5, [](int k) { return k * W; });
  std::erase_if(ply.courses, [](const Course& c) { return c.number == 2; });
  JudgeOptions o = options();
  o.area_samples = 40000;
  const Coverage c = measure_coverage(skin, ply, o);
  EXPECT_NEAR(c.covered_share, 10.0 / 11, 0.005);
  EXPECT_DOUBLE_EQ(c.reached_share, c.covered_share);
  ASSERT_EQ(c.uncovered.size(), 1u);
  EXPECT_NEAR(c.uncovered[0].area_mm2, (1 - c.covered_share) * 11 * W * 1000, 1e-6 * 11 * W * 1000);
  EXPECT_NEAR(c.uncovered[0].distance_mm, W, 0.05 * W);
  EXPECT_NEAR(c.uncovered[0].where.y(), 2 * W, 0.05 * W);
}

TEST(JudgePly, IsTheSameForAnyNumberOfThreads) {
  const Skin skin = make_bumpy_skin();
  Ply ply;  // straight in (u, v): wrong in many places
  for (int k = -4; k <= 4; ++k)
    ply.courses.push_back({k, {line(skin, Uv(0, 0.5 + 0.085 * k), Uv(1, 0.5 + 0.085 * k))}});
  JudgeOptions o = options();
  o.spacing_samples = 300;
  Ply results[2] = {ply, ply};
  for (int i = 0; i < 2; ++i) {
    const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, i == 0 ? 1 : 4);
    judge_ply(skin, o, results[i]);
  }
  const PlyReport &a = results[0].report, &b = results[1].report;
  EXPECT_GT(a.spacing_error_mm, 0.1);
  EXPECT_EQ(a.spacing_error_mm, b.spacing_error_mm);
  EXPECT_EQ(a.spacing.where, b.spacing.where);
  EXPECT_EQ(a.spacing.measured, b.spacing.measured);
  EXPECT_EQ(a.covered_share, b.covered_share);
  EXPECT_EQ(a.crossings.size(), b.crossings.size());
}

}  // namespace
}  // namespace afptraj
