#include "scene/json_text.hpp"

#include <gtest/gtest.h>
#include <string>

#include "scene/error_check.hpp"

namespace palpate {
namespace {

std::string parse_problem(const std::string& text) {
  return message_of([&] { parse_json(text, "a.json"); });
}

TEST(ParseJson, TakesCommentsAnywhereButInStrings) {
  const auto json =
      parse_json("// first\n{\"a\": /* one */ [1, 2], // end\n \"b\": \"// no /* comment */\"}", "a.json");
  EXPECT_EQ(json, nlohmann::json({{"a", {1, 2}}, {"b", "// no /* comment */"}}));
}

TEST(ParseJson, AgreesWithTheLibrarysOwnDocument) {
  const std::string text =
      R"([{"a":[{"b":[]},[[],{}],null,true,false,-1,18446744073709551615,1.5e-3,"\u00e9\n"]}, {}])";
  EXPECT_EQ(parse_json(text, "a.json"), nlohmann::json::parse(text));
}

TEST(ParseJson, NamesLineAndColumnOfSyntaxErrors) {
  EXPECT_EQ(parse_problem("{\n  \"a\": 1,\n}"),
            "a.json: line 3, column 1: found '}', expected string literal");
  EXPECT_EQ(parse_problem("{\n  \"a\": 1\n  \"b\": 2\n}"),
            "a.json: line 3, column 3: found string literal, expected '}'");
  EXPECT_TRUE(parse_problem("[1,\n  tru]").starts_with("a.json: line 2, column 3: found invalid literal"))
      << parse_problem("[1,\n  tru]");
  EXPECT_TRUE(parse_problem("").starts_with("a.json: line 1, column 1: found end of input"))
      << parse_problem("");
  EXPECT_TRUE(
      parse_problem("{\"a\": 1").starts_with("a.json: line 1, column 7: found end of input, expected '}'"))
      << parse_problem("{\"a\": 1");
  EXPECT_TRUE(
      parse_problem("{} {}").starts_with("a.json: line 1, column 4: found '{', expected end of input"))
      << parse_problem("{} {}");
  EXPECT_TRUE(parse_problem("[NaN]").starts_with("a.json: line 1, column 2: found invalid literal"))
      << parse_problem("[NaN]");
  EXPECT_TRUE(parse_problem("{\"a\": \"\xff\"}").starts_with("a.json: line 1, column"))
      << parse_problem("{\"a\": \"\xff\"}");
}

TEST(ParseJson, RefusesNumbersBeyondDouble) {
  EXPECT_EQ(parse_problem("[0,\n -1e999]"),
            "a.json: line 2, column 2: found -1e999, expected a number that a double can hold");
}

TEST(ParseJson, RefusesRepeatedKeysOfOneObjectOnly) {
  EXPECT_EQ(parse_problem(R"({"a": 1, "a": 2})"),
            "a.json: a: found the key twice in one object, expected it once");
  EXPECT_EQ(parse_problem(R"({"b": [{"x": 1}, {"m": {"k": 0, "d": 1, "k": 0}}]})"),
            "a.json: b[1].m.k: found the key twice in one object, expected it once");
  EXPECT_EQ(parse_problem(R"([{"a": {"a": 1}}, {"a": 2}])"), "no error");
}

TEST(ParseJson, MessagesStayOnOneLine) {
  EXPECT_EQ(parse_problem("{\"a\\nb\": 1, \"a\\nb\": 2}").find('\n'), std::string::npos);
  EXPECT_EQ(parse_problem("[\"a\nb\"]").find('\n'), std::string::npos);
}

TEST(ParseJson, SurvivesDeepNesting) {
  EXPECT_NE(parse_problem(std::string(200000, '[')), "no error");
}

TEST(FormatJson, ReadsBackAsTheSame) {
  nlohmann::ordered_json json = nlohmann::ordered_json::parse(
      R"({"z": [1, 2.5, 0.1], "empty": {}, "none": [], "text": "a \"b\"", "deep": {"list": [{"x": 1}, [true, null]]}})");
  json["long"] = std::string(200, 'x');
  json["wide"] = {{"a", std::string(90, 'y')}, {"b", {1, 2, 3}}};
  const std::string text = format_json(json);
  EXPECT_EQ(nlohmann::ordered_json::parse(text), json);
  EXPECT_NE(text.find("\n  \"z\": [1, 2.5, 0.1],\n"), std::string::npos) << text;
}

}  // namespace
}  // namespace palpate
