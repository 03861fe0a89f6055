#include <gtest/gtest.h>

#include <sstream>

#include "fill/contour_parallel.h"
#include "geometry/error.h"
#include "io/fill_programs.h"
#include "io/slice_dxf.h"
#include "io/slice_svg.h"
#include "tests/slices.h"
#include "tests/temporary_directory.h"

namespace afptraj {
namespace {

using namespace test;

constexpr double tolerance = 1e-4;

class Drawings : public ::testing::Test {
 protected:
  std::string file(const std::string& name, const std::string& text) {
    const auto path = scratch_ / name;
    std::ofstream(path) << text;
    return path.string();
  }
  SliceFile svg(const std::string& content,
                const std::string& attributes = R"x(width="100mm" viewBox="0 0 100 80")x") {
    return read_slice_svg(file("a.svg", "<?xml version=\"1.0\"?>\n<!-- x > y -->\n<svg " + attributes +
                                            ">\n" + content + "\n</svg>\n"),
                          tolerance);
  }
  SliceFile dxf(const std::string& entities, const std::string& unit = "4") {
    return read_slice_dxf(
        file("a.dxf", groups("0 SECTION 2 HEADER 9 $INSUNITS 70 " + unit + " 0 ENDSEC 0 SECTION 2 ENTITIES " +
                             entities + " 0 ENDSEC 0 EOF")),
        tolerance);
  }
  // One word a line.
  static std::string groups(const std::string& words) {
    std::istringstream in(words);
    std::string out, word;
    while (in >> word) out += word + "\n";
    return out;
  }

 private:
  TemporaryDirectory scratch_;
};

// A flattened curve of length L and chords nearer than t to it encloses an area within L t.
void expect_area(const SliceFile& file, double area, double length) {
  EXPECT_NEAR(file.slice.area_mm2(), area, length * tolerance);
}

Vec2 low_of(const Slice& slice) {
  Vec2 low = Vec2::Constant(HUGE_VAL);
  for (const Vec2& p : points_of(slice)) low = low.cwiseMin(p);
  return low;
}

TEST_F(Drawings, SvgShapesInClosedForm) {
  expect_area(svg(R"x(<circle cx="20" cy="20" r="5"/>)x"), pi * 25, 32);
  expect_area(svg(R"x(<ellipse cx="20" cy="20" rx="5" ry="3"/>)x"), pi * 15, 30);
  expect_area(svg(R"x(<rect x="1" y="2" width="10" height="6"/>)x"), 60, 0.01);
  expect_area(svg(R"x(<rect x="1" y="2" width="10" height="6" rx="2"/>)x"), 60 - (4 - pi) * 4, 32);
  expect_area(svg(R"x(<polygon points="0,0 10,0 0,10"/>)x"), 50, 0.01);
  expect_area(svg(R"x(<polyline points="0,0 10,0 0,10 0,0"/>)x"), 50, 0.01);
  // ring: hole and outline of one path; two half circles as arcs, with packed flags
  expect_area(svg(R"x(<path d="M10 20a10 10 0 1030 0a10,10 0 10-30 0zM15 20H35V25H15Z"/>)x"), pi * 225 - 100,
              130);
}

TEST_F(Drawings, SvgCurvesInClosedForm) {
  // below a parabola y = x (1 - x) scaled: 10 x 10 / 6 each; the smooth one mirrors it
  expect_area(svg(R"x(<path d="M0 0Q5 10 10 0Z"/>)x"), 100.0 / 3, 25);
  expect_area(svg(R"x(<path d="m0 0q5 10 10 0t10 0v-10h-20z"/>)x"), 200, 80);
  expect_area(svg(R"x(<path d="m0 0q5 10 10 0t10 0t10 0v-10h-30z"/>)x"), 300 + 100.0 / 3, 110);
  // a cubic with the control points of the same parabola
  expect_area(svg(R"x(<path d="M0,0C3.3333333333,6.6666666667 6.6666666667,6.6666666667 10,0Z"/>)x"),
              100.0 / 3, 25);
  expect_area(svg(R"x(<path d="M0 0c2 4 8 4 10 0s8-4 10 0v-10h-20z"/>)x"), 200, 80);
}

TEST_F(Drawings, SvgPlaces) {
  // y upwards: what is at the top of the page is at its height
  EXPECT_LT((low_of(svg(R"x(<rect x="10" y="0" width="5" height="8"/>)x").slice) - Vec2(10, 72)).norm(),
            1e-9);
  EXPECT_LT(
      (low_of(
           svg(R"x(<g transform="translate(10 20)"><g transform="scale(2)"><rect width="5" height="8"/></g></g>)x")
               .slice) -
       Vec2(10, 44))
          .norm(),
      1e-9);
  // a quarter turn about (10, 10) takes (10 .. 15, 10 .. 12) to (8 .. 10, 10 .. 15), y downwards
  EXPECT_LT(
      (low_of(svg(R"x(<rect x="10" y="10" width="5" height="2" transform="rotate(90 10 10)"/>)x").slice) -
       Vec2(8, 65))
          .norm(),
      1e-9);
  EXPECT_LT((low_of(svg(R"x(<rect width="5" height="2" transform="matrix(0,1,-1,0,20,0)"/>)x").slice) -
             Vec2(18, 75))
                .norm(),
            1e-9);
  EXPECT_LT((low_of(svg(R"x(<rect width="5" height="8" transform="translate(10 20) scale(2)"/>)x").slice) -
             Vec2(10, 44))
                .norm(),
            1e-9);
  // scale: 100 units are 50 mm
  EXPECT_NEAR(
      svg(R"x(<rect width="10" height="10"/>)x", R"x(width="5cm" viewBox="0 0 100 80")x").slice.area_mm2(),
      25, 1e-9);
  const SliceFile bare = svg(R"x(<rect width="10" height="10"/><text x="3">no</text>)x", "");
  EXPECT_NEAR(bare.slice.area_mm2(), 100, 1e-9);
  EXPECT_EQ(bare.warnings.size(), 2u);
  EXPECT_NEAR(svg(R"x(<defs><circle r="3"/></defs><rect width="10" height="10"/>)x").slice.area_mm2(), 100,
              1e-9);
}

TEST_F(Drawings, SvgRefusals) {
  const std::pair<const char*, const char*> defects[] = {
      {R"x(<path d="M0 0L10 0L0 10"/>)x", "is open"},
      {R"x(<polyline points="0,0 10,0 0,10"/>)x", "is open"},
      {R"x(<path d="M0 0L10 0L0 nan Z"/>)x", "a number is missing"},
      {R"x(<path d="L10 0L0 10Z"/>)x", "does not begin with M"},
      {R"x(<path d="M0 0B10 0Z"/>)x", "is no command"},
      {R"x(<circle r="-1"/>)x", "has no size"},
      {R"x(<circle r="10%"/>)x", "is not a number of user units"},
      {R"x(<circle r="5" transform="turn(3)"/>)x", "transform: "},
      {R"x(<g><circle r="5"/>)x", "closes what is not open"},
      {R"x(<circle r="5>)x", "has no quoted value"},
      {R"x(<polygon points="0,0 10,10 10,0 0,10"/>)x", "crosses itself"},
      {R"x(<text>x</text>)x", "holds no ring"},
  };
  for (const auto& [content, words] : defects) {
    try {
      svg(content);
      ADD_FAILURE() << content;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  }
  EXPECT_THROW(read_slice_svg(file("b.svg", "<html></html>"), tolerance), Error);
  EXPECT_THROW(read_slice_svg(file("c.svg", ""), tolerance), Error);
}

TEST_F(Drawings, DxfShapesInClosedForm) {
  expect_area(dxf("0 CIRCLE 10 20 20 20 40 5"), pi * 25, 32);
  expect_area(dxf("0 LWPOLYLINE 90 3 70 1 10 0 20 0 10 10 20 0 10 0 20 10"), 50, 0.01);
  // two corners, two half circles by bulge 1; clockwise with -1
  for (const char* bulge : {"1", "-1"})
    expect_area(dxf(std::string("0 LWPOLYLINE 70 1 10 0 20 0 42 ") + bulge + " 10 10 20 0 42 " + bulge),
                pi * 25, 32);
  expect_area(
      dxf("0 POLYLINE 70 1 0 VERTEX 10 0 20 0 42 1 0 VERTEX 10 10 20 0 0 SEQEND 0 CIRCLE 10 40 20 0 40 1"),
      pi * 12.5 + pi, 40);
  expect_area(dxf("0 ELLIPSE 10 0 20 0 11 5 21 0 40 0.6 41 0 42 6.283185307179586"), pi * 15, 30);
  // four quarters of a circle, one turned inwards: bulge tan(pi / 8)
  expect_area(
      dxf("0 LWPOLYLINE 70 1 10 5 20 0 42 0.4142135623730951 10 0 20 5 42 -0.4142135623730951 10 -5 20 0 42 "
          "0.4142135623730951 10 0 20 -5 42 0.4142135623730951"),
      pi * 25 - 2 * (pi * 25 / 4 - 12.5), 40);
  // a stadium of lines and arcs in no order and any sense
  expect_area(dxf("0 LINE 10 0 20 0 11 10 21 0 0 ARC 10 0 20 3 40 3 50 90 51 270 0 LINE 10 0 20 6 11 10 21 6 "
                  "0 ARC 10 10 20 3 40 3 50 -90 51 90"),
              60 + pi * 9, 40);
  // a parabola as a spline, closed by its chord
  expect_area(dxf("0 SPLINE 71 2 40 0 40 0 40 0 40 1 40 1 40 1 10 0 20 0 10 5 20 10 10 10 20 0 0 LINE 10 0 "
                  "20 0 11 10 21 0"),
              100.0 / 3, 25);
  // a quarter of a circle as a rational spline
  expect_area(dxf("0 SPLINE 71 2 40 0 40 0 40 0 40 1 40 1 40 1 41 1 41 0.7071067811865476 41 1 10 5 20 0 10 "
                  "5 20 5 10 0 20 5 "
                  "0 LINE 10 0 20 5 11 0 21 0 0 LINE 10 0 20 0 11 5 21 0"),
              pi * 25 / 4, 18);
}

TEST_F(Drawings, DxfPlaces) {
  EXPECT_NEAR(dxf("0 LWPOLYLINE 70 1 10 0 20 0 10 1 20 0 10 0 20 1", "1").slice.area_mm2(), 25.4 * 25.4 / 2,
              1e-9);
  EXPECT_EQ(dxf("0 CIRCLE 10 0 20 0 30 7 40 5", "5").z_mm, 70);
  // seen from below: x is mirrored
  EXPECT_LT(low_of(dxf("0 CIRCLE 10 20 20 0 40 5 230 -1").slice).x(), -24.9);
  const SliceFile warned = dxf("0 CIRCLE 10 0 20 0 40 5 0 TEXT 1 hello", "0");
  EXPECT_EQ(warned.warnings.size(), 2u);
}

TEST_F(Drawings, DxfRefusals) {
  const std::pair<const char*, const char*> defects[] = {
      {"0 LINE 10 0 20 0 11 10 21 0", "a curve ends at (10, 0) mm"},
      {"0 LWPOLYLINE 70 0 10 0 20 0 10 10 20 0 10 0 20 10", "a curve ends at"},
      {"0 LINE 10 0 20 0 11 1 21 0 0 LINE 10 1 20 0 11 0 21 1 0 LINE 10 0 20 1 11 0 21 0 "
       "0 LINE 10 0 20 0 11 1 21 1 0 LINE 10 1 20 1 11 1 21 0",
       "more than two curves meet"},
      {"0 CIRCLE 10 0 20 0 40 0", "has no radius"},
      {"0 CIRCLE 10 0 20 0 40 x", "is not a finite number"},
      {"0 CIRCLE 10 0 20 0 40 5 210 1 230 0", "tilted plane"},
      {"0 CIRCLE 10 0 20 0 40 5 0 CIRCLE 10 20 20 0 30 1 40 5", "another height"},
      {"0 SPLINE 71 3 40 0 40 1 10 0 20 0", "SPLINE has no sound"},
      {"0 TEXT 1 x", "holds no ring"},
      {"x y", "is no group code"},
  };
  for (const auto& [entities, words] : defects) {
    try {
      dxf(entities);
      ADD_FAILURE() << entities;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  }
  EXPECT_THROW(dxf("0 CIRCLE 40 5", "9"), Error);
  EXPECT_THROW(read_slice_dxf(file("b.dxf", "hello"), tolerance), Error);
}

// What is fed is the factor times the length; all moves together are the paths.
TEST(FillPrograms, GcodeAddsUp) {
  const Fill fill = contour_parallel(slice_of({flower(0.15, 300)}), {});
  double length = 0;
  for (const FillPath& path : fill.paths) length += length_mm(path.line);
  std::istringstream in(fill_gcode(fill, {900, 0.033, 0.2}));
  std::string line;
  double moved = 0, fed = 0;
  std::size_t starts = 0;
  Vec2 at = Vec2::Zero();
  EXPECT_TRUE(std::getline(in, line) && line == "G21");
  while (std::getline(in, line)) {
    double x = 0, y = 0, e = 0;
    if (std::sscanf(line.c_str(), "G0 X%lf Y%lf", &x, &y) == 2) {
      ++starts;
    } else if (std::sscanf(line.c_str(), "G1 X%lf Y%lf E%lf", &x, &y, &e) == 3) {
      moved += (Vec2(x, y) - at).norm();
      fed += e;
    } else {
      continue;
    }
    at = {x, y};
  }
  EXPECT_EQ(starts, fill.paths.size());
  EXPECT_NEAR(moved, length, 0.05);        // some thousand moves rounded to 1e-4
  EXPECT_NEAR(fed, 0.033 * length, 1e-5);  // what is rounded is made good
}

TEST(FillPrograms, Texts) {
  Fill fill;
  fill.paths.push_back({{{{0, 0}, {1, 0}, {1, 1}}, true}, PathKind::ring, 3});
  fill.paths.push_back({{{{5, 0}, {6, 0}}, false}, PathKind::line, 0});
  EXPECT_EQ(fill_gcode(fill, {600, 0, 2}),
            "G21\nG90\n; path 0\nG0 X0 Y0 Z2\nG1 X1 Y0 F600\nG1 X1 Y1\nG1 X0 Y0\n; path 1\nG0 X5 Y0\nG1 X6 "
            "Y0 F600\nM2\n");
  const std::string vtp = fill_vtp(fill, 2);
  EXPECT_NE(vtp.find("NumberOfPoints=\"5\" NumberOfVerts=\"0\" NumberOfLines=\"2\""), std::string::npos);
  EXPECT_NE(vtp.find("0 1 2 0\n3 4 \n"), std::string::npos);
  EXPECT_NE(vtp.find("\n4\n6\n"), std::string::npos);
}

}  // namespace
}  // namespace afptraj
