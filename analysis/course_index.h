#pragma once

#include <vector>

#include "boundary/ply.h"
#include "trajectory/laid_curves.h"

namespace afptraj {

/// The centre lines of some courses, found by place.
class CourseIndex {
 public:
  /// `use(course)` chooses among `courses`.
  template <typename Use>
  CourseIndex(const Skin& skin, const std::vector<Course>& courses, double cell_mm, Use use) : laid_(skin, cell_mm) {
    add(skin, courses, use);
  }
  template <typename Use>
  void add(const Skin& skin, const std::vector<Course>& courses, Use use) {
    for (const Course& course : courses)
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
