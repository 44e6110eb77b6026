#include <algorithm>
#include <sstream>

#include "apps/workplace.hpp"

namespace palpate::test {
namespace {

class ProgressOf : public CommandTest {
 protected:
  void SetUp() override { write("scene.json", falling_box()); }
};

TEST_F(ProgressOf, ALogGetsPlainLines) {
  const Finished done = palpate({"run", "scene.json", "--json", "--no-picture"});
  EXPECT_EQ(done.exit_code, 0);
  EXPECT_TRUE(Json::accept(done.out)) << "nothing but JSON on stdout";
  EXPECT_EQ(done.err.find('\x1b'), std::string::npos);
  EXPECT_EQ(done.err.find('\r'), std::string::npos);
  const auto lines = lines_of(done.err);
  ASSERT_FALSE(lines.empty());
  EXPECT_NE(lines.back().find("step 10/10  100%"), std::string::npos) << done.err;
  EXPECT_NE(lines.back().find("ms/step"), std::string::npos) << done.err;
}

TEST_F(ProgressOf, ATerminalGetsOneLineThatFits) {
  constexpr int columns = 34;
  const std::string text =
      palpate_on_terminal({"run", "scene.json", "--quiet", "--no-picture"}, folder_.path(), columns);
  EXPECT_EQ(text, "");
  const std::string shown = palpate_on_terminal(
      {"run", "scene.json", "--steps", "200", "--json", "--no-picture"}, folder_.path(), columns);
  const std::string progress = shown.substr(0, shown.find("\r\n"));  // then comes the JSON
  EXPECT_NE(progress.find("step 200/200  100%"), std::string::npos) << progress;
  EXPECT_EQ(progress.find('\n'), std::string::npos) << "rewritten in place";
  std::istringstream stream(progress);
  for (std::string part; std::getline(stream, part, '\r');)
    EXPECT_LT(part.size(), std::size_t{columns}) << part;
}

}  // namespace
}  // namespace palpate::test
