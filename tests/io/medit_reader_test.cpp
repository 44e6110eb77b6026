#include <algorithm>
#include <gtest/gtest.h>
#include <span>
#include <string>

#include "io/mesh_files.hpp"
#include "io/mesh_samples.hpp"

namespace palpate::io::testing {
namespace {

std::string medit_error_with(std::string_view part, std::string_view by) {
  const Folder folder;
  return error_of(folder.write("a.mesh", replaced(medit, part, by)));
}

TEST(MeditReader, CountsEveryKindOfCell) {
  const std::string more =
      "Edges\n2\n1 2 0\n2 3 0\nCorners\n1\n4\nQuadrilaterals\n1\n1 2 3 4 0\nHexahedra\n1\n1 2 3 4 1 2 3 4 0\n"
      "Prisms\n1\n1 2 3 4 5 1 0\nPyramids\n1\n1 2 3 4 5 0\nTetrahedraP2\n1\n1 2 3 4 5 1 2 3 4 5 0\nEnd\n";
  const Folder folder;
  const MeshFile file = read_mesh(folder.write("a.mesh", replaced(medit, "End\n", more)));
  EXPECT_EQ(file.mesh.points, sample_mesh().points);
  ASSERT_GT(file.mesh.tets.size(), 2U);
  EXPECT_TRUE(std::ranges::equal(std::span(file.mesh.tets).first(2), sample_mesh().tets));
  const std::vector<std::pair<std::string, Index>> dropped{{"triangle", 1}, {"line", 2}, {"quad", 1}};
  EXPECT_EQ(file.dropped, dropped);
  std::vector<std::pair<std::string, Index>> converted;
  for (const ConvertedCells& cells : file.converted) converted.emplace_back(cells.kind, cells.cells);
  const std::vector<std::pair<std::string, Index>> expected{
      {"hexahedron", 1}, {"wedge", 1}, {"pyramid", 1}, {"tetrahedron10", 1}};
  EXPECT_EQ(converted, expected);
}

TEST(MeditReader, RefusesOtherHeads) {
  EXPECT_EQ(medit_error_with("MeshVersionFormatted", "MeshVersion"),
            "a.mesh: line 1: found \"MeshVersion\", expected MeshVersionFormatted");
  EXPECT_EQ(medit_error_with("Formatted 2", "Formatted 9"),
            "a.mesh: line 1: found \"9\", expected the version of the Medit format from 1 to 4");
  EXPECT_EQ(medit_error_with("Dimension\n3", "Dimension\n2"),
            "a.mesh: line 4: found \"2\", expected Dimension 3");
  EXPECT_EQ(medit_error_with("Dimension\n3\n", ""),
            "a.mesh: line 3: found \"Vertices\", expected Dimension 3 before Vertices");
}

TEST(MeditReader, RefusesPointNumbersOutOfRange) {
  EXPECT_EQ(medit_error_with("2 3 4 5 1", "2 3 4 6 1"),
            "a.mesh: line 21: found point number 6, expected one from 1 to 5");
  EXPECT_EQ(medit_error_with("1 2 3 4 1", "0 2 3 4 1"),
            "a.mesh: line 20: found point number 0, expected one from 1 to 5");
}

TEST(MeditReader, RefusesWhatIsNoNumber) {
  EXPECT_EQ(medit_error_with("1.5 0.1", "1.5 abc"),
            "a.mesh: line 11: found \"abc\", expected a number (the y of a point)");
  EXPECT_EQ(medit_error_with("1.5 0.1", "NaN 0.1"),
            "a.mesh: line 11: found \"NaN\", expected a finite number (the x of a point)");
  EXPECT_EQ(medit_error_with("1.5 0.1", "inf 0.1"),
            "a.mesh: line 11: found \"inf\", expected a finite number (the x of a point)");
  EXPECT_EQ(medit_error_with("1 2 3 4 1", "1 2 3.5 4 1"),
            "a.mesh: line 20: found \"3.5\", expected an integer (a point number)");
  EXPECT_EQ(medit_error_with("1.5 0.1", "\x01\xff 0.1"),
            "a.mesh: line 11: found \"\\x01\\xff\", expected a number (the x of a point)");
}

TEST(MeditReader, RefusesCountsThatLie) {
  EXPECT_EQ(medit_error_with("Vertices\n5", "Vertices\n2000000000"),
            "a.mesh: line 6: found \"2000000000\", expected the number of vertices from 0 to 15, as many as "
            "the rest of "
            "the file can hold");
  EXPECT_EQ(medit_error_with("Vertices\n5", "Vertices\n4"),
            "a.mesh: line 11: found \"1.5\", expected a keyword");
  EXPECT_EQ(medit_error_with("Vertices\n5", "Vertices\n6"),
            "a.mesh: line 12: found \"Triangles\", expected a number (the x of a point)");
  EXPECT_EQ(medit_error_with("Tetrahedra\n2", "Tetrahedra\n99999999999999999999"),
            "a.mesh: line 19: found \"99999999999999999999\", expected an integer (the number of cells)");
}

TEST(MeditReader, RefusesFilesThatEndTooSoon) {
  EXPECT_EQ(medit_error_with("End\n", ""),
            "a.mesh: line 22: found the end of the file, expected the keyword End (the file may be cut off)");
  EXPECT_EQ(medit_error_with("4 5 1\nEnd\n", "4 5 "),
            "a.mesh: line 21: found the end of the file, expected the reference of a cell");
}

TEST(MeditReader, RefusesSectionsOutOfOrderOrTwice) {
  EXPECT_EQ(medit_error_with("Vertices\n5", "Tetrahedra\n1\n1 2 3 4 0\nVertices\n5"),
            "a.mesh: line 5: found \"Tetrahedra\", expected Vertices before Tetrahedra");
  EXPECT_EQ(medit_error_with("End", "Vertices\n1\n0 0 0 0\nEnd"),
            "a.mesh: line 22: found \"Vertices\", expected only one section Vertices");
}

TEST(MeditReader, RefusesMeshesWithoutTets) {
  EXPECT_EQ(medit_error_with("Tetrahedra\n2\n1 2 3 4 1\n2 3 4 5 1\n", ""),
            "a.mesh: found 1 triangle and no tet, expected at least one tet");
  const Folder folder;
  EXPECT_EQ(error_of(folder.write("a.mesh", "MeshVersionFormatted 1\nDimension 3\nEnd\n")),
            "a.mesh: found no points, expected at least four points");
}

}  // namespace
}  // namespace palpate::io::testing
