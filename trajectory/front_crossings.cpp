#include "trajectory/front_crossings.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <unordered_map>

namespace afptraj {
namespace {

constexpr double solved_mm = 1e-9;  // along the skin
constexpr double floor_mm =
    1e-6;  // rays metres long, on parts of tens of metres, repeat no better than some 1e-7
constexpr double accepted_mm = 1e-4;  // off it: faces that join within the tolerance of the import

/// A place on a front, seen in space.
struct Node {
  double t = 0;
  Vec3 position, normal;
};

/// Between two rays, or a part of it: round an edge or a tight bend a chord is split until its normals agree.
struct Chord {
  StrandPlace place;
  std::size_t i = 0;  ///< from ray i to i + 1
  Node a, b;
  Vec3 along() const { return b.position - a.position; }
};

bool agree(const Node& a, const Node& b) { return a.normal.dot(b.normal) >= 0.5; }

class ChordMaker {
 public:
  ChordMaker(const std::array<const Front*, 2>& fronts, int level) : level_(level) {
    for (int f = 0; f < 2; ++f) {
      if (!fronts[static_cast<std::size_t>(f)]) continue;
      const Front& front = *fronts[static_cast<std::size_t>(f)];
      for (std::size_t s = 0; s < front.strands().size(); ++s) {
        const auto& rays = front.strands()[s].rays;
        Node last = node(front, rays.front());
        for (std::size_t i = 0; i + 1 < rays.size(); ++i) {
          const Node next = node(front, rays[i + 1]);
          add(front, {{f, s}, i, last, next});
          last = next;
        }
      }
    }
  }
  std::vector<Chord> take() { return std::move(chords_); }

 private:
  static Node node(const Front& front, const Ray& ray) {
    const PathFrame frame = frame_of(front.skin(), ray.state);
    return {ray.t, frame.position, frame.normal};
  }

  void add(const Front& front, Chord chord) {
    constexpr double edge_mm = 1e-7;
    while (!agree(chord.a, chord.b)) {
      Node in = chord.a, out = chord.b;
      while ((out.position - in.position).norm() > edge_mm) {
        bool alive = false;
        const double t = 0.5 * (in.t + out.t);
        const Ray mid = front.shoot(front.strands()[chord.place.strand].source, t, level_, &alive);
        if (!alive || t == in.t || t == out.t) break;
        const Node at = node(front, mid);
        (agree(chord.a, at) ? in : out) = at;
      }
      if (in.t > chord.a.t) chords_.push_back({chord.place, chord.i, chord.a, in});
      if (out.t == chord.b.t) return;
      chord.a = out;
    }
    chords_.push_back(chord);
  }

  int level_;
  std::vector<Chord> chords_;
};

/// Where two chords pass over each other, seen along the normal: x on a, y on b.
bool pass_over(const Chord& A, const Chord& B, double& x, double& y) {
  constexpr double slack = 0.05;  // chords beside the vertex that the curves cross at
  const Vec3 na = (A.a.normal + A.b.normal).normalized(), nb = (B.a.normal + B.b.normal).normalized();
  if (na.dot(nb) <= 0.5) return false;
  const Vec3 n = (na + nb).normalized(), da = A.along(), db = B.along(), r = B.a.position - A.a.position;
  const double cross = n.dot(da.cross(db));
  if (std::abs(cross) <= 1e-12 * da.norm() * db.norm()) return false;
  x = n.dot(r.cross(db)) / cross;
  y = n.dot(r.cross(da)) / cross;
  if (x < -slack || x > 1 + slack || y < -slack || y > 1 + slack) return false;
  return std::abs((x * da - r - y * db).dot(n)) <= 0.5 * std::max(da.norm(), db.norm());
}

/// Indices of chords by the cells that their boxes touch.
class ChordHash {
 public:
  ChordHash(const std::vector<Chord>& chords, double cell) : cell_(cell) {
    for (std::size_t c = 0; c < chords.size(); ++c)
      for_each_cell(chords[c], [&](std::int64_t key) { cells_[key].push_back(c); });
  }
  template <typename Visit>
  void visit_pairs(const std::vector<Chord>& chords, Visit visit) const {
    std::vector<std::size_t> near;
    for (std::size_t c = 0; c < chords.size(); ++c) {
      near.clear();
      for_each_cell(chords[c], [&](std::int64_t key) {
        for (std::size_t other : cells_.at(key))
          if (other > c) near.push_back(other);
      });
      std::sort(near.begin(), near.end());
      near.erase(std::unique(near.begin(), near.end()), near.end());
      for (std::size_t other : near) visit(c, other);
    }
  }

 private:
  template <typename Body>
  void for_each_cell(const Chord& chord, Body body) const {
    const Vec3 &a = chord.a.position, &b = chord.b.position;
    const double pad = 0.5 * (b - a).norm();
    const auto cell = [&](double x) { return static_cast<std::int64_t>(std::floor(x / cell_)); };
    const Vec3 lo = a.cwiseMin(b).array() - pad, hi = a.cwiseMax(b).array() + pad;
    for (auto i = cell(lo.x()); i <= cell(hi.x()); ++i)
      for (auto j = cell(lo.y()); j <= cell(hi.y()); ++j)
        for (auto k = cell(lo.z()); k <= cell(hi.z()); ++k)
          body((i & 0x1fffff) | ((j & 0x1fffff) << 21) | ((k & 0x1fffff) << 42));
  }
  double cell_;
  std::unordered_map<std::int64_t, std::vector<std::size_t>> cells_;
};

class CrossingSolver {
 public:
  CrossingSolver(const std::array<const Front*, 2>& fronts, int level) : fronts_(fronts), level_(level) {}

  std::optional<FrontCrossing> solve(const StrandPlace& a, double ta, const StrandPlace& b, double tb) const {
    const StrandPlace place[2] = {a, b};
    double t[2] = {ta, tb};
    const double longest = 4 * front(a).options().sample_mm;
    FrontCrossing out;
    double last = std::numeric_limits<double>::infinity();
    for (int iteration = 0; iteration < 30; ++iteration) {
      PathFrame frame[2];
      Vec3 along[2];
      for (int k = 0; k < 2; ++k) {
        bool alive = false;
        out.ray[k] = front(place[k]).shoot(strand(place[k]).source, t[k], level_, &alive);
        if (!alive) return std::nullopt;
        frame[k] = frame_of(front(place[k]).skin(), out.ray[k].state);
        const double speed = front(place[k]).source(strand(place[k]).source).curve->at(t[k]).speed;
        const double y = out.ray[k].state.y;
        along[k] = front(place[k]).side() * std::copysign(std::max(std::abs(y), 1e-3), y) * speed *
                   frame[k].tangent.cross(frame[k].normal);
      }
      if (frame[0].normal.dot(frame[1].normal) < 0.5) return std::nullopt;
      const Vec3 miss = frame[1].position - frame[0].position;
      const Vec3 e1 = frame[0].tangent, e2 = frame[0].left();
      const Eigen::Vector2d r(miss.dot(e1), miss.dot(e2));
      const bool stands = r.norm() < floor_mm && r.norm() > 0.25 * last;
      last = r.norm();
      if (r.norm() < solved_mm || stands) {
        out.miss_mm = miss.norm();
        if (out.miss_mm > accepted_mm) return std::nullopt;
        out.place[0] = a;
        out.place[1] = b;
        return out;
      }
      Eigen::Matrix2d J;
      J << along[0].dot(e1), -along[1].dot(e1), along[0].dot(e2), -along[1].dot(e2);
      Eigen::Vector2d step = J.partialPivLu().solve(r);
      if (!step.allFinite()) return std::nullopt;
      const double biggest = step.cwiseAbs().maxCoeff();
      if (biggest > longest) step *= longest / biggest;
      for (int k = 0; k < 2; ++k) {
        t[k] += step[k];
        const auto& rays = strand(place[k]).rays;
        if (t[k] < rays.front().t - longest || t[k] > rays.back().t + longest) return std::nullopt;
        t[k] = std::clamp(t[k], rays.front().t, rays.back().t);
      }
      if (a == b && std::abs(t[0] - t[1]) < 1e-7) return std::nullopt;  // the curve with itself
    }
    return std::nullopt;
  }

  /// Where the Jacobi field vanishes between a ray with y > 0 and one with y <= 0.
  double focal(const StrandPlace& place, double good_t, double bad_t) const {
    for (int k = 0; k < 50 && std::abs(good_t - bad_t) > 1e-10; ++k) {
      bool alive = false;
      const double mid = 0.5 * (good_t + bad_t);
      const Ray ray = front(place).shoot(strand(place).source, mid, level_, &alive);
      (alive && ray.state.y > 0 ? good_t : bad_t) = mid;
    }
    return good_t;
  }

 private:
  const Front& front(const StrandPlace& p) const { return *fronts_[static_cast<std::size_t>(p.front)]; }
  const Strand& strand(const StrandPlace& p) const { return front(p).strands()[p.strand]; }
  const std::array<const Front*, 2>& fronts_;
  int level_;
};

/// Whether two chords follow each other over a link, on fronts that run forward: like neighbours within a
/// strand they meet at that point only, where Newton-Raphson has no hold (the curves are tangent there).
bool follow_over_link(const std::array<const Front*, 2>& fronts, const Chord& A, const Chord& B) {
  if (A.place.front != B.place.front || A.along().dot(B.along()) <= 0) return false;
  const auto& strands = fronts[static_cast<std::size_t>(A.place.front)]->strands();
  const Strand &a = strands[A.place.strand], &b = strands[B.place.strand];
  const auto forward = [](const Strand& s, std::size_t i) {
    return s.rays[i].state.y > 0.1 && s.rays[i + 1].state.y > 0.1;
  };
  if (!forward(a, A.i) || !forward(b, B.i)) return false;
  const auto links = [](const Strand& s, std::size_t i, const Strand& t, std::size_t j) {
    return i + 2 == s.rays.size() && j == 0 && s.end[1] == StrandEnd::linked &&
           t.end[0] == StrandEnd::linked && s.link[1] == t.link[0];
  };
  return links(a, A.i, b, B.i) || links(b, B.i, a, A.i);
}

/// Whether the crossing is the point at which two strands are joined.
bool at_link(const std::array<const Front*, 2>& fronts, const FrontCrossing& x) {
  if (x.place[0] == x.place[1] || x.place[0].front != x.place[1].front) {
    if (!(x.place[0] == x.place[1])) return false;
  }
  const auto& strands = fronts[static_cast<std::size_t>(x.place[0].front)]->strands();
  for (int e = 0; e < 2; ++e)
    for (int f = 0; f < 2; ++f) {
      const Strand& a = strands[x.place[0].strand];
      const Strand& b = strands[x.place[1].strand];
      if (a.end[e] != StrandEnd::linked || b.end[f] != StrandEnd::linked || a.link[e] != b.link[f]) continue;
      const double ta = e == 0 ? a.rays.front().t : a.rays.back().t;
      const double tb = f == 0 ? b.rays.front().t : b.rays.back().t;
      if (std::abs(x.ray[0].t - ta) < 1e-6 && std::abs(x.ray[1].t - tb) < 1e-6) return true;
    }
  return false;
}

}  // namespace

std::vector<FrontCrossing> front_crossings(const std::array<const Front*, 2>& fronts, int level) {
  const std::vector<Chord> chords = ChordMaker(fronts, level).take();
  if (chords.empty()) return {};
  const CrossingSolver solver(fronts, level);
  std::vector<FrontCrossing> out;
  const auto take = [&](std::optional<FrontCrossing> found) {
    if (!found || at_link(fronts, *found)) return;
    if (found->place[0] == found->place[1] && found->ray[0].t > found->ray[1].t)
      std::swap(found->ray[0], found->ray[1]);
    for (const FrontCrossing& known : out)
      if (known.place[0] == found->place[0] && known.place[1] == found->place[1] &&
          std::abs(known.ray[0].t - found->ray[0].t) < 1e-6 &&
          std::abs(known.ray[1].t - found->ray[1].t) < 1e-6)
        return;
    out.push_back(*found);
  };
  const auto t_at = [](const Chord& c, double x) {
    return c.a.t + std::clamp(x, 0.0, 1.0) * (c.b.t - c.a.t);
  };
  const double cell = 2 * (fronts[0] ? fronts[0] : fronts[1])->options().sample_mm;
  struct Seed {
    StrandPlace a, b;
    double ta, tb;
    std::optional<FrontCrossing> found;
  };
  std::vector<Seed> seeds;
  ChordHash(chords, cell).visit_pairs(chords, [&](std::size_t i, std::size_t j) {
    const Chord &A = chords[i], &B = chords[j];
    if (A.place == B.place && B.i <= A.i + 1) return;
    double x = 0, y = 0;
    if (pass_over(A, B, x, y) && !follow_over_link(fronts, A, B))
      seeds.push_back({A.place, B.place, t_at(A, x), t_at(B, y), std::nullopt});
  });
  tbb::parallel_for(std::size_t{0}, seeds.size(), [&](std::size_t i) {
    Seed& seed = seeds[i];
    seed.found = solver.solve(seed.a, seed.ta, seed.b, seed.tb);
  });
  for (const Seed& seed : seeds) take(seed.found);
  // A swallowtail narrower than the chords: x' = t^2 - c^2 crosses itself at t = +-sqrt(3) c.
  for (int f = 0; f < 2; ++f) {
    if (!fronts[static_cast<std::size_t>(f)]) continue;
    const auto& strands = fronts[static_cast<std::size_t>(f)]->strands();
    for (std::size_t s = 0; s < strands.size(); ++s) {
      const auto& rays = strands[s].rays;
      for (std::size_t i = 1; i < rays.size(); ++i) {
        if (rays[i].state.y > 0 || rays[i - 1].state.y <= 0) continue;
        std::size_t j = i;
        while (j + 1 < rays.size() && rays[j].state.y <= 0) ++j;
        if (rays[j].state.y <= 0) break;
        const StrandPlace place{f, s};
        const double c0 = solver.focal(place, rays[i - 1].t, rays[i].t),
                     c1 = solver.focal(place, rays[j].t, rays[j - 1].t);
        for (const double reach : {std::sqrt(3.0), 1.4, 2.2}) {
          const double half = 0.5 * (c1 - c0) * reach, mid = 0.5 * (c0 + c1);
          const std::size_t known = out.size();
          take(solver.solve(place, std::max(mid - half, rays.front().t), place,
                            std::min(mid + half, rays.back().t)));
          if (out.size() > known) break;
        }
      }
    }
  }
  return out;
}

}  // namespace afptraj
