#include "step_faces.h"

#include <BRepBuilderAPI_Transform.hxx>
#include <BRep_Tool.hxx>
#include <Interface_InterfaceModel.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_PrinterOStream.hxx>
#include <STEPControl_Reader.hxx>
#include <TColStd_SequenceOfAsciiString.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <Transfer_TransientProcess.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>
#include <gp_Trsf.hxx>
#include <map>
#include <sstream>
#include <stdexcept>

namespace oracle {
namespace {

double unit_mm(std::string name) {
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  static const std::map<std::string, double> sizes = {
      {"mm", 1},     {"millimetre", 1}, {"millimeter", 1}, {"cm", 10},   {"centimetre", 10},
      {"m", 1000},   {"metre", 1000},   {"meter", 1000},   {"in", 25.4}, {"inch", 25.4},
      {"ft", 304.8}, {"foot", 304.8},   {"feet", 304.8}};
  const auto found = sizes.find(name);
  if (found == sizes.end()) throw std::runtime_error("unknown unit '" + name + "'");
  return found->second;
}

// What the coordinates have to be multiplied with so that the file is in `unit`.
double unit_factor(STEPControl_Reader& reader, const std::string& unit) {
  if (unit.empty()) return 1;
  TColStd_SequenceOfAsciiString lengths, angles, solid_angles;
  reader.FileUnits(lengths, angles, solid_angles);
  const double declared = lengths.IsEmpty() ? 1 : unit_mm(lengths.First().ToCString());
  return unit_mm(unit) / declared;
}

int entity_number(const STEPControl_Reader& reader, const TopoDS_Face& face) {
  const Handle(XSControl_TransferReader) transfer = reader.WS()->TransferReader();
  TopoDS_Shape bare = face;
  for (int attempt = 0; attempt < 2; ++attempt) {
    const Handle(Standard_Transient) entity = transfer->EntityFromShapeResult(bare, 1);
    if (!entity.IsNull()) {
      const Handle(TCollection_HAsciiString) label = reader.WS()->Model()->StringLabel(entity);
      return label.IsNull() ? 0 : std::atoi(label->ToCString() + 1);
    }
    bare.Location(TopLoc_Location());
  }
  return 0;
}

}  // namespace

std::vector<StepFace> read_step_faces(const std::string& path, const std::string& unit) {
  Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_PrinterOStream));
  STEPControl_Reader reader;
  Interface_Static::SetCVal("xstep.cascade.unit", "MM");
  if (reader.ReadFile(path.c_str()) != IFSelect_RetDone)
    throw std::runtime_error(path + ": not readable as STEP");
  reader.TransferRoots();
  TopoDS_Shape shape = reader.OneShape();
  if (shape.IsNull()) throw std::runtime_error(path + ": no shape");

  std::vector<StepFace> faces;
  for (TopExp_Explorer it(shape, TopAbs_FACE); it.More(); it.Next()) {
    const TopoDS_Face face = TopoDS::Face(it.Current());
    faces.push_back({static_cast<int>(faces.size()) + 1, entity_number(reader, face), face});
  }
  const double factor = unit_factor(reader, unit);
  if (factor == 1) return faces;
  gp_Trsf scale;
  scale.SetScale(gp_Pnt(0, 0, 0), factor);
  shape = BRepBuilderAPI_Transform(shape, scale, true).Shape();
  std::size_t i = 0;
  for (TopExp_Explorer it(shape, TopAbs_FACE); it.More(); it.Next())
    faces.at(i++).face = TopoDS::Face(it.Current());
  return faces;
}

std::vector<StepFace> choose_faces(const std::vector<StepFace>& faces, const std::string& list) {
  if (list == "all" || list.empty()) return faces;
  std::vector<StepFace> chosen;
  std::istringstream in(list);
  for (std::string item; std::getline(in, item, ',');) {
    const bool by_id = item.front() == '#';
    const std::size_t dash = item.find('-');
    const int first = std::stoi(item.substr(by_id ? 1 : 0));
    const int last = dash == std::string::npos ? first : std::stoi(item.substr(dash + 1));
    bool any = false;
    for (const StepFace& face : faces) {
      const int key = by_id ? face.step_id : face.number;
      if (key < first || key > last) continue;
      chosen.push_back(face);
      any = true;
    }
    if (!any) throw std::runtime_error("no face " + item);
  }
  return chosen;
}

}  // namespace oracle
