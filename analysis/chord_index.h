#pragma once

#include <vector>

#include "analysis/course_lines.h"

namespace afptraj {

/// The chords of some lines, found by place: a tree of boxes over runs of neighbouring chords. Keeps
/// a reference to the lines.
class ChordIndex {
 public:
  explicit ChordIndex(const std::vector<CourseLine>& lines);

  /// The point of a chord that is nearest to what was asked.
  struct Hit {
    int line = -1;
    std::size_t chord = 0;
    double x = 0;  ///< along the chord, in [0, 1]
    double distance_mm = 0;
  };

  /// Calls visit(hit) for every chord within `reach_mm` of p of the lines that `use(line)` chooses.
  template <typename Use, typename Visit>
  void visit_near(const Vec3& p, double reach_mm, Use use, Visit visit) const {
    const double reach2 = reach_mm * reach_mm;
    walk([&](const Box& box) { return box.distance2(p) <= reach2; },
         [&](const Run& run) {
           if (!use(lines_[static_cast<std::size_t>(run.line)])) return;
           for (std::size_t c = run.begin; c < run.end; ++c) {
             const Hit hit = nearest_on(run.line, c, p);
             if (hit.distance_mm <= reach_mm) visit(hit);
           }
         });
  }

  /// Calls visit(line, chord) for every chord in a run whose box meets the box from lo to hi.
  template <typename Visit>
  void visit_box(const Vec3& lo, const Vec3& hi, Visit visit) const {
    walk([&](const Box& box) { return (box.lo.array() <= hi.array()).all() && (box.hi.array() >= lo.array()).all(); },
         [&](const Run& run) {
           for (std::size_t c = run.begin; c < run.end; ++c) visit(run.line, c);
         });
  }

  /// Every local minimum, along its line, of the distance from p to the chords, if it is within
  /// `reach_mm`; ends of lines count. Nearest first.
  template <typename Use>
  void minima(const Vec3& p, double reach_mm, Use use, std::vector<Hit>& out) const {
    out.clear();
    visit_near(p, reach_mm, use, [&](const Hit& hit) {
      if (is_minimum(hit, p)) out.push_back(hit);
    });
    sort_by_distance(out);
  }

 private:
  struct Box {
    Vec3 lo = Vec3::Constant(1e300), hi = Vec3::Constant(-1e300);
    double distance2(const Vec3& p) const { return (lo - p).cwiseMax(p - hi).cwiseMax(0.0).squaredNorm(); }
  };
  struct Run {
    Box box;
    int line;
    std::size_t begin, end;
  };
  /// A leaf holds the run `run`; the left child of a branch is the next node.
  struct Node {
    Box box;
    int right = -1, run = -1;
  };

  template <typename Meets, typename Visit>
  void walk(Meets meets, Visit visit) const {
    if (nodes_.empty()) return;
    int stack[96];
    int size = 0;
    stack[size++] = 0;
    while (size > 0) {
      const int at = stack[--size];
      const Node& node = nodes_[static_cast<std::size_t>(at)];
      if (!meets(node.box)) continue;
      if (node.run >= 0) {
        visit(runs_[static_cast<std::size_t>(node.run)]);
        continue;
      }
      stack[size++] = node.right;
      stack[size++] = at + 1;
    }
  }

  void build(std::vector<int>& runs, std::size_t begin, std::size_t end);
  Hit nearest_on(int line, std::size_t chord, const Vec3& p) const;
  bool is_minimum(const Hit& hit, const Vec3& p) const;
  static void sort_by_distance(std::vector<Hit>& hits);

  const std::vector<CourseLine>& lines_;
  std::vector<Run> runs_;
  std::vector<Node> nodes_;
};

}  // namespace afptraj
