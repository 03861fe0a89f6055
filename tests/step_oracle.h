#pragma once

// OpenCASCADE's own reading of a STEP file, for tests: another path through the library than io/step takes.

#include <BRep_Tool.hxx>
#include <Geom_Surface.hxx>
#include <Interface_Static.hxx>
#include <STEPControl_Reader.hxx>
#include <StepData_StepModel.hxx>
#include <StepGeom_Surface.hxx>
#include <StepShape_Face.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <TransferBRep.hxx>
#include <Transfer_TransientProcess.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>
#include <filesystem>
#include <iostream>
#include <map>
#include <sstream>
#include <string>

namespace afptraj::test {

/// Sends what OpenCASCADE prints to std::cout nowhere while it lives.
class HushedCout {
 public:
  HushedCout() : kept_(std::cout.rdbuf(sink_.rdbuf())) {}
  ~HushedCout() { std::cout.rdbuf(kept_); }

 private:
  std::ostringstream sink_;
  std::streambuf* kept_;
};

struct OracleModel {
  TopoDS_Shape shape;
  std::map<int, TopoDS_Face> faces;  ///< by STEP id, as placed; an id with several instances is left out
};

inline OracleModel read_with_occt(const std::filesystem::path& path) {
  const HushedCout hushed;
  STEPControl_Reader reader;
  Interface_Static::SetCVal("xstep.cascade.unit", "MM");
  OracleModel model;
  if (reader.ReadFile(path.c_str()) != IFSelect_RetDone) return model;
  reader.TransferRoots();
  model.shape = reader.OneShape();
  const Handle(Transfer_TransientProcess) process = reader.WS()->TransferReader()->TransientProcess();
  const Handle(StepData_StepModel) step = reader.StepModel();
  std::map<const TopoDS_TShape*, int> ids;
  for (int i = 1; i <= process->NbMapped(); ++i) {
    const Handle(Standard_Transient) entity = process->Mapped(i);
    if (!entity->IsKind(STANDARD_TYPE(StepShape_Face)) && !entity->IsKind(STANDARD_TYPE(StepGeom_Surface)))
      continue;
    const TopoDS_Shape shape = TransferBRep::ShapeResult(process, entity);
    if (shape.IsNull() || shape.ShapeType() != TopAbs_FACE) continue;
    int& id = ids[shape.TShape().get()];
    if (id == 0 || entity->IsKind(STANDARD_TYPE(StepShape_Face))) id = step->IdentLabel(entity);
  }
  std::map<int, int> uses;
  for (TopExp_Explorer it(model.shape, TopAbs_FACE); it.More(); it.Next()) {
    const TopoDS_Face face = TopoDS::Face(it.Current());
    const auto id = ids.find(face.TShape().get());
    if (id == ids.end()) continue;
    if (++uses[id->second] > 1) {
      model.faces.erase(id->second);
    } else {
      model.faces.emplace(id->second, face);
    }
  }
  return model;
}

}  // namespace afptraj::test
