#include <gtest/gtest.h>
#include <limits>
#include <string>

#include "io/mesh_files.hpp"
#include "io/mesh_samples.hpp"

namespace palpate::io::testing {
namespace {

std::string vtk_error_with(std::string_view good, std::string_view part, std::string_view by) {
  const Folder folder;
  return error_of(folder.write("a.vtk", replaced(good, part, by)));
}

TEST(VtkLegacyReader, RefusesOtherHeads) {
  EXPECT_EQ(vtk_error_with(vtk_5, "# vtk", "# VRML"), "a.vtk: line 1: found \"VRML\", expected vtk");
  EXPECT_EQ(vtk_error_with(vtk_5, "5.1", "7.0"),
            "a.vtk: line 1: found \"7.0\", expected a version from 1.0 to 5.1");
  EXPECT_EQ(vtk_error_with(vtk_5, "ASCII", "XML"), "a.vtk: line 3: found \"XML\", expected ASCII or BINARY");
  EXPECT_EQ(vtk_error_with(vtk_5, "UNSTRUCTURED_GRID", "STRUCTURED_GRID"),
            "a.vtk: line 4: found \"STRUCTURED_GRID\", expected UNSTRUCTURED_GRID or POLYDATA");
  const Folder folder;
  const auto surface = folder.write(
      "a.vtk",
      "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\n"
      "POLYGONS 1 4\n3 0 1 2\n");
  EXPECT_EQ(error_of(surface),
            "a.vtk: found PolyData, a surface, expected an unstructured grid with tets; 'palpate mesh' makes "
            "tets of a "
            "surface");
}

TEST(VtkLegacyReader, RefusesPointNumbersOutOfRange) {
  EXPECT_EQ(vtk_error_with(vtk_4, "4 1 2 3 4", "4 1 2 3 5"),
            "a.vtk: cell 2: found point number 5, expected one from 0 to 4");
  EXPECT_EQ(vtk_error_with(vtk_5, "1 2 3 4", "1 2 3 -4"),
            "a.vtk: cell 2: found point number -4, expected one from 0 to 4");
}

TEST(VtkLegacyReader, RefusesCellsThatDoNotFitTheirLists) {
  EXPECT_EQ(vtk_error_with(vtk_4, "3 0 1 2\n", "9 0 1 2\n"),
            "a.vtk: cell 1: found a cell beyond the end of the cell list, expected cells that fill the 14 "
            "numbers that "
            "the section announces");
  EXPECT_EQ(vtk_error_with(vtk_4, "CELLS 3 14", "CELLS 2 14"),
            "a.vtk: cells: found 5 numbers behind the last cell, expected none");
  EXPECT_EQ(vtk_error_with(vtk_5, "0 4 7 11", "0 4 3 11"),
            "a.vtk: cell 1: found offset 3, expected an offset from 4 to 11");
  EXPECT_EQ(vtk_error_with(vtk_5, "0 4 7 11", "1 4 7 11"), "a.vtk: OFFSETS: found 1 first, expected 0 first");
  EXPECT_EQ(vtk_error_with(vtk_5, "0 4 7 11", "0 4 7 10"),
            "a.vtk: cell 2: found 3 corners, expected 4 for a tetrahedron (cell type 10)");
  EXPECT_EQ(vtk_error_with(vtk_5, "10\n5\n10\n", "10\n10\n10\n"),
            "a.vtk: cell 1: found 3 corners, expected 4 for a tetrahedron (cell type 10)");
  EXPECT_EQ(vtk_error_with(vtk_5, "10\n5\n10\n", "10\n5\n99\n"),
            "a.vtk: cell 2: found cell type 99, expected one of VTK's cell types, 0 to 81");
  EXPECT_EQ(vtk_error_with(vtk_5, "CELL_TYPES 3\n10\n", "CELL_TYPES 2\n"),
            "a.vtk: found 3 cells and 2 cell types, expected the same number of both");
}

TEST(VtkLegacyReader, RefusesWhatIsNoNumber) {
  EXPECT_EQ(vtk_error_with(vtk_4, "1.5 0.1", "1.5 ?"),
            "a.vtk: line 10: found \"?\", expected a number (the y of a point)");
  EXPECT_EQ(vtk_error_with(vtk_4, "1.5 0.1", "1.5 nan"),
            "a.vtk: line 10: found \"nan\", expected a finite number (the y of a point)");
  EXPECT_EQ(vtk_error_with(vtk_4, "4 0 1 2 3", "4 0 1 2 3.0"),
            "a.vtk: line 12: found \"3.0\", expected an integer (a number of a cell)");
  EXPECT_EQ(vtk_error_with(vtk_4, "POINTS 5 double", "POINTS 5 string"),
            "a.vtk: line 8: found \"string\", expected a type of numbers such as float or int");
  EXPECT_EQ(vtk_error_with(vtk_5, "CONNECTIVITY vtktypeint64", "CONNECTIVITY double"),
            "a.vtk: line 14: found \"double\", expected a type of whole numbers");
}

TEST(VtkLegacyReader, RefusesInfinityInBinaryFiles) {
  for (const Sample& sample : vtk_legacy_by_vtk()) {
    if (sample.format != "VTK legacy binary") continue;
    const std::string one_and_a_half("\x3f\xf8\0\0\0\0\0\0", 8);
    const std::string infinity("\x7f\xf0\0\0\0\0\0\0", 8);
    EXPECT_EQ(vtk_error_with(sample.bytes, one_and_a_half, infinity),
              "a.vtk: byte " + std::to_string(sample.bytes.find(one_and_a_half)) +
                  ": found the point (inf, 0.1, -0.00025), expected finite coordinates");
  }
}

TEST(VtkLegacyReader, RefusesCountsThatLie) {
  EXPECT_EQ(vtk_error_with(vtk_4, "POINTS 5", "POINTS 2147483647"),
            "a.vtk: line 8: found \"2147483647\", expected the number of points from 0 to 18, as many as the "
            "rest of "
            "the file can hold");
  EXPECT_EQ(vtk_error_with(vtk_4, "POINTS 5", "POINTS 4"),
            "a.vtk: line 10: found \"1.5\", expected a section such as POINTS or CELLS");
  EXPECT_EQ(vtk_error_with(vtk_4, "POINTS 5", "POINTS 6"),
            "a.vtk: line 11: found \"CELLS\", expected a number (the x of a point)");
  for (const Sample& sample : vtk_legacy_by_vtk()) {
    const auto message = vtk_error_with(sample.bytes, "POINTS 5", "POINTS 50");
    EXPECT_NE(message.find("expected "), std::string::npos) << sample.name << ": " << message;
  }
}

TEST(VtkLegacyReader, RefusesFilesThatEndTooSoon) {
  EXPECT_EQ(vtk_error_with(vtk_4, "CELL_TYPES 3\n10\n5\n10\n", ""),
            "a.vtk: line 15: found the end of the file, expected the section CELL_TYPES");
  EXPECT_EQ(vtk_error_with(vtk_4, "5\n10\n", "5\n1"),
            "a.vtk: line 18: found the end of the file inside the last line, expected a line end (without "
            "one, the last "
            "number may be cut off)");
  EXPECT_EQ(vtk_error_with(vtk_4, "5\n10\n", "5\n"),
            "a.vtk: line 18: found the end of the file, expected a number of a cell");
}

TEST(VtkLegacyReader, RefusesMeshesWithoutTets) {
  EXPECT_EQ(vtk_error_with(vtk_4, "CELLS 3 14\n4 0 1 2 3\n3 0 1 2\n4 1 2 3 4\nCELL_TYPES 3\n10\n5\n10\n",
                           "CELLS 2 8\n3 0 1 2\n3 1 2 3\nCELL_TYPES 2\n5\n5\n"),
            "a.vtk: found 2 triangles and no tet, expected at least one tet");
  const Folder folder;
  EXPECT_EQ(
      error_of(folder.write("a.vtk",
                            "# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 0 float\n"
                            "CELLS 0 0\nCELL_TYPES 0\n")),
      "a.vtk: found no points, expected at least four points");
}

}  // namespace
}  // namespace palpate::io::testing
