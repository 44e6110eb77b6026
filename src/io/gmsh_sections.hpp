#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include <palpate/io/mesh_reader.hpp>

#include "io/gmsh_cells.hpp"

namespace palpate::io {

/// The data read from the sections of a Gmsh file.
struct GmshMesh {
  std::string source;
  MeshFile file;
  GmshNodeNumbers numbers;
  std::vector<std::int64_t> element_of_tet;  ///< number of each tet's element
};

/// Reads the content of one section, from after the line of its name up to its $End line.
///
/// Scanner is TextScanner for ASCII files or BinaryScanner for binary ones: the two differ only in how a
/// number is written. (Except for the elements of version 2, where the binary form groups them; there are two
/// functions.) `count` is the number of nodes or elements, which versions 1 and 2 write in ASCII also in
/// binary files.
template <class Scanner>
void read_nodes_2(Scanner& scanner, Index count, GmshMesh& mesh);  // also version 1
template <class Scanner>
void read_nodes_40(Scanner& scanner, GmshMesh& mesh);
template <class Scanner>
void read_nodes_41(Scanner& scanner, GmshMesh& mesh);
template <class Scanner>
void read_elements_40(Scanner& scanner, GmshMesh& mesh);
template <class Scanner>
void read_elements_41(Scanner& scanner, GmshMesh& mesh);

class BinaryScanner;
class TextScanner;
void read_elements_1(TextScanner& scanner, Index count, GmshMesh& mesh);
void read_elements_2(TextScanner& scanner, Index count, GmshMesh& mesh);
void read_elements_2(BinaryScanner& scanner, Index count, GmshMesh& mesh);

/// Reads rows of $ElementData with three components: the vector of each element by its number. A later row
/// replaces an earlier one of the same element.
template <class Scanner>
void read_vectors(Scanner& scanner, Index count, std::map<std::int64_t, Vec3>& vectors);

}  // namespace palpate::io
