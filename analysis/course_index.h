#pragma once

#include <vector>

#include "boundary/ply.h"
#include "trajectory/laid_curves.h"

namespace afptraj {

/// The centre lines of some courses, found by place.
class CourseIndex {
 public:
  /// `use(course)` chooses the courses.
  template <typename Use>
  CourseIndex(const Skin& skin, const Ply& ply, double cell_mm, Use use) : laid_(skin, cell_mm) {
    for (const Course& course : ply.courses)
      if (use(course)) add(skin, course);
  }
  const LaidCurves& laid() const { return laid_; }
  bool empty() const { return empty_; }

 private:
  void add(const Skin& skin, const Course& course);
  LaidCurves laid_;
  bool empty_ = true;
};

}  // namespace afptraj
