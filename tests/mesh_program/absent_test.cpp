#include <array>
#include <cstdio>
#include <memory>

#include "apps/workplace.hpp"

namespace palpate::test {
namespace {

/// The command alone, as in a build without CGAL, says what is missing in one line.
TEST_F(CommandTest, WithoutItsProgramMeshSaysSo) {
  std::filesystem::copy_file(PALPATE_COMMAND, folder_ / "palpate");
  const std::string call = (folder_ / "palpate").string() + " mesh map.nrrd 2>&1; echo $?";
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(::popen(call.c_str(), "r"), ::pclose);
  std::array<char, 4096> text{};
  const std::string said(text.data(), std::fread(text.data(), 1, text.size(), pipe.get()));
  ASSERT_EQ(lines_of(said).size(), 2U) << said;
  EXPECT_TRUE(said.starts_with("palpate: error: mesh: found no '")) << said;
  EXPECT_NE(said.find("libcgal-dev"), std::string::npos);
  EXPECT_EQ(lines_of(said)[1], "2");
}

}  // namespace
}  // namespace palpate::test
