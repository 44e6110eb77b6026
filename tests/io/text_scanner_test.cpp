#include "io/text_scanner.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include <palpate/error.hpp>

namespace palpate::io {
namespace {

double number(std::string_view text) {
  return TextScanner("t", text).number("x");
}

std::string number_error(std::string_view text) {
  try {
    number(text);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(TextScanner, ReadsNumbersToTheLastBit) {
  EXPECT_EQ(number("0.1"), 0.1);
  EXPECT_EQ(number("-2.5e-4"), -2.5e-4);
  EXPECT_EQ(number("+1.5E+3"), 1500.0);
  EXPECT_EQ(number("1.7976931348623157e308"), std::numeric_limits<double>::max());
  EXPECT_EQ(number("5e-324"), std::numeric_limits<double>::denorm_min());
  EXPECT_EQ(number(".5"), 0.5);
}

TEST(TextScanner, TakesNumbersTooSmallForADoubleAsZero) {
  EXPECT_EQ(number("1e-400"), 0.0);
  EXPECT_TRUE(std::signbit(number("-1e-400")));
  EXPECT_EQ(number("0." + std::string(400, '0') + "1"), 0.0);
}

TEST(TextScanner, RefusesWhatIsNoFiniteNumber) {
  EXPECT_EQ(number_error("1e400"), "t: line 1: found \"1e400\", expected a finite number (x)");
  EXPECT_EQ(number_error("-inf"), "t: line 1: found \"-inf\", expected a finite number (x)");
  EXPECT_EQ(number_error("1,5"), "t: line 1: found \"1,5\", expected a number (x)");
  EXPECT_EQ(number_error("+-1"), "t: line 1: found \"+-1\", expected a number (x)");
  EXPECT_EQ(number_error("0x10"), "t: line 1: found \"0x10\", expected a number (x)");
  EXPECT_EQ(number_error("+"), "t: line 1: found \"+\", expected a number (x)");
  EXPECT_EQ(number_error(" \n"), "t: line 2: found the end of the file, expected x");
}

TEST(TextScanner, KnowsTheLineOfTheLastWord) {
  TextScanner scanner("t", "a # b\r\n# c\n\n d", '#');
  EXPECT_EQ(scanner.word("x"), "a");
  EXPECT_TRUE(scanner.at_line_end());
  EXPECT_EQ(scanner.peek(), "d");
  EXPECT_EQ(scanner.word("x"), "d");
  EXPECT_TRUE(scanner.at_end());
  try {
    scanner.fail("another word");
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "t: line 4: found \"d\", expected another word");
    EXPECT_EQ(error.where(), "line 4");
  }
}

TEST(TextScanner, BoundsCountsByWhatIsLeft) {
  EXPECT_EQ(TextScanner("t", "3 1 2 3").count("items", 2), 3);
  EXPECT_THROW(TextScanner("t", "4 1 2 3").count("items", 2), Error);
  EXPECT_THROW(TextScanner("t", "-1 1 2 3").count("items", 2), Error);
}

TEST(TextScanner, KeepsQuotedWordsOnOneShortLine) {
  EXPECT_EQ(in_quotes("a\nb"), "\"a\\x0ab\"");
  EXPECT_EQ(in_quotes(std::string(100, 'a')), "\"" + std::string(40, 'a') + "\"…");
}

}  // namespace
}  // namespace palpate::io
