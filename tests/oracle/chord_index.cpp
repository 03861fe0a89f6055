#include "chord_index.h"

#include <algorithm>
#include <cmath>

namespace oracle {
namespace {

ChordHit nearest_on_chord(const Vec& a, const Vec& b, const Vec& p) {
  const Vec d = b - a;
  const double length2 = d * d;
  ChordHit hit;
  hit.x = length2 > 0 ? std::clamp((p - a) * d / length2, 0.0, 1.0) : 0;
  hit.point = a + d * hit.x;
  hit.distance = (p - hit.point).Modulus();
  return hit;
}

}  // namespace

ChordIndex::ChordIndex(const PlyPaths& ply, double cell_mm, const std::vector<int>& segments)
    : ply_(ply), cell_(cell_mm) {
  for (const int s : segments) {
    const auto& samples = ply.segments[static_cast<std::size_t>(s)].samples;
    for (std::size_t i = 0; i + 1 < samples.size(); ++i) {
      const Vec &a = samples[i].x, &b = samples[i + 1].x;
      long long lo[3], hi[3];
      for (int k = 0; k < 3; ++k) {
        lo[k] = std::llround(std::floor(std::min(a.Coord(k + 1), b.Coord(k + 1)) / cell_));
        hi[k] = std::llround(std::floor(std::max(a.Coord(k + 1), b.Coord(k + 1)) / cell_));
      }
      for (long long x = lo[0]; x <= hi[0]; ++x)
        for (long long y = lo[1]; y <= hi[1]; ++y)
          for (long long z = lo[2]; z <= hi[2]; ++z) cells_[key(x, y, z)].emplace_back(s, i);
    }
  }
}

std::vector<ChordHit> ChordIndex::beside(const Vec& a, const Vec& b) const {
  std::vector<ChordHit> hits;
  long long lo[3], hi[3];
  for (int k = 0; k < 3; ++k) {
    lo[k] = std::llround(std::floor(std::min(a.Coord(k + 1), b.Coord(k + 1)) / cell_));
    hi[k] = std::llround(std::floor(std::max(a.Coord(k + 1), b.Coord(k + 1)) / cell_));
  }
  for (long long x = lo[0]; x <= hi[0]; ++x)
    for (long long y = lo[1]; y <= hi[1]; ++y)
      for (long long z = lo[2]; z <= hi[2]; ++z) {
        const auto found = cells_.find(key(x, y, z));
        if (found == cells_.end()) continue;
        for (const auto& [s, i] : found->second) {
          ChordHit hit;
          hit.segment = s;
          hit.i = i;
          hits.push_back(hit);
        }
      }
  const auto same = [](const ChordHit& a, const ChordHit& b) { return a.segment == b.segment && a.i == b.i; };
  std::sort(hits.begin(), hits.end(), [](const ChordHit& a, const ChordHit& b) {
    return a.segment != b.segment ? a.segment < b.segment : a.i < b.i;
  });
  hits.erase(std::unique(hits.begin(), hits.end(), same), hits.end());
  return hits;
}

ChordHit ChordIndex::nearest(const Vec& p, double reach,
                             const std::function<bool(const Sample&)>& take) const {
  ChordHit best;
  best.distance = reach;
  const auto cell = [&](double x) { return std::llround(std::floor(x / cell_)); };
  for (long long x = cell(p.X() - reach); x <= cell(p.X() + reach); ++x)
    for (long long y = cell(p.Y() - reach); y <= cell(p.Y() + reach); ++y)
      for (long long z = cell(p.Z() - reach); z <= cell(p.Z() + reach); ++z) {
        const auto found = cells_.find(key(x, y, z));
        if (found == cells_.end()) continue;
        for (const auto& [s, i] : found->second) {
          const auto& samples = ply_.segments[static_cast<std::size_t>(s)].samples;
          ChordHit hit = nearest_on_chord(samples[i].x, samples[i + 1].x, p);
          if (hit.distance >= best.distance || !take(samples[i])) continue;
          hit.segment = s;
          hit.i = i;
          best = hit;
        }
      }
  return best;
}

std::vector<ChordHit> ChordIndex::near(const Vec& p, double reach, double apart_mm) const {
  const Vec r(reach, reach, reach);
  const std::vector<ChordHit> candidates = beside(p - r, p + r);
  std::vector<ChordHit> hits;
  for (const ChordHit& c : candidates) {
    const auto& samples = ply_.segments[static_cast<std::size_t>(c.segment)].samples;
    ChordHit hit = nearest_on_chord(samples[c.i].x, samples[c.i + 1].x, p);
    if (hit.distance > reach) continue;
    hit.segment = c.segment;
    hit.i = c.i;
    hits.push_back(hit);
  }
  std::sort(hits.begin(), hits.end(),
            [](const ChordHit& a, const ChordHit& b) { return a.distance < b.distance; });
  std::vector<ChordHit> kept;
  for (const ChordHit& hit : hits) {
    const auto& samples = ply_.segments[static_cast<std::size_t>(hit.segment)].samples;
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const ChordHit& k) {
      return k.segment == hit.segment && std::abs(samples[k.i].s - samples[hit.i].s) < apart_mm;
    });
    if (!known) kept.push_back(hit);
    if (kept.size() == 8) break;
  }
  return kept;
}

}  // namespace oracle
