#include "analysis/course_index.h"

#include "boundary/clip.h"

namespace afptraj {

void CourseIndex::add(const Skin& skin, const Course& course) {
  for (const CourseSegment& segment : course.segments) {
    SurfaceCurve curve = curve_of(skin, segment);
    if (curve.empty()) continue;
    laid_.add(std::move(curve));
    empty_ = false;
  }
}

}  // namespace afptraj
