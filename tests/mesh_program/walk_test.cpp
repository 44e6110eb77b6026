#include <cmath>
#include <iterator>
#include <sstream>

#include "mesh_program/meshed.hpp"

namespace palpate::test {
namespace {

/// The words of each line of docs/your-own-anatomy.md that calls the command in a block of shell.
std::vector<std::vector<std::string>> calls_of_the_page() {
  const std::string page = content_of(std::string(PALPATE_SOURCE_DIR) + "/docs/your-own-anatomy.md");
  std::vector<std::vector<std::string>> calls;
  bool in_shell = false;
  for (const std::string& line : lines_of(page)) {
    if (line.starts_with("```")) in_shell = line == "```sh";
    if (!in_shell || !line.starts_with("palpate ")) continue;
    std::istringstream words(line.substr(8));
    calls.emplace_back(std::istream_iterator<std::string>(words), std::istream_iterator<std::string>());
  }
  return calls;
}

/// A bone with a hollow, in it a soft ball, and a nerve through both, as 3D Slicer would save them.
std::string organs() {
  const TestMap map({36, 30, 30}, [](int i, int j, int k) {
    const double r = std::sqrt((i - 15) * (i - 15) + (j - 15) * (j - 15) + (k - 15) * (k - 15));
    if (i >= 15 && std::hypot(j - 15, k - 15) < 2.5) return r < 8.5 ? 2 : (i < 33 ? 3 : 0);
    return r < 8.5 ? 2 : (r < 12.5 ? 1 : 0);
  });
  return nrrd(map, "left-posterior-superior",
              segment(0, 1, "bone", "0.9 0.9 0.7") + segment(1, 2, "fat", "1 0.9 0.2") +
                  segment(2, 3, "nerve", "1 1 0"));
}

/// The commands of docs/your-own-anatomy.md work in order.
TEST_F(MeshProgram, ThePageLeadsFromALabelMapToARunningScene) {
  write("organs.seg.nrrd", organs());
  const auto calls = calls_of_the_page();
  ASSERT_EQ(calls.size(), 3U);
  EXPECT_EQ(calls[0][0], "mesh");
  EXPECT_EQ(calls[1][0], "info");
  EXPECT_EQ(calls[2][0], "run");
  for (const auto& call : calls) output_of(call);
  const Json run = Json::parse(read("results/organs/run.json"));
  EXPECT_EQ(run["at_rest"], true);
  EXPECT_EQ(run["bodies"].size(), 3U);
  EXPECT_TRUE(exists("results/organs/picture.png"));
}

}  // namespace
}  // namespace palpate::test
