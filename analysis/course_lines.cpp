#include "analysis/course_lines.h"

#include <tbb/parallel_for.h>

#include "boundary/clip.h"

namespace afptraj {
namespace {

CourseLine line_of(const Skin& skin, int course, const CourseSegment& segment, bool off_skin) {
  CourseLine line;
  line.course = course;
  line.off_skin = off_skin;
  line.curve = curve_of(skin, segment);
  for (std::size_t p = 0; p < line.curve.pieces.size(); ++p)
    for (std::size_t i = 0; i + 1 < line.curve.pieces[p].size(); ++i) line.chords.push_back({p, i});
  for (const CourseSample& sample : segment.samples) {
    line.t.push_back(sample.s_mm);
    line.points.push_back(sample.position);
    line.normals.push_back(sample.normal);
  }
  return line;
}

}  // namespace

std::vector<CourseLine> course_lines(const Skin& skin, const Ply& ply) {
  struct Task {
    int course;
    const CourseSegment* segment;
    bool off_skin;
  };
  std::vector<Task> tasks;
  for (const bool off : {false, true})
    for (const Course& course : off ? ply.off_skin : ply.courses)
      for (const CourseSegment& segment : course.segments)
        if (segment.samples.size() > 1) tasks.push_back({course.number, &segment, off});
  std::vector<CourseLine> lines(tasks.size());
  tbb::parallel_for(std::size_t{0}, tasks.size(), [&](std::size_t i) {
    lines[i] = line_of(skin, tasks[i].course, *tasks[i].segment, tasks[i].off_skin);
  });
  return lines;
}

}  // namespace afptraj
