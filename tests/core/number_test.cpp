#include "stiction/core/number.hpp"

#include <gtest/gtest.h>

#include <clocale>
#include <cmath>
#include <limits>
#include <string>

namespace stiction::core {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(ParseNumber, ReadsWhatFilesWrite) {
  EXPECT_EQ(parse_number("0.25"), 0.25);
  EXPECT_EQ(parse_number("+1e3"), 1000);
  EXPECT_EQ(parse_number("-.5"), -0.5);
  EXPECT_EQ(parse_number("7."), 7);
  EXPECT_EQ(parse_number("-inf"), -kInfinity);
  EXPECT_TRUE(std::isnan(parse_number("nan").value()));
  EXPECT_TRUE(std::signbit(parse_number("-0").value()));
}

TEST(ParseNumber, TooLarge_IsInfinite_TooSmall_IsZero) {
  EXPECT_EQ(parse_number("1e999"), kInfinity);
  EXPECT_EQ(parse_number("-1.5E+999"), -kInfinity);
  EXPECT_EQ(parse_number("1" + std::string(400, '0')), kInfinity);
  EXPECT_EQ(parse_number("1" + std::string(400, '0') + ".0e+00"), kInfinity);
  EXPECT_EQ(parse_number("1" + std::string(400, '0') + "e-50"), kInfinity);
  EXPECT_EQ(parse_number("1e99999999999999999999"), kInfinity);
  EXPECT_EQ(parse_number("1e-99999999999999999999"), 0);
  EXPECT_EQ(parse_number("0." + std::string(500, '0') + "1e50"), 0);
  EXPECT_EQ(parse_number("1e-999"), 0);
  EXPECT_EQ(parse_number("0." + std::string(400, '0') + "1"), 0);
  EXPECT_TRUE(std::signbit(parse_number("-1e-999").value()));
}

TEST(ParseNumber, WhatIsNoNumber_IsNone) {
  for (const char* text : {"", "+", "-", "--1", "+-1", "-+1", "1,5", "3.14rad", "abc", "0x10", " 1", "1 ", "1e", "."})
    EXPECT_FALSE(parse_number(text)) << "'" << text << "'";
}

TEST(TakeNumber, LeavesTheRestOfTheText) {
  std::string_view text = "1.5 2";
  EXPECT_EQ(take_number(text), 1.5);
  EXPECT_EQ(text, " 2");
  EXPECT_FALSE(take_number(text));
  EXPECT_EQ(text, " 2");
}

TEST(ParseNumber, IsTheSameInEveryLocale) {
  const std::string before = std::setlocale(LC_NUMERIC, nullptr);
  for (const char* locale : {"de_DE.UTF-8", "fr_FR.UTF-8", "de_DE.ISO-8859-1", "C"}) {
    if (std::setlocale(LC_NUMERIC, locale) == nullptr) continue;
    EXPECT_EQ(parse_number("1.5"), 1.5) << locale;
    EXPECT_EQ(parse_number("1.5e999"), kInfinity) << locale;
    EXPECT_FALSE(parse_number("1,5")) << locale;
  }
  std::setlocale(LC_NUMERIC, before.c_str());
}

}  // namespace
}  // namespace stiction::core
