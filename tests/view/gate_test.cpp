// Access rules of the server. Oracle: the rules of docs/viewer.md, one row each.
#include "view/gate.hpp"

#include <gtest/gtest.h>
#include <set>
#include <string>
#include <vector>

namespace palpate::view {
namespace {

const std::string token = "0123456789abcdef";

Verdict checked(const Knock& knock) {
  static const Gate gate(token, {"127.0.0.1", "localhost"}, 8080);
  return gate.check(knock);
}

TEST(Gate, LetsThePageIn) {
  EXPECT_EQ(checked({"GET", "/" + token + "/", "127.0.0.1:8080", {}}).status, 200);
  EXPECT_EQ(checked({"GET", "/" + token + "/app.js?x=1", "LOCALHOST:8080", "http://localhost:8080"}).path,
            "app.js");
  EXPECT_EQ(checked({"GET", "/" + token + "/socket", "localhost:8080", "http://localhost:8080", true}).status,
            200);
}

TEST(Gate, TurnsAwayForeignHosts) {
  const std::string target = "/" + token + "/";
  for (const char* host : {"", "evil.example:8080", "127.0.0.1", "127.0.0.1:80", "127.0.0.1:18080",
                           "127.0.0.1.evil.example:8080", "evil.example#127.0.0.1:8080", "@127.0.0.1:8080"}) {
    EXPECT_EQ(checked({"GET", target, host, {}}).status, 403) << host;
  }
}

TEST(Gate, TurnsAwayForeignOrigins) {
  const std::string target = "/" + token + "/socket";
  for (const char* origin :
       {"", "null", "http://evil.example", "https://localhost:8080", "http://localhost:80",
        "http://localhost:8080.evil.example", "http://127.0.0.1:8080"}) {
    EXPECT_EQ(checked({"GET", target, "localhost:8080", origin, true}).status, 403) << origin;
  }
  EXPECT_EQ(checked({"GET", target, "localhost:8080", {}, true}).status, 403)
      << "a socket must name its origin";
}

TEST(Gate, TurnsAwayWithoutTheToken) {
  for (const std::string& target : std::vector<std::string>{
           "/", "", "*", "/socket", "/0123456789abcdee/", "/0123456789abcde/", "/" + token + "0/",
           "//" + token + "/", "/x/../" + token + "/", "/?" + token}) {
    EXPECT_EQ(checked({"GET", target, "localhost:8080", {}}).status, 401) << target;
  }
}

TEST(Gate, AnswersGetOnly) {
  for (const char* method : {"POST", "PUT", "DELETE", "HEAD", "OPTIONS", "CONNECT", ""}) {
    EXPECT_EQ(checked({method, "/" + token + "/", "localhost:8080", {}}).status, 405) << method;
  }
}

TEST(Gate, TokensAreRandomAndChecked) {
  std::set<std::string> tokens;
  for (int i = 0; i < 100; ++i) {
    const std::string made = random_token();
    EXPECT_EQ(made.size(), 32U);
    EXPECT_TRUE(is_token(made));
    tokens.insert(made);
  }
  EXPECT_EQ(tokens.size(), 100U);
  for (const char* wrong : {"", "short", "0123456789abcdef/", "0123456789 abcdef", "0123456789abcde."}) {
    EXPECT_FALSE(is_token(wrong)) << wrong;
  }
  EXPECT_TRUE(equal_in_constant_time(token, token));
  EXPECT_FALSE(equal_in_constant_time(token, token + "0"));
  EXPECT_FALSE(equal_in_constant_time("", token));
}

}  // namespace
}  // namespace palpate::view
