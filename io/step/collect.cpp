#include "io/step/collect.h"

#include <BRepBuilderAPI_Transform.hxx>
#include <BRep_Builder.hxx>
#include <IFSelect_ReturnStatus.hxx>
#include <Interface_Static.hxx>
#include <Quantity_Color.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <STEPControl_Controller.hxx>
#include <STEPControl_Reader.hxx>
#include <StepGeom_Surface.hxx>
#include <StepRepr_RepresentationItem.hxx>
#include <StepShape_Face.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TDF_LabelSequence.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_MapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Iterator.hxx>
#include <TransferBRep.hxx>
#include <Transfer_TransientProcess.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>
#include <cmath>
#include <cstring>
#include <istream>
#include <streambuf>
#include <unordered_map>

#include "io/step/occt.h"
#include "io/step/units.h"

namespace afptraj::step {
namespace {

[[noreturn]] void refuse(const std::string& where, const std::string& message) {
  throw Error(ErrorCode::bad_input, where, message);
}

/// The bytes of a string as a stream, without a copy.
class MemoryBuffer : public std::streambuf {
 public:
  explicit MemoryBuffer(std::string_view bytes) {
    char* data = const_cast<char*>(bytes.data());  // streambuf wants char*; nothing writes
    setg(data, data, data + bytes.size());
  }
};

std::string status_text(IFSelect_ReturnStatus status) {
  switch (status) {
    case IFSelect_RetVoid:
      return "nothing in it";
    case IFSelect_RetError:
      return "not a STEP file it knows";
    case IFSelect_RetFail:
      return "a syntax error";
    default:
      return "stopped";
  }
}

std::string first_line_of_broken_references(const StepText& text) {
  const std::vector<std::string> broken = find_broken_references(text);
  return broken.empty() ? "" : "; " + broken.front();
}

/// Entity number and name of the face entities and of surfaces that stand alone, by the TShape
/// that they became.
struct Origin {
  int step_id = 0;
  std::string name;
};
using Origins = std::unordered_map<const TopoDS_TShape*, Origin>;

Origins find_origins(const Handle(XSControl_WorkSession)& session, const Handle(StepData_StepModel)& model) {
  Origins origins;
  const Handle(Transfer_TransientProcess) process = session->TransferReader()->TransientProcess();
  for (int pass = 0; pass < 2; ++pass) {  // faces first: a surface that stands alone has no face entity
    for (int i = 1; i <= process->NbMapped(); ++i) {
      const Handle(Standard_Transient) entity = process->Mapped(i);
      if (!entity->IsKind(pass == 0 ? STANDARD_TYPE(StepShape_Face) : STANDARD_TYPE(StepGeom_Surface)))
        continue;
      const TopoDS_Shape shape = TransferBRep::ShapeResult(process, entity);
      if (shape.IsNull() || shape.ShapeType() != TopAbs_FACE) continue;
      Origin origin{model->IdentLabel(entity), ""};
      const auto item = Handle(StepRepr_RepresentationItem)::DownCast(entity);
      if (!item.IsNull() && !item->Name().IsNull()) origin.name = item->Name()->ToCString();
      origins.emplace(shape.TShape().get(), std::move(origin));
    }
  }
  return origins;
}

std::string label_name(const TDF_Label& label) {
  Handle(TDataStd_Name) name;
  if (!label.FindAttribute(TDataStd_Name::GetID(), name)) return "";
  const TCollection_ExtendedString& text = name->Get();
  std::string utf8(static_cast<std::size_t>(text.LengthOfCString()) + 1, '\0');
  Standard_PCharacter data = utf8.data();
  text.ToUTF8CString(data);
  utf8.resize(std::strlen(utf8.c_str()));
  return utf8;
}

std::array<double, 3> to_srgb(const Quantity_Color& colour) {
  std::array<double, 3> rgb;
  colour.Values(rgb[0], rgb[1], rgb[2], Quantity_TOC_sRGB);
  return rgb;
}

/// Walks shapes and adds their faces.
class FaceCollector {
 public:
  FaceCollector(SourceModel& model, const Origins& origins, Handle(XCAFDoc_ColorTool) colours)
      : model_(model), origins_(origins), colours_(std::move(colours)) {}

  /// All faces of a placed shape, in the order of the file.
  void add(const TopoDS_Shape& shape, const std::string& instance,
           const std::optional<std::array<double, 3>>& colour) {
    instance_ = instance;
    colour_ = colour;
    seen_.Clear();
    loose_group_ = -1;
    visit(shape, -1, false);
  }

 private:
  void visit(const TopoDS_Shape& shape, int group, bool in_solid) {
    switch (shape.ShapeType()) {
      case TopAbs_SOLID:
        ++model_.solids;
        group = model_.groups++;
        in_solid = true;
        break;
      case TopAbs_SHELL:
        ++model_.shells;
        if (!in_solid) group = model_.groups++;
        break;
      case TopAbs_FACE:
        add_face(TopoDS::Face(shape), group, in_solid);
        return;
      case TopAbs_WIRE:
      case TopAbs_EDGE:
      case TopAbs_VERTEX:
        return;
      default:
        break;
    }
    for (TopoDS_Iterator child(shape); child.More(); child.Next()) visit(child.Value(), group, in_solid);
  }

  void add_face(const TopoDS_Face& face, int group, bool in_solid) {
    if (!in_solid && !seen_.Add(face)) return;
    if (group < 0) {
      if (loose_group_ < 0) loose_group_ = model_.groups++;
      group = loose_group_;
    }
    SourceFace source{face, group, in_solid, "", instance_, 0, face_colour(face)};
    if (const auto origin = origins_.find(face.TShape().get()); origin != origins_.end()) {
      source.step_id = origin->second.step_id;
      source.name = origin->second.name;
    }
    model_.faces.push_back(std::move(source));
  }

  std::optional<std::array<double, 3>> face_colour(const TopoDS_Face& face) const {
    Quantity_Color colour;
    if (colours_.IsNull()) return std::nullopt;
    if (colours_->GetColor(face.Located(TopLoc_Location()), XCAFDoc_ColorSurf, colour) ||
        colours_->GetColor(face.Located(TopLoc_Location()), XCAFDoc_ColorGen, colour)) {
      return to_srgb(colour);
    }
    return colour_;
  }

  SourceModel& model_;
  const Origins& origins_;
  Handle(XCAFDoc_ColorTool) colours_;
  std::string instance_;
  std::optional<std::array<double, 3>> colour_;
  TopTools_MapOfShape seen_;
  int loose_group_ = -1;
};

/// Walks the products of a document: every instance placed.
class ProductWalk {
 public:
  ProductWalk(const Handle(TDocStd_Document)& document, FaceCollector& faces)
      : shapes_(XCAFDoc_DocumentTool::ShapeTool(document->Main())),
        colours_(XCAFDoc_DocumentTool::ColorTool(document->Main())),
        faces_(faces) {}

  void walk() {
    TDF_LabelSequence roots;
    shapes_->GetFreeShapes(roots);
    for (const TDF_Label& root : roots) visit(root, TopLoc_Location(), label_name(root), std::nullopt, 0);
  }

 private:
  /// Assemblies nested deeper than this are not parts; a cycle would never end.
  static constexpr int deepest = 64;
  /// More placed instances than this are an attack, not a part to lay on.
  static constexpr int most_instances = 100000;

  void visit(const TDF_Label& label, const TopLoc_Location& placed, const std::string& path,
             std::optional<std::array<double, 3>> colour, int depth) {
    if (depth > deepest || ++instances_ > most_instances) {
      throw Error(
          ErrorCode::resource_limit, path,
          "the assembly is nested too deep or has too many instances; export only the part to lay on");
    }
    if (const auto own = colour_of(label)) colour = own;
    if (!XCAFDoc_ShapeTool::IsAssembly(label)) {
      TopoDS_Shape shape;
      if (XCAFDoc_ShapeTool::GetShape(label, shape)) faces_.add(shape.Moved(placed), path, colour);
      return;
    }
    TDF_LabelSequence components;
    XCAFDoc_ShapeTool::GetComponents(label, components);
    for (const TDF_Label& component : components) {
      TDF_Label product;
      if (!XCAFDoc_ShapeTool::GetReferredShape(component, product)) continue;
      std::string name = label_name(component);
      if (name.empty() || name.starts_with("=>")) name = label_name(product);
      visit(product, placed * XCAFDoc_ShapeTool::GetLocation(component),
            path.empty() ? name : path + "/" + name, colour, depth + 1);
    }
  }

  std::optional<std::array<double, 3>> colour_of(const TDF_Label& label) const {
    Quantity_Color colour;
    if (colours_->GetColor(label, XCAFDoc_ColorSurf, colour) ||
        colours_->GetColor(label, XCAFDoc_ColorGen, colour)) {
      return to_srgb(colour);
    }
    return std::nullopt;
  }

  Handle(XCAFDoc_ShapeTool) shapes_;
  Handle(XCAFDoc_ColorTool) colours_;
  FaceCollector& faces_;
  int instances_ = 0;
};

[[noreturn]] void refuse_without_faces(const StepText& text, const std::string& where) {
  if (!text.external_files.empty()) {
    std::string names;
    for (std::size_t i = 0; i < text.external_files.size() && i < 3; ++i) {
      names += (i ? ", " : "") + std::string(text.external_files[i]);
    }
    if (text.external_files.size() > 3)
      names += " and " + std::to_string(text.external_files.size() - 3) + " more";
    refuse(where, "is an assembly whose parts are in other files (" + names +
                      "), with no faces of its own; export it as one file, or give one of those");
  }
  refuse(where, "has no faces to lay on, only " + describe_contents(text) +
                    "; export the part as surfaces or solids (B-rep)");
}

void choose_units(const Handle(StepData_StepModel)& model, const std::string& unit_override,
                  SourceModel& result) {
  const LengthUnits units = length_units(model);
  if (!units.names.empty()) {
    result.declared_unit = units.names.front();
    result.unit_scale_to_mm = units.millimetres.front();
  }
  if (!unit_override.empty()) {
    result.unit_scale_to_mm = *millimetres_in(unit_override);
    replace_length_units(model, result.unit_scale_to_mm);
    return;
  }
  if (units.names.empty()) {
    result.warnings.push_back(
        "the file declares no length unit: millimetres assumed; give the unit of its numbers with --unit if "
        "that is wrong");
  } else if (units.names.size() > 1) {
    std::string list;
    for (const std::string& name : units.names) list += (list.empty() ? "" : ", ") + name;
    result.warnings.push_back("the file uses several length units (" + list +
                              "); each part was read in its own");
  }
}

/// Without a declared unit there is none to replace: the placed faces are scaled instead.
void scale_faces(std::vector<SourceFace>& faces, double factor) {
  if (factor == 1) return;
  TopoDS_Compound all;
  BRep_Builder builder;
  builder.MakeCompound(all);
  for (const SourceFace& source : faces) builder.Add(all, source.face);
  gp_Trsf scaling;
  scaling.SetScale(gp_Pnt(0, 0, 0), factor);
  BRepBuilderAPI_Transform scaled(all, scaling, Standard_True);
  for (SourceFace& source : faces) source.face = TopoDS::Face(scaled.ModifiedShape(source.face));
}

Handle(TDocStd_Document) transfer_document(STEPCAFControl_Reader& reader, const std::string& where) {
  // A document of its own: without an application no resource files are looked for.
  Handle(TDocStd_Document) document = new TDocStd_Document("BinXCAF");
  XCAFDoc_DocumentTool::Set(document->Main(), Standard_False);
  if (!reader.Transfer(document))
    refuse(
        where,
        "has nothing that OpenCASCADE can turn into shapes; export the part as surfaces or solids (B-rep)");
  return document;
}

int count_faces(const TopoDS_Shape& shape) {
  int n = 0;
  if (!shape.IsNull()) {
    for (TopExp_Explorer face(shape, TopAbs_FACE); face.More(); face.Next()) ++n;
  }
  return n;
}

}  // namespace

std::optional<double> millimetres_in(const std::string& unit) {
  if (unit == "mm") return 1.0;
  if (unit == "cm") return 10.0;
  if (unit == "m") return 1000.0;
  if (unit == "in") return 25.4;
  if (unit == "ft") return 304.8;
  return std::nullopt;
}

SourceModel collect_faces(const std::string& bytes, const StepText& text, const std::string& where,
                          const std::string& unit_override) {
  STEPControl_Controller::Init();
  Interface_Static::SetCVal("xstep.cascade.unit", "MM");
  Interface_Static::SetIVal("read.surfacecurve.mode", 0);
  STEPCAFControl_Reader reader;
  reader.SetNameMode(true);
  reader.SetColorMode(true);
  reader.SetLayerMode(false);
  reader.SetPropsMode(false);
  reader.SetSHUOMode(false);
  reader.SetGDTMode(false);
  reader.SetMatMode(false);
  reader.SetViewMode(false);

  std::string_view body(bytes);
  if (body.starts_with("\xef\xbb\xbf")) body.remove_prefix(3);
  MemoryBuffer buffer(body);
  std::istream stream(&buffer);
  const IFSelect_ReturnStatus status = reader.ChangeReader().ReadStream("part.step", stream);
  if (status != IFSelect_RetDone) {
    refuse(where, "cannot be read by OpenCASCADE (" + status_text(status) + ")" +
                      first_line_of_broken_references(text) + "; export it again");
  }
  const Handle(XSControl_WorkSession) session = reader.Reader().WS();
  const Handle(StepData_StepModel) model = Handle(StepData_StepModel)::DownCast(session->Model());
  if (reader.NbRootsForTransfer() == 0) refuse_without_faces(text, where);

  SourceModel result;
  choose_units(model, unit_override, result);
  const Handle(TDocStd_Document) document = transfer_document(reader, where);
  const Origins origins = find_origins(session, model);
  const Handle(XCAFDoc_ColorTool) colours = XCAFDoc_DocumentTool::ColorTool(document->Main());
  TDF_LabelSequence all_colours;
  colours->GetColors(all_colours);
  FaceCollector collector(result, origins, all_colours.IsEmpty() ? Handle(XCAFDoc_ColorTool)() : colours);
  ProductWalk(document, collector).walk();
  const TopoDS_Shape plain = reader.Reader().OneShape();
  if (static_cast<int>(result.faces.size()) < count_faces(plain) &&
      text.count("NEXT_ASSEMBLY_USAGE_OCCURRENCE") == 0) {
    // Shapes that hang on no product are not in the document.
    result.faces.clear();
    result.groups = result.solids = result.shells = 0;
    collector.add(plain, "", std::nullopt);
  }
  if (result.faces.empty()) refuse_without_faces(text, where);
  if (!text.external_files.empty()) {
    result.warnings.push_back("parts in other files are not read (" +
                              std::string(text.external_files.front()) +
                              (text.external_files.size() > 1 ? ", ..." : "") + ")");
  }
  if (!unit_override.empty() && result.declared_unit.empty())
    scale_faces(result.faces, result.unit_scale_to_mm);
  return result;
}

}  // namespace afptraj::step
