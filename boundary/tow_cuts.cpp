#include "boundary/tow_cuts.h"

#include <algorithm>
#include <array>
#include <stdexcept>

namespace afptraj {
namespace {

constexpr double slack_mm = 1e-9;

constexpr std::array<std::pair<const char*, ShortTows>, 4> words = {{{"symmetric", ShortTows::symmetric},
                                                                     {"forward", ShortTows::forward},
                                                                     {"backward", ShortTows::backward},
                                                                     {"drop", ShortTows::drop}}};

bool contains(const Stretches& stretches, double t) {
  return std::any_of(stretches.begin(), stretches.end(), [&](const Interval& i) { return i.contains(t); });
}

bool laid_at(const TowCover& cover, double p, double t) {
  const bool left = contains(cover.left, t), right = contains(cover.right, t);
  if (left && right) return p >= 1 || contains(cover.middle, t);
  if (left) return contains(cover.from_right, t);
  if (right) return contains(cover.from_left, t);
  return p >= 1 && contains(cover.middle, t);
}

/// Joins pieces with less than `gap` between them.
int join_near(Stretches& pieces, double gap) {
  Stretches out;
  int joined = 0;
  for (const Interval& piece : pieces) {
    if (!out.empty() && piece.lo - out.back().hi < gap) {
      out.back().hi = std::max(out.back().hi, piece.hi);
      ++joined;
    } else {
      out.push_back(piece);
    }
  }
  pieces = std::move(out);
  return joined;
}

/// A piece made as long as the minimum, as far as [lo, hi] allows: what one end cannot give the other does, if it may.
Interval extended(const Interval& piece, const Interval& range, double least, ShortTows rule) {
  const double need = least - piece.length();
  const double before = piece.lo - range.lo, after = range.hi - piece.hi;
  double back = rule == ShortTows::symmetric ? need / 2 : rule == ShortTows::backward ? need : 0;
  back = std::min(back, before);
  const double forth = rule == ShortTows::backward ? 0 : std::min(need - back, after);
  if (rule == ShortTows::symmetric) back = std::min(need - forth, before);
  return {piece.lo - back, piece.hi + forth};
}

}  // namespace

const char* to_string(ShortTows rule) {
  for (const auto& [word, value] : words)
    if (value == rule) return word;
  return "";
}

std::vector<std::string> short_tow_words() {
  std::vector<std::string> out;
  for (const auto& entry : words) out.emplace_back(entry.first);
  return out;
}

ShortTows short_tows_of(const std::string& word) {
  for (const auto& [known, value] : words)
    if (word == known) return value;
  throw std::invalid_argument("unknown rule for short tows: " + word);
}

Stretches apply_rule(const TowCover& cover, double p) {
  std::vector<double> at;
  for (const Stretches* line : {&cover.left, &cover.right, &cover.middle, &cover.from_left, &cover.from_right})
    for (const Interval& i : *line) {
      at.push_back(i.lo);
      at.push_back(i.hi);
    }
  std::sort(at.begin(), at.end());
  Stretches out;
  for (std::size_t i = 0; i + 1 < at.size(); ++i) {
    if (!(at[i + 1] > at[i]) || !laid_at(cover, p, 0.5 * (at[i] + at[i + 1]))) continue;
    if (!out.empty() && out.back().hi == at[i])
      out.back().hi = at[i + 1];
    else
      out.push_back({at[i], at[i + 1]});
  }
  return out;
}

CutResult settle_pieces(Stretches pieces, const TowRun& run, const CutRule& rule) {
  CutResult out;
  if (pieces.empty()) return out;
  Interval range = run.range;
  const double round = range.length();
  const bool whole = pieces.size() == 1 && pieces[0].length() >= round - slack_mm;
  if (run.closed && !whole) {
    // Begin in the widest gap: nothing then reaches over the seam that is not laid through.
    const auto gap_before = [&](std::size_t i) {
      return i > 0 ? pieces[i].lo - pieces[i - 1].hi : pieces[0].lo + round - pieces.back().hi;
    };
    std::size_t first = 0;
    for (std::size_t i = 1; i < pieces.size(); ++i)
      if (gap_before(i) > gap_before(first)) first = i;
    if (gap_before(first) < rule.min_gap_mm) {
      out.bridged = static_cast<int>(pieces.size());
      out.pieces = {range};
      return out;
    }
    const double start = pieces[first].lo - gap_before(first) / 2;
    for (std::size_t i = 0; i < first; ++i) {
      pieces[i].lo += round;
      pieces[i].hi += round;
    }
    std::rotate(pieces.begin(), pieces.begin() + static_cast<std::ptrdiff_t>(first), pieces.end());
    range = {start, start + round};
    join_near(pieces, slack_mm);  // what was cut at the seam only
  }
  out.bridged = join_near(pieces, std::max(rule.min_gap_mm, slack_mm));
  for (Interval& piece : pieces) {
    if (piece.length() >= rule.min_cut_length_mm - slack_mm || rule.short_tows == ShortTows::drop) continue;
    piece = extended(piece, range, rule.min_cut_length_mm, rule.short_tows);
    ++out.extended;
  }
  std::sort(pieces.begin(), pieces.end(), [](const Interval& a, const Interval& b) { return a.lo < b.lo; });
  out.bridged += join_near(pieces, std::max(rule.min_gap_mm, slack_mm));
  const auto dropped = std::erase_if(
      pieces, [&](const Interval& piece) { return piece.length() < rule.min_cut_length_mm - 2 * slack_mm; });
  out.dropped = static_cast<int>(dropped);
  if (rule.short_tows != ShortTows::drop) out.extended -= out.dropped;
  for (Interval& piece : pieces) {
    if (!run.closed) break;
    const double turn = piece.lo >= run.range.hi ? -round : piece.lo < run.range.lo ? round : 0;
    piece = {piece.lo + turn, piece.hi + turn};
  }
  std::sort(pieces.begin(), pieces.end(), [](const Interval& a, const Interval& b) { return a.lo < b.lo; });
  out.pieces = std::move(pieces);
  return out;
}

}  // namespace afptraj
