#pragma once

// Private to io/step: what its files share about OpenCASCADE.

#include <Standard_Failure.hxx>
#include <Standard_OutOfMemory.hxx>
#include <gp_Dir.hxx>
#include <gp_Pnt.hxx>
#include <gp_Pnt2d.hxx>
#include <gp_Vec.hxx>
#include <new>
#include <string>
#include <utility>

#include "geometry/error.h"
#include "geometry/types.h"

namespace afptraj::step {

inline Vec3 to_vec3(const gp_Pnt& p) { return {p.X(), p.Y(), p.Z()}; }
inline Vec3 to_vec3(const gp_Vec& v) { return {v.X(), v.Y(), v.Z()}; }
inline Vec3 to_vec3(const gp_Dir& d) { return {d.X(), d.Y(), d.Z()}; }
inline Uv to_uv(const gp_Pnt2d& p) { return {p.X(), p.Y()}; }

/// The one wall for OpenCASCADE's exceptions, which do not derive from std::exception: `work` is
/// called, and what it throws becomes Error(code, where) or std::bad_alloc.
template <class Work>
auto occt_guard(ErrorCode code, const std::string& where, const std::string& doing, Work&& work) {
  try {
    return std::forward<Work>(work)();
  } catch (const Standard_OutOfMemory&) {
    throw std::bad_alloc();
  } catch (const Standard_Failure& failure) {
    const char* text = failure.GetMessageString();
    throw Error(code, where,
                "OpenCASCADE failed while " + doing + " (" + failure.DynamicType()->Name() +
                    (text && *text ? std::string(": ") + text : "") + "); export the file again");
  }
}

/// While it lives, OpenCASCADE's messages and what anybody writes to std::cout or std::cerr go
/// nowhere. OpenCASCADE writes its chatter there, and afptraj's stdout is for data.
class QuietOcct {
 public:
  QuietOcct();
  ~QuietOcct();
  QuietOcct(const QuietOcct&) = delete;
  QuietOcct& operator=(const QuietOcct&) = delete;

 private:
  std::streambuf* cout_;
  std::streambuf* cerr_;
};

}  // namespace afptraj::step
