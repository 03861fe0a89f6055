#include "io/step/orient_faces.h"

#include <algorithm>

#include "geometry/skin.h"

namespace afptraj::step {
namespace {

struct Use {
  int face;
  bool along;  ///< the loop runs along the edge, seen on the surface's own side
};

/// Uses of every edge.
std::vector<std::vector<Use>> uses_of_edges(const Part& part) {
  std::vector<std::vector<Use>> uses(part.edges.size());
  for (std::size_t f = 0; f < part.faces.size(); ++f) {
    for (const Loop& loop : part.faces[f].loops) {
      for (const Coedge& coedge : loop.coedges) {
        uses[static_cast<std::size_t>(coedge.edge)].push_back({static_cast<int>(f), !coedge.reversed});
      }
    }
  }
  return uses;
}

/// A connected group of faces with the turn that makes each agree with the first.
struct Group {
  std::vector<int> faces;
  std::vector<bool> turn;
  bool closed = true;
  bool has_joined = false;
  bool one_sided = false;
};

class Walker {
 public:
  Walker(const Part& part, const std::vector<int>& joined)
      : part_(part),
        uses_(uses_of_edges(part)),
        joined_(part.edges.size(), false),
        group_of_(part.faces.size(), -1),
        turn_(part.faces.size(), false) {
    for (const int edge : joined) joined_[static_cast<std::size_t>(edge)] = true;
  }

  std::vector<Group> groups() {
    std::vector<Group> all;
    for (std::size_t f = 0; f < part_.faces.size(); ++f) {
      if (group_of_[f] < 0) all.push_back(grow(static_cast<int>(f), static_cast<int>(all.size())));
    }
    return all;
  }

 private:
  Group grow(int seed, int number) {
    Group group;
    group.faces.push_back(seed);
    group_of_[static_cast<std::size_t>(seed)] = number;
    for (std::size_t i = 0; i < group.faces.size(); ++i) visit(group.faces[i], number, group);
    for (const int face : group.faces) group.turn.push_back(turn_[static_cast<std::size_t>(face)]);
    return group;
  }

  void visit(int face, int number, Group& group) {
    for (const Loop& loop : part_.faces[static_cast<std::size_t>(face)].loops) {
      for (const Coedge& coedge : loop.coedges) {
        const auto edge = static_cast<std::size_t>(coedge.edge);
        if (part_.edges[edge].degenerate) continue;
        if (uses_[edge].size() != 2) {
          group.closed = false;
          continue;
        }
        group.has_joined = group.has_joined || joined_[edge];
        const Use& a = uses_[edge][0];
        const Use& b = uses_[edge][1];
        if (a.face == b.face) continue;  // a seam
        meet(a.face == face ? a : b, a.face == face ? b : a, number, group);
      }
    }
  }

  void meet(const Use& here, const Use& there, int number, Group& group) {
    const auto from = static_cast<std::size_t>(here.face), to = static_cast<std::size_t>(there.face);
    const bool reversed_here = part_.faces[from].reversed != turn_[from];
    const bool opposite = (here.along != reversed_here) != (there.along != part_.faces[to].reversed);
    if (group_of_[to] < 0) {
      group_of_[to] = number;
      turn_[to] = !opposite;
      group.faces.push_back(there.face);
    } else if (turn_[to] == opposite) {
      group.one_sided = true;
    }
  }

  const Part& part_;
  std::vector<std::vector<Use>> uses_;
  std::vector<bool> joined_;
  std::vector<int> group_of_;
  std::vector<bool> turn_;
};

/// Three times the volume that the turned faces of a group enclose, by Gauss points.
double enclosed(const Part& part, const Group& group) {
  double sum = 0;
  for (std::size_t i = 0; i < group.faces.size(); ++i) {
    const Face& face = part.faces[static_cast<std::size_t>(group.faces[i])];
    const bool reversed = face.reversed != group.turn[i];
    for (const AreaSample& sample : area_samples(part, group.faces[i], TrimRegion(face), 400)) {
      const SurfaceDerivatives d = face.surface.derivatives(sample.at.uv);
      const Vec3 normal = d.Su.cross(d.Sv).normalized();
      sum += (reversed ? -1 : 1) * d.S.dot(normal) * sample.area_mm2;
    }
  }
  return sum;
}

}  // namespace

OrientResult orient_faces(Part& part, const std::vector<int>& joined) {
  OrientResult result;
  for (const Group& group : Walker(part, joined).groups()) {
    if (!group.has_joined) continue;
    if (group.one_sided) {
      ++result.one_sided;
      continue;
    }
    const auto turned = static_cast<std::size_t>(std::count(group.turn.begin(), group.turn.end(), true));
    const bool other_side = group.closed ? enclosed(part, group) < 0 : 2 * turned > group.faces.size();
    for (std::size_t i = 0; i < group.faces.size(); ++i) {
      if (group.turn[i] == other_side) continue;
      Face& face = part.faces[static_cast<std::size_t>(group.faces[i])];
      face.reversed = !face.reversed;
      ++result.turned;
    }
  }
  return result;
}

}  // namespace afptraj::step
