#include <gtest/gtest.h>
#include <string>

#include "io/mesh_files.hpp"
#include "io/mesh_samples.hpp"

namespace palpate::io::testing {
namespace {

constexpr const char* plain_node = "5 3\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n4 1.5 0.1 -2.5e-4\n";
constexpr const char* plain_ele = "2 4 0\n0 0 1 2 3\n1 1 2 3 4\n";

std::string error_of_pair(std::string_view node, std::string_view ele) {
  const Folder folder;
  const auto path = folder.write("a.node", node);
  EXPECT_FALSE(folder.write("a.ele", ele).empty());
  return error_of(path);
}

std::string node_error(std::string_view part, std::string_view by) {
  return error_of_pair(replaced(tetgen_node, part, by), tetgen_ele);
}

std::string ele_error(std::string_view part, std::string_view by) {
  return error_of_pair(tetgen_node, replaced(tetgen_ele, part, by));
}

void expect_pair(std::string_view node, std::string_view ele, const std::string& stem) {
  const Folder folder;
  const auto node_path = folder.write(stem + ".node", node);
  const auto ele_path = folder.write(stem + ".ele", ele);
  for (const auto& path : {node_path, ele_path}) {
    const MeshFile file = read_mesh(path);
    EXPECT_TRUE(same_mesh(file.mesh, sample_mesh()));
    EXPECT_EQ(file.format, "TetGen");
    EXPECT_TRUE(file.dropped.empty());
  }
}

TEST(TetgenReader, ReadsNumbersFromOneWithAttributesMarkersAndComments) {
  expect_pair(tetgen_node, tetgen_ele, "a");
}
TEST(TetgenReader, ReadsNumbersFromZeroAndShortHeaders) {
  expect_pair(plain_node, plain_ele, "a");
}
TEST(TetgenReader, FindsTheOtherFileOfANumberedName) {
  expect_pair(plain_node, plain_ele, "liver.1");
}

TEST(TetgenReader, FindsTheOtherFileInUpperCase) {
  const Folder folder;
  const auto node = folder.write("A.NODE", plain_node);
  const auto ele = folder.write("A.ELE", plain_ele);
  EXPECT_TRUE(same_mesh(read_mesh(node).mesh, sample_mesh()));
  EXPECT_TRUE(same_mesh(read_mesh(ele).mesh, sample_mesh()));
}

TEST(TetgenReader, RefusesHalfOfThePair) {
  const Folder folder;
  EXPECT_EQ(error_of(folder.write("a.node", tetgen_node)),
            "a.ele: found no such file, expected the TetGen tets of " + (folder.path() / "a.node").string());
  EXPECT_EQ(
      error_of(folder.write("b.ele", tetgen_ele)),
      "b.node: found no such file, expected the TetGen points of " + (folder.path() / "b.ele").string());
}

TEST(TetgenReader, RefusesPointNumbersOutOfRange) {
  EXPECT_EQ(ele_error("2 2 3 4 5 7", "2 2 3 4 6 7"),
            "a.ele: line 3: found point number 6, expected one from 1 to 5");
  EXPECT_EQ(ele_error("2 2 3 4 5 7", "2 0 3 4 5 7"),
            "a.ele: line 3: found point number 0, expected one from 1 to 5");
  EXPECT_EQ(error_of_pair(plain_node, replaced(plain_ele, "1 2 3 4", "1 2 3 5")),
            "a.ele: line 3: found point number 5, expected one from 0 to 4");
}

TEST(TetgenReader, RefusesGapsInTheNumbers) {
  EXPECT_EQ(node_error("4 0 0 1", "5 0 0 1"), "a.node: line 7: found \"5\", expected point number 4");
  EXPECT_EQ(node_error("1 0 0 0", "2 0 0 0"),
            "a.node: line 3: found \"2\", expected the number of the first point from 0 to 1");
  EXPECT_EQ(ele_error("2 2 3 4 5", "3 2 3 4 5"), "a.ele: line 3: found \"3\", expected tet number 2");
}

TEST(TetgenReader, RefusesWhatIsNoNumber) {
  EXPECT_EQ(node_error("5 1.5", "5 one"),
            "a.node: line 8: found \"one\", expected a number (the x of a point)");
  EXPECT_EQ(node_error("5 1.5", "5 nan"),
            "a.node: line 8: found \"nan\", expected a finite number (the x of a point)");
  EXPECT_EQ(ele_error("2 2 3", "2 2 x"), "a.ele: line 3: found \"x\", expected an integer (a point number)");
}

TEST(TetgenReader, RefusesCountsThatLie) {
  EXPECT_EQ(node_error("5 3 1 1", "500000 3 1 1"),
            "a.node: line 2: found \"500000\", expected the number of points from 0 to 12, as many as the "
            "rest of the "
            "file can hold");
  EXPECT_EQ(node_error("5 3 1 1", "4 3 1 1"),
            "a.node: line 8: found \"5\", expected the end of the file behind the last point");
  EXPECT_EQ(node_error("5 3 1 1", "6 3 1 1"),
            "a.node: line 9: found the end of the file, expected a point number");
  EXPECT_EQ(node_error("5 3 1 1", "5 2 1 1"),
            "a.node: line 2: found \"2\", expected the dimension (only 3 is read) from 3 to 3");
  EXPECT_EQ(node_error("5 3 1 1", "5 3 1 0"),
            "a.node: line 3: found \"0\", expected the end of the point's line");
  EXPECT_EQ(ele_error("2 4 1", "2 4 0"), "a.ele: line 2: found \"7\", expected the end of the tet's line");
  EXPECT_EQ(ele_error("2 4 1", "2 5 1"), "a.ele: line 1: found \"5\", expected 4 or 10 points a tet");
  EXPECT_EQ(ele_error("2 4 1", "1 4 1"),
            "a.ele: line 3: found \"2\", expected the end of the file behind the last tet");
  EXPECT_EQ(ele_error("2 4 1", "3 4 1"), "a.ele: line 5: found the end of the file, expected a tet number");
}

TEST(TetgenReader, RefusesALastLineWithoutItsEnd) {
  EXPECT_EQ(error_of_pair(plain_node, "2 4 0\n0 0 1 2 3\n1 1 2 3 4"),
            "a.ele: line 3: found the end of the file inside the last line, expected a line end (without "
            "one, the last "
            "number may be cut off)");
}

TEST(TetgenReader, RefusesMeshesWithoutTets) {
  EXPECT_EQ(error_of_pair(plain_node, "0 4 0\n"), "a.ele: found no cells, expected at least one tet");
  EXPECT_EQ(error_of_pair("0 3 0 0\n", "0 4 0\n"), "a.node: found no points, expected at least four points");
}

}  // namespace
}  // namespace palpate::io::testing
