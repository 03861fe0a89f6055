// paths.csv, paths.step and summary.json of hand-made plies.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "geometry/curvature.h"
#include "geometry/error.h"
#include "io/paths_csv.h"
#include "io/paths_step.h"
#include "io/plies_csv.h"
#include "io/summary_json.h"
#include "io/tows_csv.h"
#include "tests/temporary_directory.h"

namespace afptraj {
namespace {

Skin skin_of(const Surface& surface, const Interval& u, const Interval& v) {
  return Skin(std::make_shared<const Part>(make_rectangular_part(surface, u, v)), {0});
}

// The helix u = u0 + s cos(a) / R, v = v0 + s sin(a) on the cylinder of radius R about z.
CourseSegment helix(double radius, double angle, double length, double step) {
  CourseSegment segment;
  const int count = static_cast<int>(std::ceil(length / step));
  for (int i = 0; i <= count; ++i) {
    const double s = length * i / count, u = 0.3 + s * std::cos(angle) / radius, v = s * std::sin(angle);
    CourseSample sample;
    sample.s_mm = s;
    sample.at = {0, {u, v}};
    sample.normal = Vec3(std::cos(u), std::sin(u), 0);
    sample.position = radius * sample.normal + v * Vec3::UnitZ();
    sample.tangent = std::cos(angle) * Vec3(-std::sin(u), std::cos(u), 0) + std::sin(angle) * Vec3::UnitZ();
    sample.kn_per_mm = -std::cos(angle) * std::cos(angle) / radius;
    segment.samples.push_back(sample);
  }
  return segment;
}

Vec3 helix_point(double radius, double angle, double s) {
  const double u = 0.3 + s * std::cos(angle) / radius;
  return {radius * std::cos(u), radius * std::sin(u), s * std::sin(angle)};
}

Ply ply_of(const std::string& name, const CourseSegment& segment) {
  Ply ply;
  ply.name = name;
  ply.courses = {{-1, {segment}}, {0, {segment, segment}}, {1, {segment}}};
  return ply;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST(PathsCsv, HasOneRowPerSampleInOrder) {
  CourseSegment segment = helix(350, pi / 4, 10, 5);
  segment.samples[1].kg_per_mm = 2e-12;
  segment.samples[1].deviation_rad = pi / 180;
  const auto lines = lines_of(paths_csv({ply_of("A", segment), ply_of("=1+1", segment)}));
  ASSERT_EQ(lines.size(), 1u + 2 * 4 * 3);
  EXPECT_EQ(lines[0],
            "ply,course,segment,point,s_mm,x,y,z,nx,ny,nz,tx,ty,tz,kn_per_mm,kg_per_mm,deviation_deg");
  EXPECT_EQ(lines[1].rfind("A,-1,1,1,0,", 0), 0u) << lines[1];
  EXPECT_EQ(lines[2].rfind("A,-1,1,2,5,", 0), 0u) << lines[2];
  EXPECT_NE(lines[2].find(",0.000000000002,1"), std::string::npos)
      << lines[2];  // curvatures keep twelve decimals
  EXPECT_EQ(lines[4].rfind("A,0,1,1,", 0), 0u) << lines[4];
  EXPECT_EQ(lines[7].rfind("A,0,2,1,", 0), 0u) << lines[7];
  EXPECT_EQ(lines[13].rfind("\"=1+1\",-1,1,1,", 0), 0u) << lines[13];  // no formula for a spreadsheet
  for (const std::string& line : lines) EXPECT_EQ(std::count(line.begin(), line.end(), ','), 16) << line;
}

// Whatever the parts it comes in: more pieces than fit into one, and several plies.
TEST(TowsCsv, HasOneRowPerSampleInOrder) {
  std::vector<Ply> plies(2);
  plies[0].name = "A,B";
  plies[1].name = "C";
  TowSample sample;
  sample.position = Vec3(1, 2, 3.5);
  const int pieces = 70;
  for (Ply& ply : plies)
    for (int k = 0; k < pieces; ++k) {
      TowPiece piece;
      piece.course = -1;
      piece.tow = k + 1;
      piece.samples.assign(2000, sample);
      for (std::size_t i = 0; i < piece.samples.size(); ++i) piece.samples[i].s_mm = static_cast<double>(i);
      ply.tows.push_back(piece);
    }
  std::string text;
  std::size_t parts = 0;
  tows_csv(plies, [&](std::string_view part) {
    text += part;
    ++parts;
  });
  EXPECT_GT(parts, 2u);
  EXPECT_TRUE(text == tows_csv(plies));
  const auto lines = lines_of(text);
  ASSERT_EQ(lines.size(), 1u + 2 * pieces * 2000);
  EXPECT_EQ(lines[0], "ply,course,tow,segment,point,event,s_mm,x,y,z,nx,ny,nz,tx,ty,tz");
  EXPECT_EQ(lines[1], "\"A,B\",-1,1,1,1,add,0,1,2,3.5,0,0,1,1,0,0");
  EXPECT_EQ(lines[2], "\"A,B\",-1,1,1,2,,1,1,2,3.5,0,0,1,1,0,0");
  EXPECT_EQ(lines.back(), "C,-1,70,1,2000,cut,1999,1,2,3.5,0,0,1,1,0,0");
  EXPECT_EQ(lines[1 + 2000 * pieces], "C,-1,1,1,1,add,0,1,2,3.5,0,0,1,1,0,0");
  plies[1].tows[3].samples[7].position.x() = std::nan("");
  EXPECT_THROW(tows_csv(plies), Error);
}

TEST(PathsCsv, QuotesWhatNeedsIt) {
  EXPECT_EQ(csv_field("plain name"), "plain name");
  EXPECT_EQ(csv_field("a,b"), "\"a,b\"");
  EXPECT_EQ(csv_field("say \"hi\""), "\"say \"\"hi\"\"\"");
  EXPECT_EQ(csv_field("two\nlines"), "\"two\nlines\"");
  for (const char* risky : {"=cmd()", "+45", "-45", "@x", "#1", " blank"})
    EXPECT_EQ(csv_field(risky)[0], '"') << risky;
}

// A name that is written is read back as it was.
TEST(PathsCsv, NamesSurviveTheReader) {
  const test::TemporaryDirectory directory;
  for (const std::string name : {"+45", "=cmd()", "a,\"b\"\nc", "#7", "Lage 3 \xc3\xbc"}) {
    const std::string path =
        directory.write("plies.csv", "ply,x,y,z,dx,dy,dz\n" + csv_field(name) + ",1,2,3,1,0,0\n");
    EXPECT_EQ(read_plies(path).front().name, name);
  }
}

TEST(PathsCsv, NeverWritesNan) {
  CourseSegment segment = helix(350, 0, 10, 5);
  segment.samples[0].kg_per_mm = std::nan("");
  EXPECT_THROW(paths_csv({ply_of("A", segment)}), Error);
}

// The curve holds both tolerances between all samples, on gentle and on tight cylinders, with dense
// and with sparse samples.
TEST(PathsStep, FitHoldsItsTolerances) {
  for (const double radius : {8.0, 60.0, 350.0}) {
    const Skin skin = skin_of(Surface::cylinder(Frame{}, radius), {0, 2 * pi}, {-10, 1100});
    for (const double step : {0.5, 4.0, 11.0}) {
      const double angle = 0.6, length = std::min(1000.0, 5 * radius);
      const auto curves = fit_segment(skin, helix(radius, angle, length, step));
      ASSERT_EQ(curves.size(), 1u);
      EXPECT_NEAR(curves[0].first(), 0, 1e-12);
      EXPECT_NEAR(curves[0].last(), length, 1e-9);
      double off_surface = 0, off_path = 0;
      for (double s = 0; s <= length; s += 0.0137 * radius) {
        const Vec3 p = curves[0].point(s);
        off_surface = std::max(off_surface, std::abs(std::hypot(p.x(), p.y()) - radius));
        off_path = std::max(off_path, (p - helix_point(radius, angle, s)).norm());
      }
      // the tolerance is checked at 0.3 and 0.7 of each gap: between them a quartic may rise by a fifth
      EXPECT_LE(off_surface, 6e-5) << radius << " " << step;
      // where samples are sparse, points between them follow the cubic's projection, which strays
      // sideways by the error of the cubic itself: h^4 k^3 / 384
      const double cubic = std::pow(step, 4) * std::pow(1 / radius, 3) / 384;
      EXPECT_LE(off_path, 1e-4 + 2 * cubic) << radius << " " << step;
    }
  }
}

TEST(PathsStep, FitUsesFewPieces) {
  const Skin skin = skin_of(Surface::cylinder(Frame{}, 350), {0, 2 * pi}, {-10, 1100});
  const auto curves = fit_segment(skin, helix(350, 0.6, 1000, 1));
  ASSERT_EQ(curves.size(), 1u);
  // h^4 k^3 / 384 = 2e-5 at h = 24 mm: some 41 pieces, at most doubled by halving
  EXPECT_LE(curves[0].poles.size(), 2u * 2 * 64 + 2);
}

TEST(PathsStep, KinksSplitTheWire) {
  const Skin skin = skin_of(Surface::plane(Frame{}), {-10, 200}, {-10, 200});
  CourseSegment segment;
  for (int i = 0; i <= 20; ++i) {  // an L with its corner given twice
    const bool second = i > 10;
    CourseSample sample;
    sample.s_mm = second ? 10.0 * (i - 1) : 10.0 * i;
    sample.position = second ? Vec3(100, 10 * (i - 11), 0) : Vec3(10 * i, 0, 0);
    sample.tangent = second ? Vec3::UnitY() : Vec3::UnitX();
    sample.normal = Vec3::UnitZ();
    sample.at = {0, sample.position.head<2>()};
    segment.samples.push_back(sample);
  }
  const auto curves = fit_segment(skin, segment);
  ASSERT_EQ(curves.size(), 2u);
  EXPECT_EQ(curves[0].point(curves[0].last()), curves[1].point(curves[1].first()));
  EXPECT_EQ(curves[0].poles.size(), 4u);  // a straight line is one piece
}

TEST(PathsStep, WiresAreNamedGroupedAndColoured) {
  const Skin skin = skin_of(Surface::cylinder(Frame{}, 350), {0, 2 * pi}, {-10, 1100});
  const auto wires =
      path_wires(skin, {ply_of("P1", helix(350, 0.6, 100, 5)), ply_of("P2", helix(350, 0.6, 100, 5))});
  ASSERT_EQ(wires.size(), 8u);
  EXPECT_EQ(wires[0].name, "ply P1 course -1 segment 1");
  EXPECT_EQ(wires[2].name, "ply P1 course 0 segment 2");
  EXPECT_EQ(wires[3].name, "ply P1 course +1 segment 1");
  EXPECT_EQ(wires[0].group, "ply P1");
  EXPECT_EQ(wires[4].group, "ply P2");
  EXPECT_NE(wires[0].rgb, wires[3].rgb);
  EXPECT_NE(wires[3].rgb, wires[7].rgb);
}

TEST(SummaryJson, KeepsWhatVariesApart) {
  const Skin skin = skin_of(Surface::cylinder(Frame{}, 350), {0, 2 * pi}, {-10, 1100});
  StepModel model;
  model.part = skin.part();
  Ply ply = ply_of("P1", helix(350, 0.6, 100, 5));
  ply.report.min_steering_radius_mm = std::numeric_limits<double>::infinity();
  RunRecord run;
  run.inputs = {{"part", "part.step", "00"}};
  const auto varied = [&](double seconds, int threads, const std::string& clock) {
    run.times = {{"plan", seconds}};
    run.threads = threads;
    run.started = clock;
    ply.report.times = {{"parallels", seconds / 2}};
    return nlohmann::json::parse(summary_json(run, model, skin, {ply}));
  };
  auto a = varied(1, 1, "2026-01-01T00:00:00Z"), b = varied(2, 8, "2027-01-01T00:00:00Z");
  EXPECT_NE(a, b);
  a.erase("times");
  b.erase("times");
  EXPECT_EQ(a, b);
  EXPECT_TRUE(a["plies"][0]["min_steering_radius_mm"].is_null());
  EXPECT_EQ(a["plies"][0]["courses"].size(), 3u);
  EXPECT_EQ(a["plies"][0]["courses"][1]["segments"].size(), 2u);
  EXPECT_EQ(a["skin"]["faces"][0]["face"], 1);
  EXPECT_EQ(a["options"]["planning"]["step"], 2);
  EXPECT_EQ(a["options"]["input"]["sew_tolerance"], "automatic");
}

TEST(SummaryJson, NeverWritesNan) {
  const Skin skin = skin_of(Surface::plane(Frame{}), {0, 100}, {0, 100});
  StepModel model;
  Ply ply;
  ply.report.covered_share = std::nan("");
  EXPECT_THROW(summary_json({}, model, skin, {ply}), Error);
}

}  // namespace
}  // namespace afptraj
