#include <array>
#include <bit>
#include <gtest/gtest.h>
#include <limits>
#include <string>

#include "io/mesh_files.hpp"
#include "io/mesh_samples.hpp"

namespace palpate::io::testing {
namespace {

std::string gmsh_error_with(std::string_view good, std::string_view part, std::string_view by) {
  const Folder folder;
  return error_of(folder.write("a.msh", replaced(good, part, by)));
}

std::string int_bytes(std::int32_t value) {
  const auto raw = std::bit_cast<std::array<char, 4>>(value);
  return {raw.begin(), raw.end()};
}

std::string double_bytes(double value) {
  const auto raw = std::bit_cast<std::array<char, 8>>(value);
  return {raw.begin(), raw.end()};
}

std::string size_bytes(std::uint64_t value) {
  const auto raw = std::bit_cast<std::array<char, 8>>(value);
  return {raw.begin(), raw.end()};
}

TEST(GmshReader, RefusesOtherVersionsAndFiles) {
  EXPECT_EQ(gmsh_error_with(gmsh_2, "2.2 0", "3 0"),
            "a.msh: line 2: found Gmsh format \"3\", expected format 1, 2, 2.1, 2.2, 4.0 or 4.1");
  EXPECT_EQ(gmsh_error_with(gmsh_2, "2.2 0", "2.2 2"),
            "a.msh: line 2: found \"2\", expected the file type: 0 for ASCII, 1 for binary from 0 to 1");
  EXPECT_EQ(gmsh_error_with(gmsh_2, "$MeshFormat", "solid"),
            "a.msh: line 1: found \"solid\", expected $MeshFormat or $NOD");
  EXPECT_EQ(gmsh_error_with(gmsh_2_binary(false), "2.2 1 8", "2.2 1 4"),
            "a.msh: line 2: found \"4\", expected the data size, 8 (bytes) from 8 to 8");
  EXPECT_EQ(gmsh_error_with(gmsh_2_binary(false), int_bytes(1), int_bytes(2)),
            "a.msh: byte 20: found 2, expected the integer 1, in one of the two byte orders");
}

TEST(GmshReader, RefusesNodeNumbersThatAreNotDefined) {
  EXPECT_EQ(gmsh_error_with(gmsh_1, "4 3 7 42 8", "4 3 7 42 9"),
            "a.msh: line 13: found node number 9, expected the number of a node that the file defines");
  EXPECT_EQ(gmsh_error_with(gmsh_2, "0 3 7 42 8", "0 3 7 42 43"),
            "a.msh: line 20: found node number 43, expected the number of a node that the file defines");
  EXPECT_EQ(gmsh_error_with(gmsh_41, "3 3 7 42 8", "3 3 7 -42 8"),
            "a.msh: line 29: found node number -42, expected the number of a node that the file defines");
  const auto bytes = gmsh_41_binary(false);
  const auto message = gmsh_error_with(bytes, size_bytes(42) + size_bytes(8) + "\n$EndE",
                                       size_bytes(42) + size_bytes(9) + "\n$EndE");
  EXPECT_EQ(message, "a.msh: byte " + std::to_string(bytes.find("\n$EndElements") - 8) +
                         ": found node number 9, expected the number of a node that the file defines");
}

TEST(GmshReader, ReadsNodeNumbersFarApart) {
  const Folder folder;
  std::string text = gmsh_41;
  for (std::size_t at = text.find("42"); at != std::string::npos; at = text.find("42", at + 19)) {
    text.replace(at, 2, "9223372036854775807");
  }
  expect_sample(read_mesh(folder.write("a.msh", text)), "Gmsh 4.1 ASCII");
  EXPECT_EQ(gmsh_error_with(text, "3 3 7 9223372036854775807 8", "3 3 7 9223372036854775806 8"),
            "a.msh: line 29: found node number 9223372036854775806, expected the number of a node that the "
            "file defines");
}

TEST(GmshReader, RefusesANodeNumberTwice) {
  EXPECT_EQ(gmsh_error_with(gmsh_2, "42 0 0 1", "7 0 0 1"),
            "a.msh: node 7: found two nodes with this number, expected each node number once");
}

TEST(GmshReader, RefusesWhatIsNoNumber) {
  EXPECT_EQ(gmsh_error_with(gmsh_1, "8 1.5", "8 1.5x"),
            "a.msh: line 7: found \"1.5x\", expected a number (the x of a point)");
  EXPECT_EQ(gmsh_error_with(gmsh_2, "0.1", "nan"),
            "a.msh: line 14: found \"nan\", expected a finite number (the y of a point)");
  EXPECT_EQ(gmsh_error_with(gmsh_2, "0.1", "-inf"),
            "a.msh: line 14: found \"-inf\", expected a finite number (the y of a point)");
  EXPECT_EQ(gmsh_error_with(gmsh_41, "-2.5e-4", "1e999"),
            "a.msh: line 21: found \"1e999\", expected a finite number (the z of a point)");
  EXPECT_EQ(gmsh_error_with(gmsh_2, "1 4 2 1 1", "1 4 2 1 1.5"),
            "a.msh: line 18: found \"1.5\", expected an integer (a tag of an element)");
  const auto bytes = gmsh_2_binary(false);
  const auto nan = double_bytes(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(gmsh_error_with(bytes, double_bytes(0.1), nan),
            "a.msh: byte " + std::to_string(bytes.find(double_bytes(0.1))) +
                ": found nan, expected a finite number (the y of a point)");
}

TEST(GmshReader, RefusesCountsThatLie) {
  EXPECT_EQ(gmsh_error_with(gmsh_1, "$NOD\n5", "$NOD\n1000000000"),
            "a.msh: line 2: found \"1000000000\", expected the number of nodes from 0 to 16, as many as the "
            "rest of the file can hold");
  EXPECT_EQ(gmsh_error_with(gmsh_2, "$Nodes\n5", "$Nodes\n-5").substr(0, 46),
            "a.msh: line 9: found \"-5\", expected the number");
  EXPECT_EQ(gmsh_error_with(gmsh_2, "$Nodes\n5", "$Nodes\n4"),
            "a.msh: line 14: found \"8\", expected $EndNodes");
  EXPECT_EQ(gmsh_error_with(gmsh_2, "$Nodes\n5", "$Nodes\n6"),
            "a.msh: line 15: found \"$EndNodes\", expected an integer (a node number)");
  EXPECT_EQ(gmsh_error_with(gmsh_41, "2 5 3 42", "2 6 3 42"),
            "a.msh: found 5 nodes in the blocks, expected 6, as the section's first line says");
  EXPECT_EQ(gmsh_error_with(gmsh_41, "2 3 1 3\n", "2 4 1 3\n"),
            "a.msh: found 3 elements in the blocks, expected 4, as the section's first line says");
  const auto huge = gmsh_error_with(gmsh_41_binary(false), size_bytes(5) + size_bytes(3),
                                    size_bytes(~0ULL >> 2U) + size_bytes(3));
  EXPECT_NE(huge.find("found 4611686018427387903, expected the number of nodes from 0 to "),
            std::string::npos)
      << huge;
  EXPECT_EQ(gmsh_error_with(gmsh_1, "1 4 1 1 4", "1 4 1 1 5"),
            "a.msh: line 11: found \"5\", expected the number of nodes of that element type from 4 to 4");
}

TEST(GmshReader, RefusesUnknownElementTypes) {
  EXPECT_EQ(gmsh_error_with(gmsh_2, "2 2 2 1 1", "2 77 2 1 1"),
            "a.msh: line 19: found element type 77, expected a type of the Gmsh manual (1 to 31, 92, 93)");
}

TEST(GmshReader, RefusesSectionsThatAreMissingTwiceOrOutOfOrder) {
  const Folder folder;
  const std::string text = gmsh_2;
  const auto nodes = text.find("$Nodes");
  const auto elements = text.find("$Elements");
  EXPECT_EQ(error_of(folder.write("a.msh", text.substr(0, elements))),
            "a.msh: line 16: found the end of the file, expected the section $Elements");
  EXPECT_EQ(error_of(folder.write("a.msh", text.substr(0, nodes))),
            "a.msh: line 8: found the end of the file, expected the section $Nodes");
  EXPECT_EQ(
      error_of(folder.write("a.msh", text.substr(0, nodes) + text.substr(elements) + text.substr(nodes))),
      "a.msh: line 8: found \"$Elements\", expected the nodes before the elements");
  EXPECT_EQ(error_of(folder.write("a.msh", text + text.substr(nodes))),
            "a.msh: line 22: found \"$Nodes\", expected each section once");
  EXPECT_EQ(error_of(folder.write("a.msh", text + "$NodeData\n1\n")),
            "a.msh: line 24: found the end of the file, expected $EndNodeData");
}

TEST(GmshReader, RefusesMeshesWithoutTets) {
  const std::string nodes =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n$EndNodes\n";
  const Folder folder;
  EXPECT_EQ(error_of(folder.write(
                "a.msh", nodes + "$Elements\n3\n1 2 0 1 2 3\n2 15 0 1\n3 2 0 3 2 1\n$EndElements\n")),
            "a.msh: found 2 triangles, 1 vertex and no tet, expected at least one tet");
  EXPECT_EQ(error_of(folder.write("a.msh", nodes + "$Elements\n0\n$EndElements\n")),
            "a.msh: found no cells, expected at least one tet");
  EXPECT_EQ(error_of(folder.write("a.msh", "$NOD\n0\n$ENDNOD\n$ELM\n0\n$ENDELM\n")),
            "a.msh: found no points, expected at least four points");
}

TEST(GmshReader, PassesOverCommentsWhereverTheyStand) {
  const Folder folder;
  const std::string comments = "$Comments\nmade by hand\n$EndComments\n";
  expect_sample(read_mesh(folder.write("a.msh", comments + gmsh_2)), "Gmsh 2.2 ASCII");
  expect_sample(read_mesh(folder.write("a.msh", comments + gmsh_1)), "Gmsh 1");
  expect_sample(read_mesh(folder.write("a.msh", replaced(gmsh_1, "$ELM", comments + "$ELM"))), "Gmsh 1");
  expect_sample(read_mesh(folder.write("a.msh", "$COMMENTS\nold\n$ENDCOMMENTS\n" + std::string(gmsh_1))),
                "Gmsh 1");
  EXPECT_EQ(error_of(folder.write("a.msh", "$Comments\n" + std::string(gmsh_2))),
            "a.msh: line 23: found the end of the file, expected $ENDComments");
}

TEST(GmshReader, RefusesWrongCountsOfFormat40) {
  EXPECT_EQ(gmsh_error_with(gmsh_40, "$Nodes\n2 5", "$Nodes\n2 4"),
            "a.msh: found 5 nodes in the blocks, expected 4, as the section's first line says");
  EXPECT_EQ(gmsh_error_with(gmsh_40, "$Elements\n2 3", "$Elements\n2 4"),
            "a.msh: found 3 elements in the blocks, expected 4, as the section's first line says");
  EXPECT_EQ(gmsh_error_with(gmsh_40, "3 3 7 42 8", "3 3 7 42 9"),
            "a.msh: line 27: found node number 9, expected the number of a node that the file defines");
}

}  // namespace
}  // namespace palpate::io::testing
