#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "fill/fill_path.h"
#include "fill/slice.h"

namespace afptraj::test {

/// r(t) = 15 (1 + a cos 10 t) at n points: the flower of the fill cases.
inline std::vector<Vec2> flower(double a, int n) {
  std::vector<Vec2> points;
  for (int i = 0; i < n; ++i) {
    const double t = 2 * pi * i / n, r = 15 * (1 + a * std::cos(10 * t));
    points.emplace_back(r * std::cos(t), r * std::sin(t));
  }
  return points;
}

inline std::vector<Vec2> circle(double radius, int n, const Vec2& centre = Vec2::Zero()) {
  std::vector<Vec2> points;
  for (int i = 0; i < n; ++i)
    points.push_back(centre + radius * Vec2(std::cos(2 * pi * i / n), std::sin(2 * pi * i / n)));
  return points;
}

inline std::vector<Vec2> rectangle(double x0, double y0, double x1, double y1) {
  return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
}

inline std::vector<Vec2> reverse(std::vector<Vec2> points) { return {points.rbegin(), points.rend()}; }

inline std::vector<Vec2> l_shape() { return {{0, 0}, {30, 0}, {30, 10}, {10, 10}, {10, 30}, {0, 30}}; }

inline std::vector<Vec2> star() {
  std::vector<Vec2> points;
  for (int i = 0; i < 10; ++i) {
    const double t = pi * i / 5 + pi / 2, r = i % 2 == 0 ? 12 : 5;
    points.emplace_back(r * std::cos(t), r * std::sin(t));
  }
  return points;
}

/// Two discs joined by a neck.
inline std::vector<Vec2> dumb_bell(double neck) {
  const double a = std::asin(neck / 12);
  std::vector<Vec2> points;
  for (const double side : {-1.0, 1.0}) {
    for (int i = 0; i <= 100; ++i) {
      const double t = (side < 0 ? 0 : pi) + a + (2 * pi - 2 * a) * i / 100;
      points.emplace_back(10 * side + 6 * std::cos(t), 6 * std::sin(t));
    }
  }
  return points;
}

inline Slice slice_of(const std::vector<std::vector<Vec2>>& rings) {
  std::vector<InputRing> input;
  for (const auto& ring : rings) input.push_back({std::to_string(input.size()), ring, {}});
  return Slice("slice", input);
}

/// The paths of a table path,i,x,y as other programs write it; empty when the file is not there.
inline std::vector<Polyline> read_paths(const std::filesystem::path& file, bool closed) {
  std::ifstream in(file);
  std::vector<Polyline> out;
  std::string line, last;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::istringstream fields(line);
    std::string path, i, x, y;
    std::getline(fields, path, ','), std::getline(fields, i, ','), std::getline(fields, x, ',');
    std::getline(fields, y, ',');
    if (out.empty() || path != last) out.push_back({{}, closed});
    last = path;
    out.back().points.emplace_back(std::stod(x), std::stod(y));
  }
  return out;
}

inline double distance_to(const std::vector<Polyline>& lines, const Vec2& p) {
  double best = HUGE_VAL;
  for (const Polyline& line : lines) {
    const std::size_t n = line.points.size();
    for (std::size_t i = 0; i + (line.closed ? 0 : 1) < n; ++i) {
      const Vec2 a = line.points[i], d = line.points[(i + 1) % n] - a, v = p - a;
      const double t = std::clamp(v.dot(d) / d.squaredNorm(), 0.0, 1.0);
      best = std::min(best, (v - t * d).norm());
    }
  }
  return best;
}

inline std::vector<Polyline> boundary_of(const Slice& slice) {
  std::vector<Polyline> out;
  for (const SliceRing& ring : slice.rings()) out.push_back({ring.points, true});
  return out;
}

/// A closed curve round `centre` between 0.75 and 1.25 `radius`.
inline std::vector<Vec2> blob(std::mt19937& random, const Vec2& centre, double radius, int n) {
  std::uniform_real_distribution<double> phase(0, 2 * pi);
  const double p2 = phase(random), p3 = phase(random), p5 = phase(random);
  std::vector<Vec2> points;
  for (int i = 0; i < n; ++i) {
    const double t = 2 * pi * i / n;
    const double r = radius * (1 + 0.11 * std::sin(2 * t + p2) + 0.08 * std::sin(3 * t + p3) +
                               0.06 * std::sin(5 * t + p5));
    points.push_back(centre + r * Vec2(std::cos(t), std::sin(t)));
  }
  return points;
}

/// Outlines with up to three holes each and islands in them, coarse or fine, in any sense.
inline Slice random_slice(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<std::vector<Vec2>> rings;
  const auto add = [&](const Vec2& centre, double radius) {
    rings.push_back(blob(random, centre, radius, 12 + static_cast<int>(70 * unit(random))));
    if (unit(random) < 0.5) rings.back() = reverse(rings.back());
  };
  const int outlines = 1 + static_cast<int>(2 * unit(random));
  for (int k = 0; k < outlines; ++k) {
    const Vec2 middle(40 * k, 5 * unit(random));
    add(middle, 14);
    for (int h = 0; h < 3; ++h) {
      if (unit(random) < 0.3) continue;
      const double t = 2 * pi * h / 3 + unit(random), radius = 1 + 2.5 * unit(random);
      const Vec2 centre = middle + 5.8 * Vec2(std::cos(t), std::sin(t));
      add(centre, radius);
      if (radius > 2.5) add(centre, radius * 0.5);
    }
  }
  return slice_of(rings);
}

/// Pieces of two paths, or of one, that cross beyond their ends.
inline int crossings(const std::vector<FillPath>& paths) {
  struct Piece {
    Vec2 a, b;
  };
  std::vector<Piece> pieces;
  for (const FillPath& path : paths) {
    const auto& points = path.line.points;
    for (std::size_t i = 0; i + (path.line.closed ? 0 : 1) < points.size(); ++i)
      pieces.push_back({points[i], points[(i + 1) % points.size()]});
  }
  std::sort(pieces.begin(), pieces.end(), [](const Piece& p, const Piece& q) {
    return std::min(p.a.x(), p.b.x()) < std::min(q.a.x(), q.b.x());
  });
  int count = 0;
  const auto side = [](const Piece& p, const Vec2& q) { return cross((p.b - p.a).normalized(), q - p.a); };
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const double right = std::max(pieces[i].a.x(), pieces[i].b.x());
    for (std::size_t j = i + 1; j < pieces.size() && std::min(pieces[j].a.x(), pieces[j].b.x()) < right;
         ++j) {
      constexpr double touch = 1e-7;
      const double a = side(pieces[i], pieces[j].a), b = side(pieces[i], pieces[j].b),
                   c = side(pieces[j], pieces[i].a), d = side(pieces[j], pieces[i].b);
      if (std::min(std::abs(a), std::abs(b)) < touch || std::min(std::abs(c), std::abs(d)) < touch) continue;
      count += a * b < 0 && c * d < 0;
    }
  }
  return count;
}

}  // namespace afptraj::test
