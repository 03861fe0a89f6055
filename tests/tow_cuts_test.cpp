// The rules in one dimension.
#include "boundary/tow_cuts.h"

#include <gtest/gtest.h>

#include <random>

namespace afptraj {
namespace {

void expect_stretches(const Stretches& found, const Stretches& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_DOUBLE_EQ(found[i].lo, expected[i].lo) << i;
    EXPECT_DOUBLE_EQ(found[i].hi, expected[i].hi) << i;
  }
}

/// A tow that runs onto the skin at 0 (left edge) and 10 (right), and off at 100 (left) and 120 (right).
TowCover slanted(double p) {
  TowCover cover;
  cover.left = {{0, 100}};
  cover.right = {{10, 120}};
  cover.middle = {{5, 110}};
  cover.from_left = {{10 * p, 100 + 20 * p}};
  cover.from_right = {{10 - 10 * p, 120 - 20 * p}};
  return cover;
}

TEST(CoverageRule, CutsAtItsShareBetweenTheEdges) {
  expect_stretches(apply_rule(slanted(0), 0), {{10, 100}});
  expect_stretches(apply_rule(slanted(0.5), 0.5), {{5, 110}});
  expect_stretches(apply_rule(slanted(1), 1), {{0, 120}});
  expect_stretches(apply_rule(slanted(0.25), 0.25), {{7.5, 105}});
  expect_stretches(apply_rule(slanted(0.8), 0.8), {{2, 116}});
}

TEST(CoverageRule, AHoleWithinTheTowCutsWhereItReachesTheMiddle) {
  TowCover cover;
  cover.left = cover.right = {{0, 100}};
  cover.middle = cover.from_left = cover.from_right = {{0, 40}, {50, 100}};
  expect_stretches(apply_rule(cover, 0.5), {{0, 40}, {50, 100}});
  expect_stretches(apply_rule(cover, 1), {{0, 100}});
}

TEST(CoverageRule, ATongueNarrowerThanTheTowIsLaidOnOnlyAtFull) {
  TowCover cover;
  cover.middle = cover.from_left = cover.from_right = {{20, 60}};
  EXPECT_TRUE(apply_rule(cover, 0.5).empty());
  cover.from_left = cover.from_right = {};
  expect_stretches(apply_rule(cover, 1), {{20, 60}});
}

CutRule rule_of(double least, double gap, ShortTows short_tows) {
  CutRule rule;
  rule.min_cut_length_mm = least;
  rule.min_gap_mm = gap;
  rule.short_tows = short_tows;
  return rule;
}

TEST(Pieces, GapsBelowTheMinimumAreLaidThrough) {
  const TowRun run{{0, 1000}};
  const CutResult cut = settle_pieces({{0, 300}, {324.9, 500}, {525, 1000}}, run, rule_of(0, 25, ShortTows::drop));
  expect_stretches(cut.pieces, {{0, 500}, {525, 1000}});
  EXPECT_EQ(cut.bridged, 1);
}

TEST(Pieces, ShortOnesAreExtendedOrDropped) {
  const TowRun run{{-200, 1000}};
  const Stretches one = {{100, 140}};
  expect_stretches(settle_pieces(one, run, rule_of(100, 0, ShortTows::symmetric)).pieces, {{70, 170}});
  expect_stretches(settle_pieces(one, run, rule_of(100, 0, ShortTows::forward)).pieces, {{100, 200}});
  expect_stretches(settle_pieces(one, run, rule_of(100, 0, ShortTows::backward)).pieces, {{40, 140}});
  const CutResult dropped = settle_pieces(one, run, rule_of(100, 0, ShortTows::drop));
  EXPECT_TRUE(dropped.pieces.empty());
  EXPECT_EQ(dropped.dropped, 1);
  EXPECT_EQ(dropped.extended, 0);
}

// What one end of the run cannot give the other does, where the rule lets it; else the piece is dropped.
TEST(Pieces, AreExtendedAsFarAsTheRunGoes) {
  const TowRun run{{90, 1000}};
  expect_stretches(settle_pieces({{100, 140}}, run, rule_of(100, 0, ShortTows::symmetric)).pieces, {{90, 190}});
  EXPECT_TRUE(settle_pieces({{100, 140}}, run, rule_of(100, 0, ShortTows::backward)).pieces.empty());
  EXPECT_TRUE(settle_pieces({{10, 20}}, {{0, 80}}, rule_of(100, 0, ShortTows::symmetric)).pieces.empty());
}

TEST(Pieces, ThatComeTooCloseByExtensionAreJoined) {
  const TowRun run{{0, 1000}};
  const CutResult cut = settle_pieces({{100, 140}, {180, 400}}, run, rule_of(100, 25, ShortTows::symmetric));
  expect_stretches(cut.pieces, {{70, 400}});
  EXPECT_EQ(cut.extended, 1);
  EXPECT_EQ(cut.bridged, 1);
}

TEST(Pieces, OnAClosedRunTheSeamIsNoPlace) {
  const TowRun run{{0, 1000}, true};
  // One piece over the seam.
  expect_stretches(settle_pieces({{0, 200}, {400, 1000}}, run, rule_of(100, 25, ShortTows::drop)).pieces,
                   {{400, 1200}});
  // The gap at the seam is laid through.
  expect_stretches(settle_pieces({{10, 200}, {400, 990}}, run, rule_of(100, 25, ShortTows::drop)).pieces, {{400, 1200}});
  // Every gap is: the tow is whole again.
  expect_stretches(settle_pieces({{10, 200}, {210, 990}}, run, rule_of(100, 25, ShortTows::drop)).pieces, {{0, 1000}});
  expect_stretches(settle_pieces({{0, 1000}}, run, rule_of(100, 25, ShortTows::drop)).pieces, {{0, 1000}});
}

// Twice is once, and what comes out holds both minima, whatever goes in.
TEST(Pieces, HoldTheMinimaAndStayWhatTheyAre) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> step(1, 130);
  for (int round = 0; round < 400; ++round) {
    Stretches pieces;
    for (double t = step(random); t < 900;) {
      const double end = t + step(random);
      pieces.push_back({t, end});
      t = end + step(random);
    }
    for (const bool closed : {false, true})
      for (const ShortTows how : {ShortTows::symmetric, ShortTows::forward, ShortTows::backward, ShortTows::drop}) {
        const TowRun run{{0, 1200}, closed};
        const CutRule rule = rule_of(100, 30, how);
        const CutResult once = settle_pieces(pieces, run, rule);
        for (std::size_t i = 0; i < once.pieces.size(); ++i) {
          EXPECT_GE(once.pieces[i].length(), 100 - 1e-6);
          const double before = i > 0 ? once.pieces[i - 1].hi : -30;
          EXPECT_GE(once.pieces[i].lo - before, 30 - 1e-6);
        }
        if (closed) continue;  // a piece beyond the seam is no input
        expect_stretches(settle_pieces(once.pieces, run, rule).pieces, once.pieces);
      }
  }
}

}  // namespace
}  // namespace afptraj
