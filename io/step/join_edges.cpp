#include "io/step/join_edges.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "io/step/match_edges.h"
#include "io/step/orient_faces.h"

namespace afptraj::step {
namespace {

/// Where a coedge stands. Indices, because cutting a coedge moves those after it.
struct Place {
  int face, loop, coedge;
};

Coedge& at(Part& part, const Place& p) {
  return part.faces[static_cast<std::size_t>(p.face)]
      .loops[static_cast<std::size_t>(p.loop)]
      .coedges[static_cast<std::size_t>(p.coedge)];
}
const Surface& surface_at(const Part& part, const Place& p) {
  return part.faces[static_cast<std::size_t>(p.face)].surface;
}
SpaceCurve space_curve(Part& part, const Place& p) { return {&surface_at(part, p), &at(part, p).pcurve}; }

std::vector<std::vector<Place>> uses_of_edges(const Part& part) {
  std::vector<std::vector<Place>> uses(part.edges.size());
  for (std::size_t f = 0; f < part.faces.size(); ++f) {
    for (std::size_t l = 0; l < part.faces[f].loops.size(); ++l) {
      const auto& coedges = part.faces[f].loops[l].coedges;
      for (std::size_t c = 0; c < coedges.size(); ++c) {
        uses[static_cast<std::size_t>(coedges[c].edge)].push_back(
            {static_cast<int>(f), static_cast<int>(l), static_cast<int>(c)});
      }
    }
  }
  return uses;
}

bool is_straight(const BSplineCurve2& curve) { return curve.degree == 1 && curve.poles.size() == 2; }

/// Replaces the pcurve of one use by itself in the parametrisation of the other; straight pcurves
/// stay as they are if they can. `opposite`: its parameter ran the other way.
void reparametrise(Part& part, Place a, Place b, bool opposite) {
  if (is_straight(at(part, b).pcurve) && !is_straight(at(part, a).pcurve)) std::swap(a, b);
  at(part, b).pcurve = in_parameters_of(space_curve(part, a), space_curve(part, b), opposite);
  if (opposite) at(part, b).reversed = !at(part, b).reversed;
}

bool same_domain(const BSplineCurve2& a, const BSplineCurve2& b) {
  return a.first() == b.first() && a.last() == b.last();
}

/// Puts both uses of every shared edge in one parametrisation; notes the gaps as tolerances.
double settle_shared_edges(Part& part) {
  // 1e-7 mm is OpenCASCADE's own idea of equal points.
  constexpr double good_mm = 1e-7;
  double greatest = 0;
  for (std::size_t e = 0; e < part.edges.size(); ++e)
    part.edges[e].tolerance_mm = std::max(part.edges[e].tolerance_mm, 0.0);
  const auto uses = uses_of_edges(part);
  for (std::size_t e = 0; e < uses.size(); ++e) {
    if (uses[e].size() != 2 || part.edges[e].degenerate) continue;
    const Place a = uses[e][0], b = uses[e][1];
    const auto gap = [&] {
      return same_domain(at(part, a).pcurve, at(part, b).pcurve)
                 ? greatest_gap(space_curve(part, a), space_curve(part, b)).distance
                 : 1e300;
    };
    double distance = gap();
    if (distance > good_mm) {
      const Coedge before_a = at(part, a), before_b = at(part, b);
      reparametrise(part, a, b, false);
      if (const double better = gap(); better < distance) {
        distance = better;
      } else {
        at(part, a) = before_a, at(part, b) = before_b;
      }
    }
    part.edges[e].tolerance_mm = 1.1 * distance + 1e-10;
    greatest = std::max(greatest, distance);
  }
  return greatest;
}

/// A free edge with what the search needs.
struct FreeEdge {
  Place place;
  SampledCurve samples;
  const Vec3& start() const { return samples.points.front(); }
  const Vec3& end() const { return samples.points.back(); }
};

class Joiner {
 public:
  Joiner(Part& part, const std::vector<int>& bodies) : part_(part), bodies_(bodies) {}

  /// The tolerance that is used when none is asked for.
  double automatic_tolerance() const {
    Vec3 lo = Vec3::Constant(1e300), hi = Vec3::Constant(-1e300);
    for (const Face& face : part_.faces) {
      for (const Loop& loop : face.loops) {
        for (const Coedge& coedge : loop.coedges) {
          const SampledCurve samples = sample_curve({&face.surface, &coedge.pcurve}, 8);
          lo = lo.cwiseMin(samples.lo), hi = hi.cwiseMax(samples.hi);
        }
      }
    }
    return std::min(1e-4 * (hi - lo).norm(), 0.1);
  }

  /// Joins within the tolerance; returns the edges that became shared.
  std::vector<int> join(double tolerance) {
    tolerance_ = tolerance;
    list_free_edges();
    if (free_.size() < 2) return {};
    if (cut_at_ends()) list_free_edges();
    return pair_up();
  }

  double greatest_gap_mm() const { return greatest_gap_; }
  int crowded() const { return crowded_; }

 private:
  void list_free_edges() {
    free_.clear();
    const auto uses = uses_of_edges(part_);
    for (std::size_t e = 0; e < uses.size(); ++e) {
      if (uses[e].size() != 1 || part_.edges[e].degenerate) continue;
      FreeEdge edge{uses[e][0], sample_curve(space_curve(part_, uses[e][0]))};
      if (edge.samples.length() > 1e-6) free_.push_back(std::move(edge));
    }
    std::sort(free_.begin(), free_.end(),
              [](const FreeEdge& a, const FreeEdge& b) { return a.samples.lo.x() < b.samples.lo.x(); });
  }

  /// Calls visit(i, j), i != j, for edges whose boxes come within the tolerance, in both orders.
  template <class Visit>
  void for_near_pairs(Visit visit) const {
    for (std::size_t i = 0; i < free_.size(); ++i) {
      for (std::size_t j = i + 1; j < free_.size(); ++j) {
        const SampledCurve &a = free_[i].samples, &b = free_[j].samples;
        const double slack = tolerance_ + 0.02 * std::max(a.length(), b.length());
        if (b.lo.x() > a.hi.x() + tolerance_ + 0.02 * longest_) break;
        const bool apart = ((a.lo - b.hi).array() > slack).any() || ((b.lo - a.hi).array() > slack).any();
        if (apart || !may_join(free_[i], free_[j])) continue;
        visit(i, j);
        visit(j, i);
      }
    }
  }

  bool may_join(const FreeEdge& a, const FreeEdge& b) const {
    return bodies_[static_cast<std::size_t>(a.place.face)] == bodies_[static_cast<std::size_t>(b.place.face)];
  }

  double tolerance_for(const FreeEdge& a, const FreeEdge& b) const {
    return std::min(tolerance_, 0.05 * std::min(a.samples.length(), b.samples.length()));
  }

  /// Distance of `p` from an edge, and the parameter of the nearest point.
  double distance(const FreeEdge& edge, const Vec3& p, double& t) {
    const SpaceCurve curve = space_curve(part_, edge.place);
    t = std::clamp(nearest_parameter(curve, edge.samples, p), curve.first(), curve.last());
    return (curve.point(t) - p).norm();
  }

  /// Cuts edges where the end of another one lies inside of them and that one goes on along them.
  bool cut_at_ends() {
    longest_ = 0;
    for (const FreeEdge& edge : free_) longest_ = std::max(longest_, edge.samples.length());
    std::vector<std::vector<double>> cuts(free_.size());
    for_near_pairs([&](std::size_t i, std::size_t j) { find_cuts(free_[i], free_[j], cuts[i]); });
    std::vector<std::pair<Place, std::vector<double>>> work;
    for (std::size_t i = 0; i < free_.size(); ++i) {
      if (!cuts[i].empty()) work.push_back({free_[i].place, std::move(cuts[i])});
    }
    // From the back of each loop, so that the places still to come stay right.
    std::sort(work.begin(), work.end(),
              [](const auto& a, const auto& b) { return a.first.coedge > b.first.coedge; });
    for (auto& [place, ts] : work) cut(place, std::move(ts));
    return !work.empty();
  }

  void find_cuts(const FreeEdge& edge, const FreeEdge& other, std::vector<double>& cuts) {
    const double tolerance = tolerance_for(edge, other);
    const double clear = std::max(20 * tolerance, 1e-6 * edge.samples.length());
    for (const bool at_start : {true, false}) {
      const Vec3& p = at_start ? other.start() : other.end();
      if ((p - edge.start()).norm() < clear || (p - edge.end()).norm() < clear) continue;
      double t = 0, unused = 0;
      if (distance(edge, p, t) > tolerance) continue;
      const auto& points = other.samples.points;
      const std::size_t n = points.size() - 1;
      int along = 0;
      for (const std::size_t k : {n / 16, n / 8, n / 4})
        along += distance(edge, points[at_start ? k : n - k], unused) <= tolerance;
      if (along == 0) continue;
      cuts.push_back(t);
    }
  }

  void cut(const Place& place, std::vector<double> ts) {
    Loop& loop =
        part_.faces[static_cast<std::size_t>(place.face)].loops[static_cast<std::size_t>(place.loop)];
    const Coedge whole = loop.coedges[static_cast<std::size_t>(place.coedge)];
    const double least = 1e-6 * (whole.pcurve.last() - whole.pcurve.first());
    std::sort(ts.begin(), ts.end());
    std::vector<Coedge> pieces = {whole};
    for (const double t : ts) {
      Coedge& rest = pieces.back();
      if (t < rest.pcurve.first() + least || t > rest.pcurve.last() - least) continue;
      auto [left, right] = split_curve(rest.pcurve, t);
      rest.pcurve = std::move(left);
      pieces.push_back({std::move(right), whole.reversed, static_cast<int>(part_.edges.size())});
      part_.edges.push_back(part_.edges[static_cast<std::size_t>(whole.edge)]);
    }
    if (whole.reversed) std::reverse(pieces.begin(), pieces.end());
    const auto position = loop.coedges.begin() + place.coedge;
    const auto after = loop.coedges.erase(position);
    loop.coedges.insert(after, pieces.begin(), pieces.end());
  }

  struct Pair {
    std::size_t a, b;
    bool opposite;
    double distance;
    double cost;  ///< distance in tolerances, and the turn of the normal
  };

  std::vector<int> pair_up() {
    longest_ = 0;
    for (const FreeEdge& edge : free_) longest_ = std::max(longest_, edge.samples.length());
    std::vector<Pair> pairs;
    for_near_pairs([&](std::size_t i, std::size_t j) {
      if (i < j) consider(i, j, pairs);
    });
    std::vector<int> candidates(free_.size(), 0);
    for (const Pair& pair : pairs) ++candidates[pair.a], ++candidates[pair.b];
    crowded_ =
        static_cast<int>(std::count_if(candidates.begin(), candidates.end(), [](int n) { return n > 1; }));
    std::stable_sort(pairs.begin(), pairs.end(),
                     [](const Pair& a, const Pair& b) { return a.cost < b.cost; });
    std::vector<bool> taken(free_.size(), false);
    std::vector<int> joined;
    for (const Pair& pair : pairs) {
      if (taken[pair.a] || taken[pair.b]) continue;
      taken[pair.a] = taken[pair.b] = true;
      joined.push_back(unite(pair));
    }
    return joined;
  }

  void consider(std::size_t i, std::size_t j, std::vector<Pair>& pairs) {
    const FreeEdge &a = free_[i], &b = free_[j];
    const double tolerance = tolerance_for(a, b);
    const bool along = (a.start() - b.start()).norm() <= tolerance && (a.end() - b.end()).norm() <= tolerance;
    const bool against =
        (a.start() - b.end()).norm() <= tolerance && (a.end() - b.start()).norm() <= tolerance;
    if (!along && !against) return;
    double worst = 0, t = 0, quarter = 0;
    const auto& points = a.samples.points;
    for (std::size_t k = 2; k + 1 < points.size(); k += 2) {
      worst = std::max(worst, distance(b, points[k], t));
      if (worst > tolerance) return;
      if (k == points.size() / 4) quarter = t;
    }
    // A closed edge starts where it ends: its quarter point tells the sense.
    const double first = b.samples.t.front(), last = b.samples.t.back();
    const bool opposite = along && against ? quarter - first > last - quarter : against;
    worst = std::max({worst, (a.start() - (opposite ? b.end() : b.start())).norm(),
                      (a.end() - (opposite ? b.start() : b.end())).norm()});
    pairs.push_back({i, j, opposite, worst, worst / tolerance + turn(a, b)});
  }

  /// How much the surface turns from one face to the other: 0 smooth, 1 folded back, by the
  /// inward directions at the middle of the edge.
  double turn(const FreeEdge& a, const FreeEdge& b) {
    const Vec3& middle = a.samples.points[a.samples.points.size() / 2];
    double t = 0;
    distance(b, middle, t);
    const Vec3 in_a = inward(a, a.samples.t[a.samples.t.size() / 2]), in_b = inward(b, t);
    return 0.5 * (1 + in_a.dot(in_b));
  }

  /// Unit direction in the surface, square to the edge, into the material.
  Vec3 inward(const FreeEdge& edge, double t) {
    const Coedge& coedge = at(part_, edge.place);
    const auto c = coedge.pcurve.derivatives(t);
    const SurfaceDerivatives d = surface_at(part_, edge.place).derivatives(c.c);
    const Vec3 tangent = (coedge.reversed ? -1 : 1) * (d.Su * c.d1.x() + d.Sv * c.d1.y());
    const Vec3 direction = d.Su.cross(d.Sv).cross(tangent);
    const double norm = direction.norm();
    return norm > 0 ? Vec3(direction / norm) : Vec3::Zero();
  }

  int unite(const Pair& pair) {
    const Place a = free_[pair.a].place, b = free_[pair.b].place;
    reparametrise(part_, a, b, pair.opposite);
    const int edge = std::min(at(part_, a).edge, at(part_, b).edge);
    at(part_, a).edge = at(part_, b).edge = edge;
    const double gap = greatest_gap(space_curve(part_, a), space_curve(part_, b)).distance;
    part_.edges[static_cast<std::size_t>(edge)].tolerance_mm = 1.1 * gap + 1e-10;
    greatest_gap_ = std::max(greatest_gap_, gap);
    return edge;
  }

  Part& part_;
  const std::vector<int>& bodies_;
  std::vector<FreeEdge> free_;
  double tolerance_ = 0, longest_ = 0, greatest_gap_ = 0;
  int crowded_ = 0;
};

/// Drops the numbers that joining left without a use.
void renumber_edges(Part& part) {
  std::vector<int> number(part.edges.size(), -1);
  std::vector<Edge> edges;
  for (Face& face : part.faces) {
    for (Loop& loop : face.loops) {
      for (Coedge& coedge : loop.coedges) {
        int& n = number[static_cast<std::size_t>(coedge.edge)];
        if (n < 0) {
          n = static_cast<int>(edges.size());
          edges.push_back(part.edges[static_cast<std::size_t>(coedge.edge)]);
        }
        coedge.edge = n;
      }
    }
  }
  part.edges = std::move(edges);
}

std::string short_number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", x);
  return text;
}

}  // namespace

void join_edges(StepModel& model, const std::vector<int>& bodies, double tolerance_mm) {
  model.greatest_edge_gap_mm = settle_shared_edges(model.part);
  if (tolerance_mm != 0) {
    Joiner joiner(model.part, bodies);
    const double tolerance = tolerance_mm > 0 ? tolerance_mm : joiner.automatic_tolerance();
    const std::vector<int> joined = joiner.join(tolerance);
    if (!joined.empty()) {
      model.sew_tolerance_mm = tolerance;
      model.sewn_edges = static_cast<int>(joined.size());
      model.greatest_sewn_gap_mm = joiner.greatest_gap_mm();
      model.greatest_edge_gap_mm = std::max(model.greatest_edge_gap_mm, model.greatest_sewn_gap_mm);
      const OrientResult oriented = orient_faces(model.part, joined);
      if (oriented.one_sided > 0)
        model.warnings.push_back("joined faces form a one-sided surface; their normals do not agree");
    }
    if (joiner.crowded() > 0) {
      model.warnings.push_back(std::to_string(joiner.crowded()) +
                               " free edges have several others within the sewing tolerance of " +
                               short_number(tolerance) + " mm; the smoothest were joined");
    }
  }
  renumber_edges(model.part);
  constexpr double noticeable_mm = 0.01;
  if (model.greatest_edge_gap_mm > noticeable_mm) {
    model.warnings.push_back("faces that share an edge lie up to " +
                             short_number(model.greatest_edge_gap_mm) + " mm apart there");
  }
}

}  // namespace afptraj::step
