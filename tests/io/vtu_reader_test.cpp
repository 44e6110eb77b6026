#include <gtest/gtest.h>
#include <string>

#include "io/mesh_files.hpp"
#include "io/mesh_samples.hpp"

namespace palpate::io::testing {
namespace {

std::string vtu_error_with(std::string_view part, std::string_view by) {
  const Folder folder;
  return error_of(folder.write("a.vtu", replaced(vtu_ascii, part, by)));
}

TEST(VtuReader, JoinsPieces) {
  const std::string text = vtu_ascii;
  const auto begin = text.find("<Piece");
  const auto end = text.find("</Piece>") + 9;
  const Folder folder;
  const MeshFile file = read_mesh(folder.write("a.vtu", text.substr(0, end) + text.substr(begin)));
  TetMesh twice = sample_mesh();
  for (const Vec3& point : sample_mesh().points) twice.points.push_back(point);
  for (const Tet& tet : sample_mesh().tets)
    twice.tets.push_back({tet[0] + 5, tet[1] + 5, tet[2] + 5, tet[3] + 5});
  EXPECT_TRUE(same_mesh(file.mesh, twice));
  EXPECT_EQ(file.dropped.at(0).second, 2);
}

TEST(VtuReader, RefusesOtherFiles) {
  EXPECT_EQ(vtu_error_with("type=\"UnstructuredGrid\"", "type=\"PolyData\""),
            "a.vtu: line 3: found a VTKFile of type \"PolyData\", expected type \"UnstructuredGrid\"");
  EXPECT_EQ(
      vtu_error_with("type=\"UnstructuredGrid\"", "type=\"UnstructuredGrid\" compressor=\"zip\""),
      "a.vtu: line 3: found compressor=\"zip\", expected vtkZLibDataCompressor, vtkLZ4DataCompressor or "
      "vtkLZMADataCompressor");
  EXPECT_EQ(vtu_error_with("<?xml version=\"1.0\"?>", "solid liver"),
            "a.vtu: line 1: found \"solid liver\\x0a\", expected an XML tag");
}

TEST(VtuReader, RefusesTagsThatDoNotNest) {
  EXPECT_EQ(vtu_error_with("</Points>", ""), "a.vtu: line 25: found </Piece>, expected </Points>");
  EXPECT_EQ(vtu_error_with("</VTKFile>", ""),
            "a.vtu: line 28: found the end of the file, expected </VTKFile>");
  EXPECT_EQ(vtu_error_with("</VTKFile>", "</VTKFile"),
            "a.vtu: line 28: found the end of the file inside a tag, expected the tag's end");
  EXPECT_EQ(vtu_error_with("NumberOfPoints=\"5\"", "NumberOfPoints=\"5"),
            "a.vtu: line 5: found \"\"\", expected \"=\" after 3");
}

TEST(VtuReader, RefusesPointNumbersOutOfRange) {
  EXPECT_EQ(vtu_error_with("1 2 3 4", "1 2 3 5"),
            "a.vtu: cell 2: found point number 5, expected one from 0 to 4");
}

TEST(VtuReader, RefusesWhatIsNoNumber) {
  EXPECT_EQ(vtu_error_with("1.5 0.1", "1.5 a"),
            "a.vtu: line 9: found \"a\", expected a number (a number of Points)");
  EXPECT_EQ(vtu_error_with("1.5 0.1", "1.5 nan"),
            "a.vtu: line 9: found \"nan\", expected a finite number (a number of Points)");
  EXPECT_EQ(vtu_error_with("4 7 11", "4 7 1.1"),
            "a.vtu: line 19: found \"1.1\", expected an integer (a number of offsets)");
  EXPECT_EQ(vtu_error_with("NumberOfPoints=\"5\"", "NumberOfPoints=\"five\""),
            "a.vtu: line 5: found NumberOfPoints=\"five\", expected a whole number, 0 or more");
}

TEST(VtuReader, RefusesCountsThatLie) {
  EXPECT_EQ(vtu_error_with("NumberOfPoints=\"5\"", "NumberOfPoints=\"6\""),
            "a.vtu: line 10: found the end of the file, expected 18 numbers of Points");
  EXPECT_EQ(vtu_error_with("NumberOfPoints=\"5\"", "NumberOfPoints=\"4\""),
            "a.vtu: line 9: found \"1.5\", expected only 12 numbers of Points");
  EXPECT_EQ(vtu_error_with("NumberOfPoints=\"5\"", "NumberOfPoints=\"2000000000\""),
            "a.vtu: line 10: found the end of the file, expected 6000000000 numbers of Points");
  EXPECT_EQ(vtu_error_with("NumberOfPoints=\"5\"", "NumberOfPoints=\"9000000000\""),
            "a.vtu: piece 0: found 9000000000 points and 3 cells, expected at most 2147483647 of each in all "
            "pieces");
  EXPECT_EQ(vtu_error_with("4 7 11", "4 7 12"),
            "a.vtu: line 17: found the end of the file, expected 12 numbers of connectivity");
  EXPECT_EQ(vtu_error_with("NumberOfComponents=\"3\"", "NumberOfComponents=\"2\""),
            "a.vtu: array Points: found 2 components, expected 3");
  const Folder folder;
  for (const Sample& sample : vtu_by_vtk()) {
    for (const char* count : {"6", "4", "700000000"}) {
      const std::string by = "NumberOfPoints=\"" + std::string(count) + "\"";
      const auto message =
          error_of(folder.write("a.vtu", replaced(sample.bytes, "NumberOfPoints=\"5\"", by)));
      EXPECT_NE(message.find(": found "), std::string::npos) << sample.name << ": " << message;
    }
  }
}

TEST(VtuReader, RefusesMissingArrays) {
  EXPECT_EQ(vtu_error_with("Name=\"types\"", "Name=\"kinds\""),
            "a.vtu: piece 0: found no array of types, expected one");
  EXPECT_EQ(vtu_error_with("Name=\"types\"", "Name=\"offsets\""),
            "a.vtu: line 21: found a second array of offsets, expected one");
  EXPECT_EQ(vtu_error_with("Int32\" Name=\"offsets", "Float32\" Name=\"offsets"),
            "a.vtu: array offsets: found a type with fractions, expected a type of whole numbers");
  EXPECT_EQ(vtu_error_with("Int32\" Name=\"offsets", "String\" Name=\"offsets"),
            "a.vtu: line 18: found type=\"String\" of offsets, expected a type of numbers such as Float64 or "
            "Int32");
}

TEST(VtuReader, RefusesMeshesWithoutTets) {
  EXPECT_EQ(
      vtu_error_with("0 1 2 3\n0 1 2\n1 2 3 4\n</DataArray>\n<DataArray type=\"Int32\" Name=\"offsets\" "
                     "format=\"ascii\">\n4 7 11\n</DataArray>\n"
                     "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">\n10 5 10",
                     "0 1 2 0 1 2 1 2 3\n</DataArray>\n<DataArray type=\"Int32\" Name=\"offsets\" "
                     "format=\"ascii\">\n3 6 9\n</DataArray>\n"
                     "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">\n5 5 5"),
      "a.vtu: found 3 triangles and no tet, expected at least one tet");
  const Folder folder;
  EXPECT_EQ(
      error_of(folder.write("a.vtu", "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid/></VTKFile>")),
      "a.vtu: found no points, expected at least four points");
}

}  // namespace
}  // namespace palpate::io::testing
