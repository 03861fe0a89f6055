#include <algorithm>
#include <cmath>

#include <tbb/parallel_for.h>

#include "analysis/chord_index.h"
#include "analysis/judge_lines.h"

namespace afptraj {
namespace {

constexpr double at_end_mm = 0.02;  // chords that meet at a corner lie this far off their curves

double longest_chord(const std::vector<CourseLine>& lines) {
  double longest = 0;
  for (const CourseLine& line : lines)
    for (std::size_t i = 0; i < line.chord_count(); ++i)
      longest = std::max(longest, (line.points[i + 1] - line.points[i]).norm());
  return longest;
}

bool near_end(const CourseLine& line, const Vec3& p) {
  return !line.closed() &&
         ((line.points.front() - p).norm() < at_end_mm || (line.points.back() - p).norm() < at_end_mm);
}

bool neighbours(const CourseLine& line, std::size_t i, std::size_t j) {
  const std::size_t lo = std::min(i, j), hi = std::max(i, j);
  return hi - lo <= 1 || (line.closed() && lo == 0 && hi + 1 == line.chord_count());
}

/// Where two chords cross, seen along their normals, if they lie within `height_mm` there.
std::optional<Vec3> crossing(const CourseLine& A, std::size_t i, const CourseLine& B, std::size_t j, double height_mm) {
  if (A.normals[i].dot(B.normals[j]) < 0.5) return std::nullopt;
  const Vec3 n = (A.normals[i] + B.normals[j]).normalized();
  const Vec3 a = A.points[i + 1] - A.points[i], b = B.points[j + 1] - B.points[j], r = B.points[j] - A.points[i];
  const double area = n.dot(a.cross(b));
  if (std::abs(area) <= 1e-12 * a.norm() * b.norm()) return std::nullopt;
  const double x = n.dot(r.cross(b)) / area, y = n.dot(r.cross(a)) / area;
  if (x < 0 || x > 1 || y < 0 || y > 1) return std::nullopt;
  const Vec3 on_a = A.points[i] + x * a, on_b = B.points[j] + y * b;
  if (std::abs((on_a - on_b).dot(n)) > height_mm) return std::nullopt;
  if (near_end(A, on_a) && near_end(B, on_b)) return std::nullopt;
  return on_a;
}

}  // namespace

std::vector<CourseCrossing> find_crossings(const std::vector<CourseLine>& lines, const ChordIndex& index,
                                           double band_width_mm) {
  const double height = std::min(0.2 * band_width_mm, 0.5 * longest_chord(lines));
  std::vector<std::vector<CourseCrossing>> found(lines.size());
  tbb::parallel_for(std::size_t{0}, lines.size(), [&](std::size_t l) {
    const CourseLine& A = lines[l];
    if (A.off_skin) return;
    for (std::size_t i = 0; i < A.chord_count(); ++i) {
      const Vec3 lo = A.points[i].cwiseMin(A.points[i + 1]).array() - height;
      const Vec3 hi = A.points[i].cwiseMax(A.points[i + 1]).array() + height;
      index.visit_box(lo, hi, [&](int m, std::size_t j) {
        const auto other = static_cast<std::size_t>(m);
        const CourseLine& B = lines[other];
        if (B.off_skin || other < l || (other == l && (j < i || neighbours(A, i, j)))) return;
        if (const auto where = crossing(A, i, B, j, height)) found[l].push_back({A.course, B.course, *where});
      });
    }
  });
  std::vector<CourseCrossing> out;
  for (auto& of_line : found) out.insert(out.end(), of_line.begin(), of_line.end());
  return out;
}

}  // namespace afptraj
