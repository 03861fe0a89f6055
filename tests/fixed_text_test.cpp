#include "winding/fixed_text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <random>

#include "geometry/error.h"
#include "winding/number_words.h"

namespace afptraj {
namespace {

// The C library rounds the exact binary value, halves to even.
std::string reference(double x) {
  char buffer[400];
  std::snprintf(buffer, sizeof buffer, "%.6f", x);
  std::string text = buffer;
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

TEST(FixedText, IsTheCLibrarysOnAllSizes) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> mantissa(-1, 1), exponent(-8, 14);
  for (int i = 0; i < 500000; ++i) {
    const double x = mantissa(random) * std::pow(10, exponent(random));
    ASSERT_EQ(fixed_text(x, true), reference(x));
  }
}

// k / 2^7 has its seventh decimal exactly at 5 for odd k: a tie, which must go to the even digit. Beside
// it, the neighbouring doubles must not.
TEST(FixedText, TiesGoToEvenAndTheirNeighboursDoNot) {
  for (int k = -20001; k <= 20001; k += 2) {
    for (const double x : {k / 128.0, std::nextafter(k / 128.0, 1e9), std::nextafter(k / 128.0, -1e9)}) {
      ASSERT_EQ(fixed_text(x, true), reference(x)) << k;
    }
  }
  EXPECT_EQ(fixed_text(1 / 128.0), "0.007812");
  EXPECT_EQ(fixed_text(3 / 128.0), "0.023438");
}

TEST(FixedText, ZeroFromBelow) {
  EXPECT_EQ(fixed_text(-1e-7, true), "-0");
  EXPECT_EQ(fixed_text(-0.0, true), "-0");
  EXPECT_EQ(fixed_text(-1e-7), "0");
  EXPECT_EQ(fixed_text(-5.1e-7), "-0.000001");
  EXPECT_EQ(fixed_text(0, true), "0");
}

TEST(FixedText, RefusesWhatIsNotANumber) {
  EXPECT_THROW(fixed_text(std::numeric_limits<double>::infinity()), Error);
  EXPECT_THROW(fixed_text(std::nan("")), Error);
  EXPECT_EQ(fixed_text(1e300).size(), 301u);
}

TEST(NumberWords, KnownTexts) {
  EXPECT_EQ(shortest_text(95), "95.0");
  EXPECT_EQ(shortest_text(7 * 180.0 / 13), "96.92307692307692");
  EXPECT_EQ(shortest_text(1e16), "1e+16");
  EXPECT_EQ(shortest_text(1e15), "1000000000000000.0");
  EXPECT_EQ(shortest_text(1e-5), "1e-05");
  EXPECT_EQ(shortest_text(1e-4), "0.0001");
  EXPECT_EQ(significant_text(193.84615384, 6), "193.846");
  EXPECT_EQ(significant_text(180, 6), "180");
  EXPECT_EQ(significant_text(1e6, 6), "1e+06");
  EXPECT_EQ(header_number(70), "70");
  EXPECT_EQ(header_number(63.5), "63.5");
  EXPECT_EQ(header_number(1e22), "10000000000000000000000");
}

}  // namespace
}  // namespace afptraj
