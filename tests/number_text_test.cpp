#include "io/number_text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <locale>
#include <random>

#include "geometry/error.h"

namespace afptraj {
namespace {

// One unit of the last decimal, and the rounding of the double and of the scaled value.
double allowed(double x, int decimals) { return std::pow(10.0, -decimals) + 4e-16 * std::abs(x); }

TEST(NumberText, ReadsBackToTheLastDecimal) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> mantissa(-1, 1), exponent(-12, 6.5);
  for (int i = 0; i < 200000; ++i) {
    const double x = mantissa(random) * std::pow(10, exponent(random));
    for (const int decimals : {0, 3, 9, 12}) {
      const auto back = parse_number(number_text(x, decimals));
      ASSERT_TRUE(back) << number_text(x, decimals);
      ASSERT_LE(std::abs(*back - x), allowed(x, decimals)) << number_text(x, decimals);
    }
  }
}

// No text with one digit less holds the bound: try both neighbours.
TEST(NumberText, IsTheShortest) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> some(-2000, 2000);
  for (int i = 0; i < 20000; ++i) {
    const double x = some(random);
    const std::string text = number_text(x);
    const std::size_t point = text.find('.');
    if (point == std::string::npos) continue;
    const double unit = std::pow(10.0, -static_cast<double>(text.size() - point - 2));
    for (const double shorter : {std::floor(x / unit) * unit, std::ceil(x / unit) * unit}) {
      ASSERT_GT(std::abs(shorter - x), 1e-9 * (1 - 1e-4)) << text;
    }
  }
}

TEST(NumberText, KnownTexts) {
  EXPECT_EQ(number_text(0), "0");
  EXPECT_EQ(number_text(-0.0), "0");
  EXPECT_EQ(number_text(-1e-10), "0");
  EXPECT_EQ(number_text(0.5), "0.5");
  EXPECT_EQ(number_text(-12.5), "-12.5");
  EXPECT_EQ(number_text(0.1 + 0.2), "0.3");
  EXPECT_EQ(number_text(100), "100");
  EXPECT_EQ(number_text(1e-9), "0");  // zero is within 1e-9
  EXPECT_EQ(number_text(2e-9), "0.000000002");
  EXPECT_EQ(number_text(0.1234567891), "0.12345679");
  EXPECT_EQ(number_text(999999.9999999999), "1000000");
  EXPECT_EQ(number_text(1.0 / 3, 3), "0.333");
  EXPECT_EQ(number_text(2.6, 0), "3");
}

TEST(NumberText, LargeNumbersKeepEveryDigit) {
  for (const double x : {1e15, 123456789012.34567, -9.87654321e300, std::numeric_limits<double>::max()}) {
    EXPECT_EQ(*parse_number(number_text(x)), x);
  }
}

TEST(NumberText, RefusesWhatIsNotANumber) {
  for (const double x :
       {std::nan(""), std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()}) {
    try {
      number_text(x);
      FAIL() << "a NaN or infinity was written";
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::internal);
    }
  }
}

TEST(ParseNumber, TakesTheWholeText) {
  EXPECT_EQ(parse_number("12.5"), 12.5);
  EXPECT_EQ(parse_number(" +1e3\t"), 1000);
  EXPECT_EQ(parse_number("-.5"), -0.5);
  for (const char* text : {"", " ", "12,5", "1 2", "1x", "nan", "inf", "1e999", "0x10", "--1", "+-1", "1e"}) {
    EXPECT_FALSE(parse_number(text)) << text;
  }
}

// A global locale with a decimal comma changes nothing.
struct CommaPunctuation : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
};
TEST(NumberText, IgnoresTheLocale) {
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new CommaPunctuation));
  EXPECT_EQ(number_text(1.5), "1.5");
  EXPECT_EQ(parse_number("1.5"), 1.5);
  std::locale::global(before);
}

}  // namespace
}  // namespace afptraj
