#include "fill/axis_paths.h"

#include <algorithm>
#include <cmath>
#include <queue>

namespace afptraj {
namespace {

using Axis = DistanceDiagram::MedialAxis;

// The axis as a graph of edges with lengths.
struct Graph {
  explicit Graph(const Axis& axis) : axis(axis), at(axis.nodes.size()) {
    for (std::size_t e = 0; e < axis.edges.size(); ++e) {
      at[axis.edges[e].from].push_back(e);
      at[axis.edges[e].to].push_back(e);
      const std::vector<Vec2> points = chain(e, axis.edges[e].from);
      length.push_back(length_mm(Polyline{points, false}));
    }
  }
  std::size_t other(std::size_t edge, std::size_t node) const {
    return axis.edges[edge].from == node ? axis.edges[edge].to : axis.edges[edge].from;
  }
  std::vector<Vec2> chain(std::size_t edge, std::size_t from) const {
    const auto& e = axis.edges[edge];
    std::vector<Vec2> points{axis.nodes[e.from].point};
    points.insert(points.end(), e.between.begin(), e.between.end());
    points.push_back(axis.nodes[e.to].point);
    if (e.from != from) std::reverse(points.begin(), points.end());
    return points;
  }
  const Axis& axis;
  std::vector<std::vector<std::size_t>> at;
  std::vector<double> length;
};

void append(std::vector<Vec2>& to, const std::vector<Vec2>& points) {
  for (const Vec2& p : points) {
    if (to.empty() || (p - to.back()).norm() > 1e-9) to.push_back(p);
  }
}

// The last `length` of a chain of points.
std::vector<Vec2> tail(const std::vector<Vec2>& points, double length) {
  std::vector<Vec2> out{points.back()};
  for (std::size_t i = points.size() - 1; i-- > 0 && length > 0;) {
    const double step = (points[i] - out.back()).norm();
    out.push_back(step <= length ? points[i] : Vec2(out.back() + (points[i] - out.back()) * (length / step)));
    length -= step;
  }
  std::reverse(out.begin(), out.end());
  return out;
}

}  // namespace

std::vector<Polyline> trimmed_axis(const Axis& axis, double trim_mm) {
  const Graph graph(axis);
  const std::size_t n = axis.nodes.size();
  // height: the greatest way from a node back to a tip of the branches that end in it
  std::vector<double> height(n, 0);
  std::vector<std::size_t> degree(n);
  std::vector<char> gone(axis.edges.size(), 0);
  std::vector<double> kept(axis.edges.size(),
                           HUGE_VAL);  // of an edge that is cut: what stays, at its inner end
  std::vector<std::size_t> inner(axis.edges.size(), 0);
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> tips;
  for (std::size_t v = 0; v < n; ++v) {
    degree[v] = graph.at[v].size();
    if (degree[v] == 1) tips.emplace(0, v);
  }
  std::vector<char> cut(axis.edges.size(), 0);
  while (!tips.empty()) {
    const auto [h, v] = tips.top();
    tips.pop();
    if (degree[v] != 1) continue;
    const auto edge = std::find_if(graph.at[v].begin(), graph.at[v].end(),
                                   [&](std::size_t e) { return !gone[e] && !cut[e]; });
    if (edge == graph.at[v].end()) continue;
    const std::size_t u = graph.other(*edge, v);
    if (h + graph.length[*edge] >= trim_mm) {
      cut[*edge] = 1;
      kept[*edge] = h + graph.length[*edge] - trim_mm;
      inner[*edge] = u;
      continue;
    }
    gone[*edge] = 1;
    --degree[v];
    --degree[u];
    height[u] = std::max(height[u], h + graph.length[*edge]);
    if (degree[u] == 1) tips.emplace(height[u], u);
  }
  // walk what is left, straight on, from ends and odd nodes first
  std::vector<Polyline> out;
  std::vector<char> used = gone;
  const auto left_at = [&](std::size_t v) {
    std::size_t count = 0;
    for (const std::size_t e : graph.at[v]) count += !used[e] && !(cut[e] && inner[e] != v);
    return count;
  };
  const auto piece = [&](std::size_t e, std::size_t from) {
    std::vector<Vec2> points = graph.chain(e, from);
    if (!cut[e]) return points;
    const bool from_inner = inner[e] == from;
    if (from_inner) std::reverse(points.begin(), points.end());
    points = tail(points, kept[e]);
    if (from_inner) std::reverse(points.begin(), points.end());
    return points;
  };
  const auto walk = [&](std::size_t start, std::size_t first) {
    Polyline line;
    std::size_t at = start, edge = first;
    for (;;) {
      used[edge] = 1;
      append(line.points, piece(edge, at));
      const std::size_t next = graph.other(edge, at);
      if (cut[edge] && inner[edge] != next) break;  // the branch's shortened end
      at = next;
      std::size_t best = axis.edges.size();
      double straightest = -2;
      const std::size_t size = line.points.size();
      const Vec2 heading =
          size > 1 ? Vec2((line.points[size - 1] - line.points[size - 2]).normalized()) : Vec2::Zero();
      for (const std::size_t e : graph.at[at]) {
        if (used[e] || (cut[e] && inner[e] != at)) continue;
        const std::vector<Vec2> points = piece(e, at);
        if (points.size() < 2) continue;
        const double straight = heading.dot((points[1] - points[0]).normalized());
        if (straight > straightest) straightest = straight, best = e;
      }
      if (best == axis.edges.size()) break;
      edge = best;
    }
    if (at == start && line.points.size() > 3 && (line.points.front() - line.points.back()).norm() < 1e-9) {
      line.points.pop_back();
      line.closed = true;
    }
    if (line.points.size() > 1) out.push_back(std::move(line));
  };
  for (std::size_t e = 0; e < axis.edges.size(); ++e) {
    if (!used[e] && cut[e]) {
      // begin at the shortened end
      const std::size_t tip = graph.other(e, inner[e]);
      walk(tip, e);
    }
  }
  for (const std::size_t parity : {std::size_t{1}, std::size_t{0}}) {
    for (std::size_t e = 0; e < axis.edges.size(); ++e) {
      if (used[e]) continue;
      for (const std::size_t v : {axis.edges[e].from, axis.edges[e].to}) {
        if (!used[e] && left_at(v) % 2 == parity) walk(v, e);
      }
    }
  }
  return out;
}

Polyline longest_way(const Axis& axis) {
  const Graph graph(axis);
  // twice the farthest node by Dijkstra: exact in a tree
  const auto farthest = [&](std::size_t from, std::vector<std::size_t>& by) {
    std::vector<double> way(axis.nodes.size(), HUGE_VAL);
    by.assign(axis.nodes.size(), axis.edges.size());
    std::priority_queue<std::pair<double, std::size_t>, std::vector<std::pair<double, std::size_t>>,
                        std::greater<>>
        open;
    way[from] = 0;
    open.emplace(0, from);
    std::size_t last = from;
    while (!open.empty()) {
      const auto [w, v] = open.top();
      open.pop();
      if (w > way[v]) continue;
      last = v;
      for (const std::size_t e : graph.at[v]) {
        const std::size_t u = graph.other(e, v);
        if (w + graph.length[e] >= way[u]) continue;
        way[u] = w + graph.length[e];
        by[u] = e;
        open.emplace(way[u], u);
      }
    }
    return last;
  };
  Polyline line;
  if (axis.edges.empty()) return line;
  std::vector<std::size_t> by;
  const std::size_t start = farthest(axis.edges.front().from, by);
  std::size_t at = farthest(start, by);
  while (at != start) {
    append(line.points, graph.chain(by[at], at));
    at = graph.other(by[at], at);
  }
  return line;
}

}  // namespace afptraj
