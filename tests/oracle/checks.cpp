#include "checks.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "chart_free_geodesic.h"
#include "chord_index.h"

namespace oracle {
namespace {

std::string label(const Segment& s) {
  return "course " + std::to_string(s.course) + " segment " + std::to_string(s.number);
}

Vec oriented(const Skin& skin, const Foot& at, const Vec& like) {
  Vec n = skin.jet(at.face, at.u, at.v).normal();
  if (n.Modulus() < 0.5) return like;
  return n * like < 0 ? n.Reversed() : n;
}

// On a line where the surface is only continuous either side's normal is right: the sides are looked at 1e-4
// mm away, where a smooth surface of radius 1 mm and more has turned by no more than the limit.
double normal_miss(const Skin& skin, const Sample& s, const Vec& n) {
  constexpr double aside_mm = 1e-4;
  double miss = (n ^ s.n).Modulus();
  if (miss <= aside_mm) return miss;
  const Vec b = s.n ^ s.t;
  for (const Vec& way : {b, b.Reversed(), s.t, s.t.Reversed()}) {
    const Foot beside = skin.foot(s.at.face, s.x + way * aside_mm, s.at.u, s.at.v);
    miss = std::min(miss, (oriented(skin, beside, s.n) ^ s.n).Modulus());
  }
  return miss;
}

// For each face +1 or -1: the sense of S_u x S_v against the normals that the paths carry, by the samples on
// it; 0 where there are none.
std::vector<double> face_senses(const Skin& skin, const PlyPaths& ply) {
  std::vector<double> votes(static_cast<std::size_t>(skin.size()), 0);
  for (const Segment& segment : ply.segments)
    for (const Sample& s : segment.samples)
      if (s.at.face >= 0)
        votes[static_cast<std::size_t>(s.at.face)] += skin.jet(s.at.face, s.at.u, s.at.v).normal() * s.n;
  for (double& vote : votes) vote = vote < 0 ? -1 : vote > 0 ? 1 : 0;
  return votes;
}

// Cosine between the outward normals at `p` and at a sample: negative on the opposite wall.
double facing_cosine(const Skin& skin, const std::vector<double>& senses, const Foot& p, const Sample& c) {
  const double sense = senses[static_cast<std::size_t>(p.face)];
  if (sense == 0) return oriented(skin, p, c.n) * c.n;
  return sense * (skin.jet(p.face, p.u, p.v).normal() * c.n);
}

// The way over the skin from a chord: exact on spheres, where arc / chord = (a / 2) / sin(a / 2) for
// normals that differ by a.
double arc_of(double chord, double cosine) {
  const double turn = std::acos(std::clamp(cosine, -1.0, 1.0));
  return chord * (turn < 1e-6 ? 1 : 0.5 * turn / std::sin(0.5 * turn));
}

// How far a point beyond an end, `arc` away from it, is from the tangent on which the segment goes on there.
double off_tangent(const Segment& k, const Foot& p, double arc, const ChordHit& hit) {
  const bool at_last = 2 * hit.i + 2 > k.samples.size();
  const Sample& end = at_last ? k.samples.back() : k.samples.front();
  const double beyond = (p.point - end.x) * end.t * (at_last ? 1 : -1);
  return beyond <= 0 ? arc : std::sqrt(std::max(0.0, arc * arc - beyond * beyond));
}

// Where the candidate does not face the same way, the way to it leads round an edge: its chord says nothing,
// so both sides are tried with the expected length.
DistanceResult distance_round(const Skin& skin, const Segment& k, const Foot& p, double s0, bool facing,
                              double expected) {
  if (facing) return geodesic_distance(skin, k, p, s0);
  const DistanceResult left = geodesic_distance(skin, k, p, s0, expected, 1);
  const DistanceResult right = geodesic_distance(skin, k, p, s0, expected, -1);
  using Kind = DistanceResult::Kind;
  if (left.kind == Kind::found && right.kind == Kind::found)
    return left.distance < right.distance ? left : right;
  return left.kind == Kind::found || right.kind != Kind::found ? left : right;
}

// Where a front folds several feet lie close together, and the one found from the nearest chord need not be
// the nearest. A distance of more than the band asks for others, from places along the segment on either
// side; first as far as the chord says, then, as round a lip a chord says little, as far as the band.
DistanceResult nearest_foot(const Skin& skin, const Segment& k, const Foot& p, double s0, DistanceResult best,
                            double band_mm) {
  constexpr int seeds = 16;
  using Kind = DistanceResult::Kind;
  if (best.kind == Kind::found && best.distance < band_mm + 1e-5) return best;
  const auto take = [&](const DistanceResult& d) {
    if (d.kind == Kind::found && (best.kind != Kind::found || d.distance < best.distance)) best = d;
  };
  for (const bool by_chord : {true, false}) {
    for (int i = -seeds; i <= seeds; ++i) {
      const double s = s0 + 0.5 * band_mm * i / seeds;
      if (s <= k.samples.front().s || s >= k.samples.back().s) continue;
      if (by_chord) {
        if (i != 0) take(geodesic_distance(skin, k, p, s));
      } else {
        for (const int side : {-1, 1}) take(geodesic_distance(skin, k, p, s, band_mm, side));
      }
    }
    if (best.kind == Kind::found && best.distance < band_mm + 1e-5) break;
  }
  return best;
}

// The least length of a geodesic from `end` to p, found from directions on either side of the chord; infinite where none
// leads there.
double way_to_end(const Skin& skin, const Sample& end, const Foot& p, double expected) {
  const Foot start = skin.nearest(end.x, &end.at, 1e-3);
  if (start.face < 0) return 1e300;
  const Vec n = oriented(skin, start, end.n);
  Vec chord = p.point - start.point;
  chord = chord - n * (n * chord);
  if (chord.Modulus() < 1e-9) return 1e300;
  chord.Normalize();
  const auto turned = [&](double angle) { return chord * std::cos(angle) + (n ^ chord) * std::sin(angle); };
  double best = 1e300;
  for (int seed = -8; seed <= 8; ++seed) {
    double angle = 0.08 * seed, d = expected;
    for (int iteration = 0; iteration < 15; ++iteration) {
      const Shot shot = shoot(skin, start, n, turned(angle), d, 0, {1e-7, 0});
      if (shot.length < d * (1 - 1e-9)) break;
      const Vec r = p.point - shot.at.point, aside = shot.normal ^ shot.tangent;
      if (r.Modulus() < 1e-5) {
        best = std::min(best, d);
        break;
      }
      constexpr double turn = 1e-5;
      const Shot beside = shoot(skin, start, n, turned(angle + turn), d, 0, {1e-7, 0});
      const double spread = (beside.at.point - shot.at.point) * aside / turn;
      if (std::abs(spread) < 1e-3 * d) break;
      angle += std::clamp(r * aside / spread, -0.3, 0.3);
      d += std::clamp(r * shot.tangent, -0.3 * d, 0.3 * d);
    }
  }
  return best;
}

// Segment numbers (indices) of each course.
std::map<int, std::vector<int>> by_course(const PlyPaths& ply) {
  std::map<int, std::vector<int>> courses;
  for (std::size_t i = 0; i < ply.segments.size(); ++i)
    courses[ply.segments[i].course].push_back(static_cast<int>(i));
  return courses;
}

}  // namespace

SurfaceCheck check_on_surface(const Skin& skin, PlyPaths& ply) {
  SurfaceCheck check;
  for (Segment& segment : ply.segments) {
    Foot hint;
    for (std::size_t i = 0; i < segment.samples.size(); ++i) {
      Sample& s = segment.samples[i];
      const std::string what = label(segment) + " line " + std::to_string(s.line);
      s.at = skin.nearest(s.x, hint.face >= 0 ? &hint : nullptr);
      hint = s.at;
      ++check.points;
      check.distance.take(s.at.distance, s.x, what);
      if (!skin.inside(s.at.face, s.at.u, s.at.v)) {
        const BoundaryFoot edge = skin.boundary(s.x);
        check.outside.take(std::min(edge.on_pcurve, edge.on_curve), s.x, what);
      }
      const Vec n = oriented(skin, s.at, s.n);
      check.normal.take(normal_miss(skin, s, n), s.x, what);
      check.tangent.take(std::abs(n * s.t), s.x, what);
      if (i == 0) continue;
      const double ds = s.s - segment.samples[i - 1].s, chord = (s.x - segment.samples[i - 1].x).Modulus();
      check.spacing.take(ds, s.x, what);
      check.arc.take(std::abs(ds - chord) - 0.05 * ds, s.x, what);
    }
  }
  return check;
}

EndCheck check_ends(const Skin& skin, const PlyPaths& ply, double reach_mm) {
  EndCheck check;
  std::vector<std::pair<int, const Sample*>> ends;
  for (const Segment& s : ply.segments) {
    if (s.closed) {
      ++check.closed;
      continue;
    }
    ends.emplace_back(s.course, &s.samples.front());
    ends.emplace_back(s.course, &s.samples.back());
  }
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const Sample& end = *ends[i].second;
    const std::string what = "course " + std::to_string(ends[i].first) + " line " + std::to_string(end.line);
    const BoundaryFoot foot = skin.boundary(end.x);
    const double distance = std::min(foot.on_pcurve, foot.on_curve);
    if (distance > reach_mm) {
      // Where fronts met, two ends share a point inside the skin: of one course, or of k and -k on a closed
      // skin.
      bool corner = false;
      for (std::size_t k = 0; k < ends.size() && !corner; ++k)
        corner = k != i && std::abs(ends[k].first) == std::abs(ends[i].first) &&
                 (ends[k].second->x - end.x).Modulus() < 1e-3;
      ++(corner ? check.corner : check.inside);
      if (!corner) check.error.take(distance, end.x, what);
      continue;
    }
    ++(foot.pole ? check.pole : foot.shared ? check.shared : foot.seam ? check.seam : check.boundary);
    check.error.take(distance, end.x, what);
    check.error_curve.take(foot.on_curve, end.x, what);
  }
  return check;
}

CrossingCheck check_crossings(const PlyPaths& ply, double band_mm) {
  CrossingCheck check;
  std::vector<int> all;
  for (std::size_t i = 0; i < ply.segments.size(); ++i) all.push_back(static_cast<int>(i));
  double chord = 0;
  for (const Segment& s : ply.segments)
    for (std::size_t i = 0; i + 1 < s.samples.size(); ++i)
      chord = std::max(chord, (s.samples[i + 1].x - s.samples[i].x).Modulus());
  const ChordIndex index(ply, std::max(chord, 1e-6), all);
  const double height = std::min(0.2 * band_mm, 0.5 * chord);  // greatest separation along the normal
  for (const int si : all) {
    const Segment& A = ply.segments[static_cast<std::size_t>(si)];
    for (std::size_t i = 0; i + 1 < A.samples.size(); ++i) {
      const Sample &a0 = A.samples[i], &a1 = A.samples[i + 1];
      for (const ChordHit& hit : index.beside(a0.x, a1.x)) {
        if (hit.segment < si || (hit.segment == si && hit.i <= i + 1)) continue;
        const Segment& B = ply.segments[static_cast<std::size_t>(hit.segment)];
        if (hit.segment == si && A.closed && i == 0 && hit.i + 2 == A.samples.size()) continue;
        const Sample &b0 = B.samples[hit.i], &b1 = B.samples[hit.i + 1];
        if (a0.n * b0.n < 0.5) continue;
        const Vec n = (a0.n + b0.n).Normalized();
        const Vec da = a1.x - a0.x, db = b1.x - b0.x, r = b0.x - a0.x;
        const double cross = n * (da ^ db);
        if (std::abs(cross) <= 1e-12 * da.Modulus() * db.Modulus()) continue;
        const double x = n * (r ^ db) / cross, y = n * (r ^ da) / cross;
        if (x < 0 || x > 1 || y < 0 || y > 1) continue;
        const Vec pa = a0.x + da * x, pb = b0.x + db * y;
        if (std::abs((pa - pb) * n) > height) continue;
        // Ends that meet at a corner touch there: chords are up to a chord height off their curves.
        const auto end_near = [&](const Segment& s, const Vec& p) {
          return (s.samples.front().x - p).Modulus() < 0.02 || (s.samples.back().x - p).Modulus() < 0.02;
        };
        if (end_near(A, pa) && end_near(B, pb)) continue;
        ++(A.course == B.course ? check.self : check.mutual);
        if (check.where.size() < 8) {
          char text[160];
          std::snprintf(text, sizeof text, "courses %d and %d cross at (%.3f, %.3f, %.3f)", A.course,
                        B.course, pa.X(), pa.Y(), pa.Z());
          check.where.emplace_back(text);
        }
      }
    }
  }
  return check;
}

DistanceResult geodesic_distance(const Skin& skin, const Segment& segment, const Foot& p, double s0,
                                 double d0, int side0) {
  using Kind = DistanceResult::Kind;
  DistanceResult result;
  // From an end that is the nearest point of all, failure means that the foot lies beyond it.
  const bool at_end = !segment.closed && (s0 <= segment.samples.front().s || s0 >= segment.samples.back().s);
  const Kind failed = at_end ? Kind::beyond_end : Kind::unresolved;
  result.kind = failed;
  double s = s0, d = d0, side = side0;
  int clamped = 0, clamps = 0;
  double last_miss = 1e300;
  const double first = segment.samples.front().s, last = segment.samples.back().s;
  for (int iteration = 0; iteration < 25; ++iteration) {
    const Segment::Point c = segment.at(s);
    if (!std::isfinite(s) || !std::isfinite(c.x.SquareModulus()) || segment.samples[c.i].at.face < 0)
      return result;
    const Foot start = skin.nearest(c.x, &segment.samples[c.i].at, 1e-3);
    if (start.face < 0) return result;
    const Vec n = oriented(skin, start, segment.samples[c.i].n);
    const Vec t = (c.t - n * (n * c.t)).Normalized();
    const Vec left = n ^ t;
    if (d <= 0) {
      const Vec r = p.point - start.point;
      if (side == 0) side = r * left < 0 ? -1 : 1;
      d = std::max(r.Modulus(), 1e-9);
    }
    const Shot shot = shoot(skin, start, n, left * side, d, -side * c.kg);
    if (shot.length < d * (1 - 1e-9)) return result;
    const Vec r = p.point - shot.at.point;
    const double along = r * shot.tangent, across = r * (shot.tangent ^ shot.normal) * side;
    result.left_skin = shot.left_skin;
    result.distance = d;
    result.s = s;
    result.side = side;
    // At the foot the length is stationary: 1e-6 mm beside it changes it by 1e-15 mm, while what coordinates
    // rounded to 1e-9 mm leave of the direction moves the end of the shot by more than 1e-9 mm.
    if (std::abs(along) < 1e-9 && (std::abs(across) < 1e-6 || clamped > 2)) {
      // Off in the normal direction: another sheet of the skin.
      if (r.Modulus() > 1e-4 && clamped <= 2) return result;
      result.kind = clamped > 2 ? Kind::beyond_end : Kind::found;
      return result;
    }
    // Round a sharp edge the shot itself is no better than this: iterations end there, near the foot.
    const double miss = r.Modulus();
    if (miss < 1e-6 && miss > 0.5 * last_miss && clamped == 0) {
      result.kind = Kind::found;
      return result;
    }
    last_miss = miss;
    const double y = std::abs(shot.y) < 0.1 ? std::copysign(0.1, shot.y) : shot.y;
    double ds = across / y;
    const double limit = std::max(0.5 * d, 1.0);
    ds = std::clamp(ds, -limit, limit);
    d += std::clamp(along, -0.5 * d, 0.5 * d);
    s += ds;
    if (!segment.closed) {
      const double inside = std::clamp(s, first, last);
      clamped = inside != s ? clamped + 1 : 0;
      clamps += inside != s ? 1 : 0;
      s = inside;
      if (clamped > 5 || clamps > 7) {
        result.kind = Kind::beyond_end;
        return result;
      }
    }
  }
  return result;
}

SpacingCheck check_spacing(const Skin& skin, const PlyPaths& ply, double band_mm, int points) {
  SpacingCheck check;
  const std::vector<double> senses = face_senses(skin, ply);
  const auto courses = by_course(ply);
  std::size_t chords = 0;
  for (const Segment& s : ply.segments)
    if (s.course != 0) chords += s.samples.size() - 1;
  const std::size_t stride = std::max<std::size_t>(1, chords / static_cast<std::size_t>(std::max(points, 1)));
  double sum = 0;
  for (const auto& [number, segments] : courses) {
    if (number == 0) continue;
    // The level before, of either side: an extension of one side can have fronts to both.
    const int before = std::abs(number) - 1;
    std::vector<int> parents;
    for (const int parent : {before, -before})
      if (const auto found = courses.find(parent); found != courses.end() && (parent != 0 || parents.empty()))
        parents.insert(parents.end(), found->second.begin(), found->second.end());
    if (parents.empty()) continue;
    ++check.courses;
    const ChordIndex index(ply, std::max(band_mm, 1e-3), parents);
    for (const int si : segments) {
      const Segment& segment = ply.segments[static_cast<std::size_t>(si)];
      for (std::size_t i = 0; i + 1 < segment.samples.size(); ++i) {
        // The first and last chords of a segment are always measured.
        if (i % stride != 0 && i != 0 && i + 2 != segment.samples.size()) continue;
        const double s = 0.5 * (segment.samples[i].s + segment.samples[i + 1].s);
        const Foot p = skin.nearest(segment.at(s).x, &segment.samples[i].at, 1e-3);
        DistanceResult best;
        bool beyond = false, open = false, faced = false;
        double nearest_end = 1e300, nearest_line = 1e300;
        std::vector<ChordHit> past_ends;
        for (const ChordHit& hit : index.near(p.point, 1.5 * band_mm, 2 * band_mm)) {
          const Segment& k = ply.segments[static_cast<std::size_t>(hit.segment)];
          const double s0 = k.samples[hit.i].s + hit.x * (k.samples[hit.i + 1].s - k.samples[hit.i].s);
          const double cosine = facing_cosine(skin, senses, p, k.samples[hit.i]);
          const bool facing = cosine > 0.3;
          DistanceResult d = distance_round(skin, k, p, s0, facing, band_mm);
          if (facing) d = nearest_foot(skin, k, p, s0, d, band_mm);
          if (d.kind == DistanceResult::Kind::beyond_end) {
            beyond = true;
            if (facing) past_ends.push_back(hit);
            nearest_end = std::min(nearest_end, arc_of(hit.distance, cosine));
            nearest_line = std::min(nearest_line, off_tangent(k, p, arc_of(hit.distance, cosine), hit));
          }
          if (d.kind == DistanceResult::Kind::unresolved) open = open || facing;
          faced = faced || facing;
          if (d.kind != DistanceResult::Kind::found) continue;
          if (best.kind != DistanceResult::Kind::found || d.distance < best.distance) best = d;
        }
        if (best.kind != DistanceResult::Kind::found) {
          ++((open || !faced) && !beyond ? check.unresolved : check.beyond_end);
          continue;
        }
        // A course lies to the left of the one before it if its number is positive, else to the right. What lies on the other
        // side (an extension that came round the part) is no parallel of it; it must only not be too near.
        if (best.side * number < 0 && best.distance > band_mm) {
          ++check.beyond_end;
          continue;
        }
        // Nearer than the foot, but not nearer than W, lies an end, or what goes on beyond it off the skin:
        // beside a foot farther off there is none.
        if (nearest_end >= band_mm && std::min(nearest_end, nearest_line) < best.distance) {
          ++check.beyond_end;
          continue;
        }
        // Chords tell how far an end is only roughly: what matters is measured.
        double way = 1e300;
        if (best.distance > band_mm + 1e-4)
          for (const ChordHit& hit : past_ends) {
            const Segment& k = ply.segments[static_cast<std::size_t>(hit.segment)];
            const bool at_last = 2 * hit.i + 2 > k.samples.size();
            way = std::min(way, way_to_end(skin, at_last ? k.samples.back() : k.samples.front(), p, band_mm));
          }
        if (way >= band_mm - 1e-4 && way < best.distance) {
          ++check.beyond_end;
          continue;
        }
        const double error = std::abs(best.distance - band_mm);
        const std::string what = label(segment) + " line " + std::to_string(segment.samples[i].line);
        if (best.left_skin) {
          ++check.off_skin;
          check.off_skin_error.take(error, p.point, what);
          continue;
        }
        ++check.measured;
        sum += error * error;
        check.error.take(error, p.point, what);
      }
    }
  }
  check.rms = check.measured > 0 ? std::sqrt(sum / check.measured) : 0;
  return check;
}

namespace {

// The band goes on past the end of its centre line until it is cut at the boundary: each end on the boundary
// is lengthened by a geodesic.
PlyPaths lengthened_ends(const Skin& skin, const PlyPaths& ply, double length) {
  PlyPaths out{ply.name, {}};
  const double step = length / 24;
  for (const Segment& segment : ply.segments) {
    if (segment.closed) continue;
    for (const bool last : {false, true}) {
      const Sample& end = last ? segment.samples.back() : segment.samples.front();
      const BoundaryFoot edge = skin.boundary(end.x);
      if (edge.pole || std::min(edge.on_pcurve, edge.on_curve) > 1e-3) continue;
      Segment extension{segment.course, segment.number, {end}, false};
      Foot at = end.at;
      Vec t = last ? end.t : end.t.Reversed(), n = oriented(skin, at, end.n);
      t = (t - n * (n * t)).Normalized();
      for (double s = step; s <= length * 1.0001; s += step) {
        const Shot shot = shoot(skin, at, n, t, step, 0, {1e-5, 0});
        if (shot.length < step * 0.999) break;
        at = shot.at, n = shot.normal, t = shot.tangent;
        extension.samples.push_back({s, at.point, n, t, 0, end.line, at});
      }
      if (extension.samples.size() > 1) out.segments.push_back(std::move(extension));
    }
  }
  return out;
}

std::vector<int> all_of(const PlyPaths& ply) {
  std::vector<int> all;
  for (std::size_t i = 0; i < ply.segments.size(); ++i) all.push_back(static_cast<int>(i));
  return all;
}

// Distance from the nearest centre line where it is at most `allowed`, else 1e300 or an upper bound.
double distance_to_centre_line(const Skin& skin, const std::vector<double>& senses, const PlyPaths& ply,
                               const ChordIndex& index, const Foot& p, double allowed, int& measured) {
  double least = 1e300;
  for (const ChordHit& hit : index.near(p.point, allowed, 4 * allowed)) {
    const Segment& k = ply.segments[static_cast<std::size_t>(hit.segment)];
    const Sample& c = k.samples[hit.i];
    const double cosine = facing_cosine(skin, senses, p, c);
    const double arc = arc_of(hit.distance, cosine);
    if (arc < 0.97 * allowed && cosine > 0.7) return arc;
    ++measured;
    const double s0 = c.s + hit.x * (k.samples[hit.i + 1].s - c.s);
    const DistanceResult d = distance_round(skin, k, p, s0, cosine > 0.3, allowed);
    if (d.kind == DistanceResult::Kind::found)
      least = std::min(least, d.distance);
    else if (cosine > 0.2)
      least = std::min(least, arc);
    if (least <= allowed) break;
  }
  return least;
}

double distance_to_extension(const Skin& skin, const std::vector<double>& senses, const PlyPaths& ends,
                             const ChordIndex& index, const Foot& p, double allowed) {
  double least = 1e300;
  for (const ChordHit& hit : index.near(p.point, allowed, 4 * allowed)) {
    const Sample& c = ends.segments[static_cast<std::size_t>(hit.segment)].samples[hit.i];
    const double cosine = facing_cosine(skin, senses, p, c);
    if (cosine > 0.2) least = std::min(least, arc_of(hit.distance, cosine));
  }
  return least;
}

}  // namespace

CoverageCheck check_coverage(const Skin& skin, const PlyPaths& ply, double band_mm, int samples) {
  CoverageCheck check;
  const std::vector<double> senses = face_senses(skin, ply);
  const double half = 0.5 * band_mm, allowed = half + 1e-3;
  const ChordIndex index(ply, half, all_of(ply));
  const PlyPaths ends = lengthened_ends(skin, ply, 3 * band_mm);
  const ChordIndex end_index(ends, half, all_of(ends));
  for (const Skin::AreaSample& sample : skin.area_samples(samples)) {
    ++check.samples;
    check.area += sample.area;
    double least = distance_to_centre_line(skin, senses, ply, index, sample.at, allowed, check.measured);
    if (least <= allowed) {
      check.near_line += sample.area;
      check.covered += sample.area;
      continue;
    }
    // 0.5 % of W/2: the extension is a geodesic, its course is not quite, and the distance is not Newton's.
    if (distance_to_extension(skin, senses, ends, end_index, sample.at, 1.005 * allowed) <= 1.005 * allowed) {
      check.covered += sample.area;
      continue;
    }
    if (least > 1e299)
      for (const ChordHit& hit : index.near(sample.at.point, 4 * band_mm, 1e300))
        least = std::min(least, hit.distance);
    if (least > 1e299) least = 4 * band_mm;
    check.uncovered.push_back({sample.at.point, least, sample.area});
    check.distance.take(least, sample.at.point, "");
  }
  return check;
}

}  // namespace oracle
