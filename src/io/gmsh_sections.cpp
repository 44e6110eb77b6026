#include "io/gmsh_sections.hpp"

#include <array>
#include <fmt/format.h>
#include <limits>
#include <span>
#include <type_traits>

#include <palpate/error.hpp>

#include "io/binary_scanner.hpp"
#include "io/cell_counts.hpp"
#include "io/text_scanner.hpp"
#include "io/volume_cells.hpp"

namespace palpate::io {
namespace {

template <class Scanner>
constexpr bool is_binary = std::is_same_v<Scanner, BinaryScanner>;

/// A number that binary files write as int.
template <class Scanner>
std::int64_t read_int(Scanner& scanner, const char* what) {
  if constexpr (is_binary<Scanner>) {
    return scanner.integer32(what);
  } else {
    return scanner.integer(what);
  }
}

/// A number that binary files of version 4.1 write as size_t.
template <class Scanner>
std::int64_t read_size(Scanner& scanner, const char* what) {
  if constexpr (is_binary<Scanner>) {
    return scanner.integer64(what);
  } else {
    return scanner.integer(what);
  }
}

template <class Scanner>
std::int64_t in_range(Scanner& scanner, const char* what, std::int64_t value, std::int64_t low,
                      std::int64_t high) {
  if (value < low || value > high) {
    scanner.fail(fmt::format("{}", value), fmt::format("{} from {} to {}", what, low, high));
  }
  return value;
}

/// The least size of a record with these numbers of ints, size_ts and doubles; in ASCII a digit and a
/// separator each.
template <class Scanner>
constexpr std::size_t least_bytes(std::size_t ints, std::size_t sizes, std::size_t doubles) {
  return is_binary<Scanner> ? 4 * ints + 8 * (sizes + doubles) : 2 * (ints + sizes + doubles);
}

template <class Scanner>
const GmshCellType& read_cell_type(Scanner& scanner) {
  const std::int64_t number = read_int(scanner, "an element type");
  const GmshCellType* type = gmsh_cell_type(number);
  if (type == nullptr) {
    scanner.fail(fmt::format("element type {}", number), "a type of the Gmsh manual (1 to 31, 92, 93)");
  }
  return *type;
}

/// Reads the nodes of one element, with `take` for each number; keeps the corners of volume elements.
template <class Scanner, class Take>
void read_element(Scanner& scanner, std::int64_t number_of_it, const GmshCellType& type, Take take,
                  GmshMesh& mesh) {
  const std::size_t wanted = volume_corners(type.kind);
  std::array<Index, 8> corners{};
  for (std::size_t node = 0; node < static_cast<std::size_t>(type.nodes); ++node) {
    const std::int64_t number = take(scanner, "a node number of an element");
    if (node >= wanted) continue;
    corners[node] = mesh.numbers.find(number);
    if (corners[node] < 0)
      scanner.fail(fmt::format("node number {}", number), "the number of a node that the file defines");
  }
  if (wanted == 0) return count_dropped(mesh.file, type.kind);
  add_volume_cell(mesh.file, type.kind, std::span(corners).first(wanted));
  mesh.element_of_tet.resize(mesh.file.mesh.tets.size(), number_of_it);
}

void fail_sum(const std::string& source, const char* what, std::int64_t found, Index expected) {
  throw Error(source, "", fmt::format("{} {} in the blocks", found, what),
              fmt::format("{}, as the section's first line says", expected));
}

}  // namespace

template <class Scanner>
void read_nodes_2(Scanner& scanner, Index count, GmshMesh& mesh) {
  mesh.file.mesh.points.reserve(static_cast<std::size_t>(count));
  mesh.numbers.reserve(static_cast<std::size_t>(count));
  for (Index i = 0; i < count; ++i) {
    mesh.numbers.add(read_int(scanner, "a node number"));
    mesh.file.mesh.points.push_back(scanner.point());
  }
}

template <class Scanner>
void read_nodes_40(Scanner& scanner, GmshMesh& mesh) {
  const Index blocks = scanner.count("the number of node blocks", least_bytes<Scanner>(3, 1, 0));
  const Index nodes = scanner.count("the number of nodes", least_bytes<Scanner>(1, 0, 3));
  mesh.file.mesh.points.reserve(static_cast<std::size_t>(nodes));
  mesh.numbers.reserve(static_cast<std::size_t>(nodes));
  for (Index block = 0; block < blocks; ++block) {
    read_int(scanner, "an entity number");
    const auto dimension =
        in_range(scanner, "the dimension of an entity", read_int(scanner, "a dimension"), 0, 3);
    const auto parametric =
        in_range(scanner, "the parametric flag", read_int(scanner, "a parametric flag"), 0, 1);
    const Index count = scanner.count("the number of nodes in the block", least_bytes<Scanner>(1, 0, 3));
    for (Index i = 0; i < count; ++i) {
      mesh.numbers.add(read_int(scanner, "a node number"));
      mesh.file.mesh.points.push_back(scanner.point());
      for (std::int64_t j = 0; j < parametric * dimension; ++j) scanner.number("a parametric coordinate");
    }
  }
  const auto found = static_cast<std::int64_t>(mesh.file.mesh.points.size());
  if (found != nodes) fail_sum(mesh.source, "nodes", found, nodes);
}

template <class Scanner>
void read_nodes_41(Scanner& scanner, GmshMesh& mesh) {
  const Index blocks = scanner.count("the number of node blocks", least_bytes<Scanner>(3, 1, 0));
  const Index nodes = scanner.count("the number of nodes", least_bytes<Scanner>(0, 1, 3));
  read_size(scanner, "the lowest node number");
  read_size(scanner, "the highest node number");
  mesh.file.mesh.points.reserve(static_cast<std::size_t>(nodes));
  mesh.numbers.reserve(static_cast<std::size_t>(nodes));
  for (Index block = 0; block < blocks; ++block) {
    const auto dimension =
        in_range(scanner, "the dimension of an entity", read_int(scanner, "a dimension"), 0, 3);
    read_int(scanner, "an entity number");
    const auto parametric =
        in_range(scanner, "the parametric flag", read_int(scanner, "a parametric flag"), 0, 1);
    const Index count = scanner.count("the number of nodes in the block", least_bytes<Scanner>(0, 1, 3));
    for (Index i = 0; i < count; ++i) mesh.numbers.add(read_size(scanner, "a node number"));
    for (Index i = 0; i < count; ++i) {
      mesh.file.mesh.points.push_back(scanner.point());
      for (std::int64_t j = 0; j < parametric * dimension; ++j) scanner.number("a parametric coordinate");
    }
  }
  const auto found = static_cast<std::int64_t>(mesh.file.mesh.points.size());
  if (found != nodes) fail_sum(mesh.source, "nodes", found, nodes);
}

template <class Scanner>
void read_elements_40(Scanner& scanner, GmshMesh& mesh) {
  const Index blocks = scanner.count("the number of element blocks", least_bytes<Scanner>(3, 1, 0));
  const Index elements = scanner.count("the number of elements", least_bytes<Scanner>(2, 0, 0));
  std::int64_t found = 0;
  for (Index block = 0; block < blocks; ++block) {
    read_int(scanner, "an entity number");
    in_range(scanner, "the dimension of an entity", read_int(scanner, "a dimension"), 0, 3);
    const GmshCellType& type = read_cell_type(scanner);
    const auto nodes = static_cast<std::size_t>(type.nodes);
    const Index count =
        scanner.count("the number of elements in the block", least_bytes<Scanner>(1 + nodes, 0, 0));
    for (Index i = 0; i < count; ++i) {
      const std::int64_t number = read_int(scanner, "an element number");
      read_element(scanner, number, type, read_int<Scanner>, mesh);
    }
    found += count;
  }
  if (found != elements) fail_sum(mesh.source, "elements", found, elements);
}

template <class Scanner>
void read_elements_41(Scanner& scanner, GmshMesh& mesh) {
  const Index blocks = scanner.count("the number of element blocks", least_bytes<Scanner>(3, 1, 0));
  const Index elements = scanner.count("the number of elements", least_bytes<Scanner>(0, 2, 0));
  read_size(scanner, "the lowest element number");
  read_size(scanner, "the highest element number");
  std::int64_t found = 0;
  for (Index block = 0; block < blocks; ++block) {
    in_range(scanner, "the dimension of an entity", read_int(scanner, "a dimension"), 0, 3);
    read_int(scanner, "an entity number");
    const GmshCellType& type = read_cell_type(scanner);
    const auto nodes = static_cast<std::size_t>(type.nodes);
    const Index count =
        scanner.count("the number of elements in the block", least_bytes<Scanner>(0, 1 + nodes, 0));
    for (Index i = 0; i < count; ++i) {
      const std::int64_t number = read_size(scanner, "an element number");
      read_element(scanner, number, type, read_size<Scanner>, mesh);
    }
    found += count;
  }
  if (found != elements) fail_sum(mesh.source, "elements", found, elements);
}

void read_elements_1(TextScanner& scanner, Index count, GmshMesh& mesh) {
  for (Index i = 0; i < count; ++i) {
    const std::int64_t number = scanner.integer("an element number");
    const GmshCellType& type = read_cell_type(scanner);
    scanner.integer("a physical region");
    scanner.integer("an elementary region");
    scanner.integer("the number of nodes of that element type", type.nodes, type.nodes);
    read_element(scanner, number, type, read_int<TextScanner>, mesh);
  }
}

void read_elements_2(TextScanner& scanner, Index count, GmshMesh& mesh) {
  for (Index i = 0; i < count; ++i) {
    const std::int64_t number = scanner.integer("an element number");
    const GmshCellType& type = read_cell_type(scanner);
    const Index tags = scanner.count("the number of tags", least_bytes<TextScanner>(1, 0, 0));
    for (Index tag = 0; tag < tags; ++tag) scanner.integer("a tag of an element");
    read_element(scanner, number, type, read_int<TextScanner>, mesh);
  }
}

void read_elements_2(BinaryScanner& scanner, Index count, GmshMesh& mesh) {
  for (std::int64_t done = 0; done < count;) {
    const GmshCellType& type = read_cell_type(scanner);
    const auto in_block = in_range(scanner, "the number of elements of the block",
                                   scanner.integer32("the number of elements of a block"), 1, count - done);
    const auto tags = in_range(scanner, "the number of tags", scanner.integer32("the number of tags"), 0,
                               static_cast<std::int64_t>(scanner.bytes_left() / 4));
    for (std::int64_t i = 0; i < in_block; ++i) {
      const std::int64_t number = scanner.integer32("an element number");
      for (std::int64_t tag = 0; tag < tags; ++tag) scanner.integer32("a tag of an element");
      read_element(scanner, number, type, read_int<BinaryScanner>, mesh);
    }
    done += in_block;
  }
}

template <class Scanner>
void read_vectors(Scanner& scanner, Index count, std::map<std::int64_t, Vec3>& vectors) {
  for (Index i = 0; i < count; ++i) {
    const std::int64_t element = read_int(scanner, "an element number");
    vectors[element] = scanner.point();
  }
}

template void read_nodes_2(TextScanner&, Index, GmshMesh&);
template void read_nodes_2(BinaryScanner&, Index, GmshMesh&);
template void read_nodes_40(TextScanner&, GmshMesh&);
template void read_nodes_40(BinaryScanner&, GmshMesh&);
template void read_elements_40(TextScanner&, GmshMesh&);
template void read_elements_40(BinaryScanner&, GmshMesh&);
template void read_nodes_41(TextScanner&, GmshMesh&);
template void read_nodes_41(BinaryScanner&, GmshMesh&);
template void read_elements_41(TextScanner&, GmshMesh&);
template void read_elements_41(BinaryScanner&, GmshMesh&);
template void read_vectors(TextScanner&, Index, std::map<std::int64_t, Vec3>&);
template void read_vectors(BinaryScanner&, Index, std::map<std::int64_t, Vec3>&);

}  // namespace palpate::io
