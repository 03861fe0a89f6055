#include "analysis/region_areas.h"

#include <algorithm>
#include <cmath>

namespace afptraj {
namespace {

// A stretch of boundary that is a graph y(x) over [x0, x1].
struct Branch {
  double x0, x1;
  bool second;  // which region
  int arc = 0;  // 0 line, +1 upper half of a circle, -1 lower half
  double a, b;  // line: y = a + b (x - x0); arc: centre
  double radius = 0;

  double y(double x) const {
    if (arc == 0) return a + b * (x - x0);
    const double t = x - a;
    return b + arc * std::sqrt(std::max(0.0, radius * radius - t * t));
  }
  double integral(double from, double to) const {
    if (arc == 0) return (to - from) * y((from + to) / 2);
    const auto F = [&](double x) {
      const double t = std::clamp((x - a) / radius, -1.0, 1.0);
      return radius * radius * (t * std::sqrt(1 - t * t) + std::asin(t)) / 2;
    };
    return b * (to - from) + arc * (F(to) - F(from));
  }
};

void add_line(const Vec2& p, const Vec2& q, bool second, std::vector<Branch>& out) {
  const Vec2 &l = p.x() <= q.x() ? p : q, &r = p.x() <= q.x() ? q : p;
  if (l.x() < r.x()) out.push_back({l.x(), r.x(), second, 0, l.y(), (r.y() - l.y()) / (r.x() - l.x()), 0});
}

// An arc from p to q, cut where the circle turns back.
void add_arc(const Vec2& p, const Vec2& q, const Vec2& centre, int turn, bool second,
             std::vector<Branch>& out) {
  const Vec2 &from = turn > 0 ? p : q, &to = turn > 0 ? q : p;  // anticlockwise
  const double radius = (p - centre).norm();
  const double start = std::atan2(from.y() - centre.y(), from.x() - centre.x());
  double end = std::atan2(to.y() - centre.y(), to.x() - centre.x());
  if (end < start - 1e-9) end += 2 * pi;
  if (end <= start) return add_line(p, q, second, out);
  double at = start, x = from.x();
  while (at < end) {
    const double next = std::min(end, (std::floor(at / pi + 1e-12) + 1) * pi);
    const double next_x = next == end ? to.x() : centre.x() + radius * std::cos(next);
    const int half = std::sin((at + next) / 2) > 0 ? 1 : -1;
    if (x != next_x)
      out.push_back({std::min(x, next_x), std::max(x, next_x), second, half, centre.x(), centre.y(), radius});
    at = next;
    x = next_x;
  }
}

void add_rings(const std::vector<ArcRing>& rings, bool second, std::vector<Branch>& out) {
  for (const ArcRing& ring : rings) {
    for (std::size_t i = 0; i < ring.pieces.size(); ++i) {
      const ArcRing::Piece& piece = ring.pieces[i];
      const Vec2& to = ring.pieces[(i + 1) % ring.pieces.size()].from;
      if (piece.turn == 0) {
        add_line(piece.from, to, second, out);
      } else {
        add_arc(piece.from, to, piece.centre, piece.turn, second, out);
      }
    }
  }
}

class Slabs {
 public:
  Slabs(double tolerance, RegionAreas& sum) : tolerance_(tolerance), sum_(sum) {}

  void add(double from, double to, const std::vector<const Branch*>& branches) {
    const double middle = (from + to) / 2;
    std::vector<std::pair<double, const Branch*>> order;
    for (const Branch* branch : branches) order.emplace_back(branch->y(middle), branch);
    std::sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    constexpr double narrowest = 1e-10;
    if (to - from > narrowest) {
      for (std::size_t i = 0; i + 1 < order.size(); ++i) {
        const Branch &low = *order[i].second, &high = *order[i + 1].second;
        if (low.y(from) <= high.y(from) + tolerance_ && low.y(to) <= high.y(to) + tolerance_) continue;
        add(from, middle, branches);
        add(middle, to, branches);
        return;
      }
    }
    bool in_first = false, in_second = false;
    double below = 0;
    for (std::size_t i = 0; i < order.size(); ++i) {
      const double up_to = order[i].second->integral(from, to);
      if (in_first && in_second) sum_.both += up_to - below;
      if (in_first && !in_second) sum_.only_first += up_to - below;
      if (!in_first && in_second) sum_.only_second += up_to - below;
      (order[i].second->second ? in_second : in_first) ^= true;
      below = up_to;
    }
  }

 private:
  double tolerance_;
  RegionAreas& sum_;
};

}  // namespace

RegionAreas region_areas(const std::vector<ArcRing>& first, const std::vector<ArcRing>& second,
                         double tolerance_mm) {
  std::vector<Branch> branches;
  add_rings(first, false, branches);
  add_rings(second, true, branches);
  std::sort(branches.begin(), branches.end(), [](const Branch& a, const Branch& b) { return a.x0 < b.x0; });
  std::vector<double> cuts;
  for (const Branch& branch : branches) cuts.insert(cuts.end(), {branch.x0, branch.x1});
  std::sort(cuts.begin(), cuts.end());
  cuts.erase(std::unique(cuts.begin(), cuts.end()), cuts.end());

  RegionAreas sum;
  Slabs slabs(tolerance_mm, sum);
  std::vector<const Branch*> active;
  std::size_t next = 0;
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    std::erase_if(active, [&](const Branch* branch) { return branch->x1 <= cuts[i]; });
    while (next < branches.size() && branches[next].x0 <= cuts[i]) active.push_back(&branches[next++]);
    slabs.add(cuts[i], cuts[i + 1], active);
  }
  return sum;
}

}  // namespace afptraj
