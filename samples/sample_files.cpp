#include "sample_files.h"

#include <APIHeaderSection_MakeHeader.hxx>
#include <Interface_Static.hxx>
#include <STEPControl_Controller.hxx>
#include <STEPControl_Writer.hxx>
#include <TCollection_HAsciiString.hxx>
#include <cstdio>
#include <fstream>
#include <stdexcept>

namespace samples {

void write_part(const std::filesystem::path& file, const std::string& name, const TopoDS_Shape& shape) {
  STEPControl_Controller::Init();
  Interface_Static::SetCVal("write.step.schema", "AP214IS");
  Interface_Static::SetCVal("write.step.unit", "MM");
  Interface_Static::SetCVal("write.step.product.name", name.c_str());
  STEPControl_Writer writer;
  if (writer.Transfer(shape, STEPControl_AsIs) != IFSelect_RetDone)
    throw std::runtime_error(file.string() + ": the shape has no STEP form");
  APIHeaderSection_MakeHeader header(writer.Model());
  header.SetName(new TCollection_HAsciiString(name.c_str()));
  header.SetTimeStamp(new TCollection_HAsciiString("2024-01-01T00:00:00"));
  header.SetAuthorValue(1, new TCollection_HAsciiString("afptraj"));
  header.SetOrganizationValue(1, new TCollection_HAsciiString("afptraj"));
  if (writer.Write(file.string().c_str()) != IFSelect_RetDone)
    throw std::runtime_error(file.string() + ": cannot write");
}

void write_plies(const std::filesystem::path& file, const std::vector<PlyRow>& rows) {
  std::ofstream out(file, std::ios::binary);
  out << "ply,x,y,z,dx,dy,dz,start\n";
  for (const PlyRow& row : rows) {
    char line[256];
    std::snprintf(line, sizeof line, ",%.9f,%.9f,%.9f,%.9f,%.9f,%.9f,%s\n", row.position.X(),
                  row.position.Y(), row.position.Z(), row.direction.X(), row.direction.Y(), row.direction.Z(),
                  row.start ? "1" : "0");
    out << row.ply << line;
  }
  if (!out.flush()) throw std::runtime_error(file.string() + ": cannot write");
}

}  // namespace samples
