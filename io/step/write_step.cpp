#include "io/step/write_step.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <APIHeaderSection_MakeHeader.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRep_Builder.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Interface_HArray1OfHAsciiString.hxx>
#include <Interface_Static.hxx>
#include <Quantity_Color.hxx>
#include <STEPCAFControl_Writer.hxx>
#include <STEPConstruct.hxx>
#include <STEPConstruct_Styles.hxx>
#include <STEPControl_Controller.hxx>
#include <StepBasic_Product.hxx>
#include <StepData_Protocol.hxx>
#include <StepData_StepModel.hxx>
#include <StepData_StepWriter.hxx>
#include <StepRepr_NextAssemblyUsageOccurrence.hxx>
#include <StepRepr_RepresentationContext.hxx>
#include <StepRepr_RepresentationItem.hxx>
#include <StepVisual_Colour.hxx>
#include <StepVisual_MechanicalDesignGeometricPresentationRepresentation.hxx>
#include <StepVisual_PresentationStyleAssignment.hxx>
#include <StepVisual_StyledItem.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColgp_Array1OfPnt.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Vertex.hxx>
#include <TopoDS_Wire.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <XSControl_TransferWriter.hxx>
#include <XSControl_WorkSession.hxx>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <map>
#include <sstream>

#include "io/step/occt.h"

#ifndef AFPTRAJ_VERSION
#define AFPTRAJ_VERSION "unknown"
#endif

namespace afptraj {
namespace {

using step::occt_guard;

Handle(Geom_BSplineCurve) to_occt(const BSplineCurve3& curve, const std::string& name) {
  const auto count = static_cast<int>(curve.poles.size());
  const bool sized = count >= 2 && curve.degree >= 1 &&
                     curve.knots.size() == curve.poles.size() + static_cast<std::size_t>(curve.degree) + 1 &&
                     (curve.weights.empty() || curve.weights.size() == curve.poles.size());
  if (!sized)
    throw Error(ErrorCode::internal, name, "a curve to write has poles and knots that do not fit together");
  TColgp_Array1OfPnt poles(1, count);
  TColStd_Array1OfReal weights(1, count);
  for (int i = 1; i <= count; ++i) {
    const auto k = static_cast<std::size_t>(i - 1);
    poles(i) = gp_Pnt(curve.poles[k].x(), curve.poles[k].y(), curve.poles[k].z());
    weights(i) = curve.weights.empty() ? 1 : curve.weights[k];
  }
  std::vector<double> distinct;
  std::vector<int> repeated;
  for (const double knot : curve.knots) {
    if (distinct.empty() || knot != distinct.back()) distinct.push_back(knot), repeated.push_back(0);
    ++repeated.back();
  }
  TColStd_Array1OfReal knots(1, static_cast<int>(distinct.size()));
  TColStd_Array1OfInteger multiplicities(1, static_cast<int>(distinct.size()));
  for (std::size_t i = 0; i < distinct.size(); ++i) {
    knots(static_cast<int>(i) + 1) = distinct[i];
    multiplicities(static_cast<int>(i) + 1) = repeated[i];
  }
  if (curve.weights.empty()) return new Geom_BSplineCurve(poles, knots, multiplicities, curve.degree);
  return new Geom_BSplineCurve(poles, weights, knots, multiplicities, curve.degree, Standard_False,
                               Standard_False);
}

/// A wire whose edges share vertices where one curve ends and the next begins.
TopoDS_Wire make_wire(const StepWire& wire) {
  constexpr double join_mm = 1e-3;
  BRep_Builder builder;
  TopoDS_Wire result;
  builder.MakeWire(result);
  TopoDS_Vertex last;
  gp_Pnt last_point, first_point;
  TopoDS_Vertex first;
  for (std::size_t i = 0; i < wire.curves.size(); ++i) {
    const Handle(Geom_BSplineCurve) curve = to_occt(wire.curves[i], wire.name);
    const gp_Pnt from = curve->StartPoint(), to = curve->EndPoint();
    TopoDS_Vertex start, end;
    if (!last.IsNull() && last_point.Distance(from) <= join_mm) {
      start = last;
      builder.UpdateVertex(start, std::max(1e-7, 1.1 * last_point.Distance(from)));
    } else {
      builder.MakeVertex(start, from, 1e-7);
    }
    if (i == 0) first = start, first_point = from;
    if (i + 1 == wire.curves.size() && first_point.Distance(to) <= 1e-7) {
      end = first;
    } else {
      builder.MakeVertex(end, to, 1e-7);
    }
    BRepBuilderAPI_MakeEdge edge(curve, start, end, curve->FirstParameter(), curve->LastParameter());
    if (!edge.IsDone())
      throw Error(ErrorCode::internal, wire.name, "OpenCASCADE cannot make an edge of a curve");
    builder.Add(result, edge.Edge());
    last = end, last_point = to;
  }
  return result;
}

/// product > group > wire, as a document with names. `shapes_made` gets the shape of every wire.
Handle(TDocStd_Document) make_document(const std::vector<StepWire>& wires, const std::string& product,
                                       std::vector<TopoDS_Shape>& shapes_made) {
  Handle(TDocStd_Document) document = new TDocStd_Document("BinXCAF");
  XCAFDoc_DocumentTool::Set(document->Main(), Standard_False);
  const Handle(XCAFDoc_ShapeTool) shapes = XCAFDoc_DocumentTool::ShapeTool(document->Main());
  shapes->SetAutoNaming(Standard_False);
  const auto text = [](const std::string& s) { return TCollection_ExtendedString(s.c_str(), Standard_True); };

  const TDF_Label root = shapes->NewShape();
  TDataStd_Name::Set(root, text(product));
  std::map<std::string, TDF_Label> groups;
  for (const StepWire& wire : wires) {
    auto found = groups.find(wire.group);
    if (found == groups.end()) {
      const TDF_Label group = shapes->NewShape();
      TDataStd_Name::Set(group, text(wire.group));
      const TDF_Label placed = shapes->AddComponent(root, group, TopLoc_Location());
      TDataStd_Name::Set(placed, text(wire.group));
      found = groups.emplace(wire.group, group).first;
    }
    shapes_made.push_back(make_wire(wire));
    const TDF_Label label = shapes->AddShape(shapes_made.back(), Standard_False);
    TDataStd_Name::Set(label, text(wire.name));
    const TDF_Label placed = shapes->AddComponent(found->second, label, TopLoc_Location());
    TDataStd_Name::Set(placed, text(wire.name));
  }
  shapes->UpdateAssemblies();
  return document;
}

/// Gives every wire its colour, in the order of the wires. STEPCAFControl_Writer would write the
/// colours of a document in the order of a hash of addresses, which differs from run to run.
void add_colours(const Handle(XSControl_WorkSession)& session, const std::vector<StepWire>& wires,
                 const std::vector<TopoDS_Shape>& shapes) {
  STEPConstruct_DataMapOfAsciiStringTransient predefined;
  STEPConstruct_DataMapOfPointTransient mixed;
  for (std::size_t i = 0; i < wires.size(); ++i) {
    STEPConstruct_Styles styles(session);
    const Handle(StepRepr_RepresentationItem) item =
        STEPConstruct::FindEntity(session->TransferWriter()->FinderProcess(), shapes[i]);
    const Handle(StepRepr_RepresentationContext) context = styles.FindContext(shapes[i]);
    if (item.IsNull() || context.IsNull())
      throw Error(ErrorCode::internal, wires[i].name, "OpenCASCADE has no STEP entity for a course");
    const std::array<double, 3>& rgb = wires[i].rgb;
    const Handle(StepVisual_Colour) colour = STEPConstruct_Styles::EncodeColor(
        Quantity_Color(rgb[0], rgb[1], rgb[2], Quantity_TOC_sRGB), predefined, mixed);
    styles.AddStyle(item, styles.MakeColorPSA(item, nullptr, colour, nullptr, 0), nullptr);
    Handle(StepVisual_MechanicalDesignGeometricPresentationRepresentation) presentation;
    if (!styles.CreateMDGPR(context, presentation))
      throw Error(ErrorCode::internal, wires[i].name, "OpenCASCADE cannot colour a course");
    session->Model()->AddWithRefs(presentation);
  }
}

/// OpenCASCADE numbers placements by a counter that goes on through the life of the process.
void number_placements(const Handle(StepData_StepModel)& model) {
  int number = 0;
  for (int i = 1; i <= model->NbEntities(); ++i) {
    const auto placement = Handle(StepRepr_NextAssemblyUsageOccurrence)::DownCast(model->Value(i));
    if (!placement.IsNull()) placement->SetId(new TCollection_HAsciiString(std::to_string(++number).c_str()));
  }
}

std::string time_stamp() {
  std::time_t seconds = 0;  // a constant, so that equal input gives equal bytes
  if (const char* epoch = std::getenv("SOURCE_DATE_EPOCH"))
    seconds = static_cast<std::time_t>(std::strtoll(epoch, nullptr, 10));
  std::tm utc{};
  if (!::gmtime_r(&seconds, &utc)) return "1970-01-01T00:00:00";
  char text[64];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S", &utc);
  return text;
}

void set_header(const Handle(StepData_StepModel)& model, const std::string& name) {
  const auto string = [](const std::string& s) {
    return Handle(TCollection_HAsciiString)(new TCollection_HAsciiString(s.c_str()));
  };
  const auto list = [&](const std::string& s) {
    Handle(Interface_HArray1OfHAsciiString) one = new Interface_HArray1OfHAsciiString(1, 1);
    one->SetValue(1, string(s));
    return one;
  };
  APIHeaderSection_MakeHeader header(model);
  header.SetName(string(name));
  header.SetTimeStamp(string(time_stamp()));
  header.SetAuthor(list("afptraj"));
  header.SetOrganization(list(""));
  header.SetPreprocessorVersion(string("afptraj " AFPTRAJ_VERSION));
  header.SetOriginatingSystem(string("afptraj " AFPTRAJ_VERSION));
  header.SetAuthorisation(string(""));
  header.SetDescription(list("courses of fibre placement"));
  header.Apply(model);
}

std::string step_bytes(const std::vector<StepWire>& wires, const StepWriteOptions& options,
                       const std::string& name) {
  STEPControl_Controller::Init();
  Interface_Static::SetCVal("xstep.cascade.unit", "MM");
  Interface_Static::SetCVal("write.step.unit", "MM");
  Interface_Static::SetIVal("write.step.schema", options.schema == StepSchema::ap242 ? 5 : 4);
  Interface_Static::SetIVal("write.step.assembly", 1);
  Interface_Static::SetCVal("write.step.product.name", options.product.c_str());
  Interface_Static::SetIVal("write.precision.mode", 1);
  std::vector<TopoDS_Shape> shapes;
  const Handle(TDocStd_Document) document = make_document(wires, options.product, shapes);
  STEPCAFControl_Writer writer;
  writer.SetColorMode(false);  // add_colours does it
  writer.SetNameMode(true);
  writer.SetLayerMode(false);
  writer.SetPropsMode(false);
  writer.SetSHUOMode(false);
  writer.SetDimTolMode(false);
  writer.SetMaterialMode(false);
  if (!writer.Transfer(document, STEPControl_AsIs))
    throw Error(ErrorCode::internal, name, "OpenCASCADE cannot turn the courses into STEP");
  const Handle(XSControl_WorkSession) session = writer.ChangeWriter().WS();
  const Handle(StepData_StepModel) model = Handle(StepData_StepModel)::DownCast(session->Model());
  add_colours(session, wires, shapes);
  number_placements(model);
  set_header(model, name);
  StepData_StepWriter text(model);
  text.SendModel(Handle(StepData_Protocol)::DownCast(session->Protocol()));
  std::ostringstream bytes;
  if (!text.Print(bytes) || !bytes)
    throw Error(ErrorCode::internal, name, "OpenCASCADE cannot write the courses as text");
  return std::move(bytes).str();
}

[[noreturn]] void fail(const std::string& where, const std::string& doing, int fault) {
  throw Error(ErrorCode::cannot_write, where,
              "cannot " + doing + " (" + std::strerror(fault) +
                  "); check the directory, its permissions, the free space and the limit on file size (ulimit -f)");
}

/// Writes and flushes; a file that could not be written whole is removed.
void write_file(const std::filesystem::path& path, const std::string& bytes) {
  const std::string where = path.string();
  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (fd < 0) fail(where, "create it", errno);
  struct stat status {};
  const bool regular = ::fstat(fd, &status) == 0 && S_ISREG(status.st_mode);
  std::size_t done = 0;
  int fault = 0;
  while (done < bytes.size() && fault == 0) {
    const ssize_t sent = ::write(fd, bytes.data() + done, bytes.size() - done);
    if (sent >= 0) {
      done += static_cast<std::size_t>(sent);
    } else if (errno != EINTR) {
      fault = errno;
    }
  }
  if (fault == 0 && regular && ::fsync(fd) != 0) fault = errno;
  if (::close(fd) != 0 && fault == 0) fault = errno;
  if (fault == 0) return;
  if (regular) ::unlink(path.c_str());
  fail(where, "write it", fault);
}

}  // namespace

void write_step(const std::filesystem::path& path, const std::vector<StepWire>& wires,
                const StepWriteOptions& options) {
  std::string bytes;
  {
    const step::QuietOcct quiet;
    bytes = occt_guard(ErrorCode::internal, path.string(), "writing courses",
                       [&] { return step_bytes(wires, options, path.filename().string()); });
  }
  write_file(path, bytes);
}

}  // namespace afptraj
