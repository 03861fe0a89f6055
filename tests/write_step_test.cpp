#include "io/step/write_step.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <Geom_BSplineCurve.hxx>
#include <Quantity_Color.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <TDF_LabelSequence.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "geometry/error.h"
#include "tests/step_oracle.h"
#include "tests/temporary_directory.h"

namespace afptraj {
namespace {

BSplineCurve3 cubic(double from, double to, double y) {
  BSplineCurve3 curve;
  curve.degree = 3;
  curve.knots = {from, from, from, from, 0.5 * (from + to), 0.5 * (from + to), to, to, to, to};
  for (int i = 0; i < 6; ++i)
    curve.poles.push_back(
        {from + (to - from) * i / 5, y + 7 * std::sin(1.3 * i + from), 20 * std::cos(from + i / 3.0)});
  return curve;
}

/// Two plies; the second course of the first has two curves that meet.
std::vector<StepWire> wires() {
  BSplineCurve3 a = cubic(0, 400, 50), b = cubic(400, 700, 50);
  b.poles.front() = a.poles.back();
  BSplineCurve3 rational;
  rational.degree = 2;
  rational.knots = {0, 0, 0, 1, 1, 1};
  rational.poles = {{100, 0, 0}, {100, 100, 0}, {0, 100, 0}};
  rational.weights = {1, std::sqrt(0.5), 1};
  return {{"P1 course 0", "P1", {0, 0, 0}, {cubic(0, 600, 0)}},
          {"P1 course +1", "P1", {1, 0, 0}, {a, b}},
          {"P2 course 0", "P2", {0, 0.5, 1}, {rational}}};
}

struct ReadWire {
  std::string path;  ///< product / group / wire
  std::vector<Handle(Geom_BSplineCurve)> curves;
  Quantity_Color colour;
  bool coloured = false;
};

std::string name_of(const TDF_Label& label) {
  Handle(TDataStd_Name) name;
  if (!label.FindAttribute(TDataStd_Name::GetID(), name)) return "";
  return TCollection_AsciiString(name->Get()).ToCString();
}

void walk(const TDF_Label& label, const std::string& path, const Handle(XCAFDoc_ColorTool)& colours,
          std::vector<ReadWire>& wires) {
  if (XCAFDoc_ShapeTool::IsAssembly(label)) {
    TDF_LabelSequence parts;
    XCAFDoc_ShapeTool::GetComponents(label, parts);
    for (const TDF_Label& part : parts) {
      TDF_Label product;
      if (XCAFDoc_ShapeTool::GetReferredShape(part, product))
        walk(product, path + "/" + name_of(product), colours, wires);
    }
    return;
  }
  ReadWire wire{path, {}, {}, false};
  const TopoDS_Shape shape = XCAFDoc_ShapeTool::GetShape(label);
  for (TopExp_Explorer it(shape, TopAbs_EDGE); it.More(); it.Next()) {
    double first, last;
    wire.curves.push_back(
        Handle(Geom_BSplineCurve)::DownCast(BRep_Tool::Curve(TopoDS::Edge(it.Current()), first, last)));
    for (const XCAFDoc_ColorType type : {XCAFDoc_ColorCurv, XCAFDoc_ColorGen}) {
      for (const TopoDS_Shape& coloured : {it.Current(), shape}) {
        if (!wire.coloured) wire.coloured = colours->GetColor(coloured, type, wire.colour);
      }
    }
  }
  for (TopExp_Explorer it(shape, TopAbs_WIRE); it.More() && !wire.coloured; it.Next()) {
    wire.coloured = colours->GetColor(it.Current(), XCAFDoc_ColorCurv, wire.colour);
  }
  wires.push_back(std::move(wire));
}

std::vector<ReadWire> read_wires(const std::string& path) {
  const test::HushedCout hushed;
  STEPCAFControl_Reader reader;
  reader.SetColorMode(true);
  reader.SetNameMode(true);
  std::vector<ReadWire> result;
  if (reader.ReadFile(path.c_str()) != IFSelect_RetDone) return result;
  Handle(TDocStd_Document) document = new TDocStd_Document("BinXCAF");
  reader.Transfer(document);
  TDF_LabelSequence roots;
  XCAFDoc_DocumentTool::ShapeTool(document->Main())->GetFreeShapes(roots);
  for (const TDF_Label& root : roots)
    walk(root, name_of(root), XCAFDoc_DocumentTool::ColorTool(document->Main()), result);
  return result;
}

class WriteStep : public testing::TestWithParam<StepSchema> {
 protected:
  test::TemporaryDirectory directory_;
};

TEST_P(WriteStep, ReadsBackWithNamesGroupsAndColours) {
  const std::string path = directory_ / "paths.step";
  const std::vector<StepWire> written = wires();
  write_step(path, written, {GetParam(), "panel"});
  const std::string schema = GetParam() == StepSchema::ap242 ? "AP242" : "AUTOMOTIVE_DESIGN";
  EXPECT_NE(test::content_of(path).find(schema), std::string::npos);
  const std::vector<ReadWire> read = read_wires(path);
  ASSERT_EQ(read.size(), written.size());
  for (std::size_t w = 0; w < read.size(); ++w) {
    EXPECT_EQ(read[w].path, "panel/" + written[w].group + "/" + written[w].name);
    ASSERT_EQ(read[w].curves.size(), written[w].curves.size());
    ASSERT_TRUE(read[w].coloured);
    // A colour goes through single precision and the transfer curve of sRGB.
    double red, green, blue;
    read[w].colour.Values(red, green, blue, Quantity_TOC_sRGB);
    EXPECT_NEAR(red, written[w].rgb[0], 1e-3);
    EXPECT_NEAR(green, written[w].rgb[1], 1e-3);
    EXPECT_NEAR(blue, written[w].rgb[2], 1e-3);
    for (std::size_t c = 0; c < read[w].curves.size(); ++c) {
      const BSplineCurve3& curve = written[w].curves[c];
      const Handle(Geom_BSplineCurve)& other = read[w].curves[c];
      ASSERT_FALSE(other.IsNull());
      ASSERT_NEAR(other->FirstParameter(), curve.first(), 1e-9);
      ASSERT_NEAR(other->LastParameter(), curve.last(), 1e-9);
      for (int k = 0; k <= 50; ++k) {
        const double t = curve.first() + (curve.last() - curve.first()) * k / 50;
        const gp_Pnt p = other->Value(t);
        // (W2)
        EXPECT_LE((curve.point(t) - Eigen::Vector3d(p.X(), p.Y(), p.Z())).norm(), 1e-9);
      }
    }
  }
}

TEST_P(WriteStep, SameBytes) {  // (W1)
  const std::string a = directory_ / "paths.step", b = (directory_ / "other").string();
  std::filesystem::create_directory(b);
  write_step(a, wires(), {GetParam(), "panel"});
  std::vector<std::string> noise(1000, std::string(100, 'x'));  // other addresses on the heap
  write_step(b + "/paths.step", wires(), {GetParam(), "panel"});
  EXPECT_TRUE(test::content_of(a) == test::content_of(b + "/paths.step"));
}

INSTANTIATE_TEST_SUITE_P(Schemas, WriteStep, testing::Values(StepSchema::ap242, StepSchema::ap214),
                         [](const auto& info) {
                           return std::string(info.param == StepSchema::ap242 ? "ap242" : "ap214");
                         });

TEST(WriteStepHeader, TimeComesFromTheEnvironmentOnly) {
  const test::TemporaryDirectory directory;
  ::unsetenv("SOURCE_DATE_EPOCH");
  write_step(directory / "a.step", wires());
  EXPECT_NE(test::content_of(directory / "a.step").find("1970-01-01T00:00:00"), std::string::npos);
  ::setenv("SOURCE_DATE_EPOCH", "1700000000", 1);
  write_step(directory / "b.step", wires());
  ::unsetenv("SOURCE_DATE_EPOCH");
  EXPECT_NE(test::content_of(directory / "b.step").find("2023-11-14T22:13:20"), std::string::npos);
}

TEST(WriteStepFailure, SaysWhy) {
  const test::TemporaryDirectory directory;
  for (const std::string& path : {std::string("/dev/full"), (directory / "none" / "paths.step").string()}) {
    try {
      write_step(path, wires());
      FAIL() << path;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::cannot_write);
      EXPECT_EQ(error.where(), path);
    }
  }
}

TEST(WriteStepFailure, LeavesNoHalfFile) {
  const test::TemporaryDirectory directory;
  const std::string path = directory / "paths.step";
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit small = before;
  small.rlim_cur = 2000;
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  EXPECT_THROW(write_step(path, wires()), Error);
  ::setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(WriteStepQuiet, PrintsNothing) {
  const test::TemporaryDirectory directory;
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  write_step(directory / "paths.step", wires());
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(WriteStepNames, SurviveQuotesAndSlashes) {
  const test::TemporaryDirectory directory;
  const std::string path = directory / "paths.step";
  std::vector<StepWire> named = wires();
  named.resize(1);
  named[0].name = "it's ply/1 \\ x";
  write_step(path, named);
  const std::vector<ReadWire> read = read_wires(path);
  ASSERT_EQ(read.size(), 1u);
  EXPECT_EQ(read[0].path, "afptraj/P1/it's ply/1 \\ x");
}

}  // namespace
}  // namespace afptraj
