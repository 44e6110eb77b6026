#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <palpate/error.hpp>

#include "io/binary_scanner.hpp"
#include "io/cell_counts.hpp"
#include "io/file_bytes.hpp"
#include "io/gmsh_sections.hpp"
#include "io/mesh_formats.hpp"
#include "io/text_scanner.hpp"

namespace palpate::io {
namespace {

enum class Version { v1, v2, v40, v41 };

class GmshReader {
 public:
  /// \param name  name of the $ElementData whose vectors are read too; or empty
  explicit GmshReader(TextScanner& scanner, std::string name = {})
      : scanner_(scanner), name_(std::move(name)) {
    mesh_.source = scanner.source();
  }

  MeshFile read() {
    read_head();
    while (!scanner_.at_end()) read_section();
    require_section(has_nodes_, version_ == Version::v1 ? "$NOD" : "$Nodes");
    require_section(has_elements_, version_ == Version::v1 ? "$ELM" : "$Elements");
    require_tets(mesh_.file, scanner_.source());
    return std::move(mesh_.file);
  }

  /// After read(): for each tet the vector of its element, three numbers.
  [[nodiscard]] std::vector<double> vectors_of_tets() const {
    if (!step_) throw Error(scanner_.source(), "", "no cell data of the name '" + name_ + "'", "some");
    std::vector<double> vectors;
    for (const std::int64_t element : mesh_.element_of_tet) {
      const auto found = vectors_.find(element);
      if (found == vectors_.end()) {
        throw Error(scanner_.source(), fmt::format("cell data {}, element {}", name_, element), "nothing",
                    "a vector for each element with a volume");
      }
      const Vec3& vector = found->second;
      vectors.insert(vectors.end(), {vector.x, vector.y, vector.z});
    }
    return vectors;
  }

 private:
  /// Reads the format section. Version 1 has none, and is recognised by its first section.
  void read_head() {
    while (scanner_.peek() == "$Comments" || scanner_.peek() == "$COMMENTS")
      skip_to_end(scanner_.word("").substr(1));
    if (scanner_.peek() == "$NOD") {
      mesh_.file.format = "Gmsh 1";
      return;
    }
    if (scanner_.word("$MeshFormat or $NOD") != "$MeshFormat") scanner_.fail("$MeshFormat or $NOD");
    read_version();
    if (binary_) read_byte_order();
    scanner_.keyword("$EndMeshFormat");
  }

  void read_version() {
    const std::string_view digits = scanner_.peek();
    const double version = scanner_.number("the version of the Gmsh format");
    if (version != 2.0 && version != 2.1 && version != 2.2 && version != 4.0 && version != 4.1) {
      scanner_.fail(fmt::format("Gmsh format {}", in_quotes(digits)), "format 1, 2, 2.1, 2.2, 4.0 or 4.1");
    }
    version_ = version == 4.1 ? Version::v41 : version == 4.0 ? Version::v40 : Version::v2;
    binary_ = scanner_.integer("the file type: 0 for ASCII, 1 for binary", 0, 1) == 1;
    scanner_.integer("the data size, 8 (bytes)", 8, 8);
    mesh_.file.format = fmt::format("Gmsh {} {}", digits, binary_ ? "binary" : "ASCII");
  }

  void read_byte_order() {
    constexpr std::int64_t one_swapped = 0x01000000;
    skip_line_end();
    BinaryScanner binary(scanner_.source(), scanner_.text(), scanner_.position(), false);
    const std::int64_t one = binary.integer32("the byte order mark");
    if (one != 1 && one != one_swapped)
      binary.fail(fmt::format("{}", one), "the integer 1, in one of the two byte orders");
    swapped_ = one != 1;
    scanner_.set_position(binary.position());
  }

  void read_section() {
    const std::string_view name = scanner_.word("");
    if (name.size() < 2 || name[0] != '$' || name.starts_with("$End"))
      scanner_.fail("a section such as $Nodes");
    const bool v1 = version_ == Version::v1;
    if (name == (v1 ? "$NOD" : "$Nodes")) {
      claim_once(has_nodes_);
      read_nodes();
      mesh_.numbers.finish(scanner_.source());
    } else if (name == (v1 ? "$ELM" : "$Elements")) {
      if (!has_nodes_) scanner_.fail("the nodes before the elements");
      claim_once(has_elements_);
      read_elements();
    } else if (name == "$ElementData" && !name_.empty()) {
      if (!read_data()) return skip_to_end(name.substr(1));
    } else {
      return skip_to_end(name.substr(1));
    }
    scanner_.keyword((v1 ? "$END" : "$End") + std::string(name.substr(1)));
  }

  void read_nodes() {
    if (version_ == Version::v40 || version_ == Version::v41) {
      const auto read = [&](auto& scanner) {
        version_ == Version::v40 ? read_nodes_40(scanner, mesh_) : read_nodes_41(scanner, mesh_);
      };
      return binary_ ? in_binary(read) : read(scanner_);
    }
    const Index count = scanner_.count("the number of nodes", 8);
    if (!binary_) return read_nodes_2(scanner_, count, mesh_);
    in_binary([&](BinaryScanner& binary) { read_nodes_2(binary, count, mesh_); });
  }

  void read_elements() {
    if (version_ == Version::v40 || version_ == Version::v41) {
      const auto read = [&](auto& scanner) {
        version_ == Version::v40 ? read_elements_40(scanner, mesh_) : read_elements_41(scanner, mesh_);
      };
      return binary_ ? in_binary(read) : read(scanner_);
    }
    const Index count = scanner_.count("the number of elements", 8);
    if (version_ == Version::v1) return read_elements_1(scanner_, count, mesh_);
    if (!binary_) return read_elements_2(scanner_, count, mesh_);
    in_binary([&](BinaryScanner& binary) { read_elements_2(binary, count, mesh_); });
  }

  /// Reads data of the wanted name; returns false, after the header, where name or time step differ.
  bool read_data() {
    if (read_name() != name_) return false;
    skip_line_end();
    const Index reals = scanner_.count("the number of real tags", 2);
    for (Index i = 0; i < reals; ++i) scanner_.number("a real tag");
    const Index tags = scanner_.count("the number of integer tags", 2);
    if (tags < 3) scanner_.fail("3 or more: time step, components and rows");
    const std::int64_t step = scanner_.integer("a time step");
    if (step_.value_or(step) != step) return false;
    step_ = step;
    const std::int64_t components = scanner_.integer("the number of components");
    if (components != 3) scanner_.fail(fmt::format("{} components", components), "3: a vector for each cell");
    const Index rows = scanner_.count("the number of rows", binary_ ? 28 : 8);
    for (Index i = 3; i < tags; ++i) scanner_.integer("an integer tag");
    const auto read = [&](auto& scanner) { read_vectors(scanner, rows, vectors_); };
    binary_ ? in_binary(read) : read(scanner_);
    return true;
  }

  /// The first string tag, without its quotes; the rest of the lines of tags is skipped.
  std::string_view read_name() {
    const Index count = scanner_.count("the number of string tags", 2);
    std::string_view name;
    for (Index i = 0; i < count; ++i) {
      skip_line_end();
      const std::string_view rest = scanner_.text().substr(scanner_.position());
      const std::size_t first = rest.find('"');
      const std::size_t last = first == rest.npos ? rest.npos : rest.find('"', first + 1);
      if (last == rest.npos || last > rest.find('\n')) {
        scanner_.word("a string tag");
        scanner_.fail("a name in double quotes");
      }
      if (i == 0) name = rest.substr(first + 1, last - first - 1);
      scanner_.set_position(scanner_.position() + last + 1);
    }
    return name;
  }

  /// Runs `read` on the bytes after this line and continues after what it read.
  template <class Read>
  void in_binary(Read read) {
    skip_line_end();
    BinaryScanner binary(scanner_.source(), scanner_.text(), scanner_.position(), swapped_);
    read(binary);
    scanner_.set_position(binary.position());
  }

  void skip_line_end() {
    if (!scanner_.at_line_end()) {
      scanner_.word("");
      scanner_.fail("the end of the line");
    }
    scanner_.skip_line();
  }

  /// Format 1 writes $END, later ones $End; files that mix them (comments in format 1) are accepted.
  void skip_to_end(std::string_view name) {
    const std::string_view text = scanner_.text();
    const auto end_from = [&](std::string_view end) {
      return text.find(fmt::format("{}{}", end, name), scanner_.position());
    };
    const auto found = std::min(end_from("$End"), end_from("$END"));
    if (found == std::string_view::npos)
      scanner_.fail_end(fmt::format("{}{}", version_ == Version::v1 ? "$END" : "$End", name));
    scanner_.set_position(found + std::string_view("$End").size() + name.size());
  }

  void claim_once(bool& seen) {
    if (seen) scanner_.fail("each section once");
    seen = true;
  }

  void require_section(bool seen, const char* name) {
    if (!seen) scanner_.fail_end(fmt::format("the section {}", name));
  }

  TextScanner& scanner_;
  GmshMesh mesh_;
  Version version_ = Version::v1;
  std::string name_;
  std::map<std::int64_t, Vec3> vectors_;
  std::optional<std::int64_t> step_{};  ///< time step of the data; empty before the first data
  bool binary_ = false;
  bool swapped_ = false;
  bool has_nodes_ = false;
  bool has_elements_ = false;
};

}  // namespace

MeshFile read_gmsh(const std::filesystem::path& path) {
  const std::string bytes = read_file(path, "a Gmsh mesh file");
  TextScanner scanner(path.string(), bytes);
  return GmshReader(scanner).read();
}

std::vector<double> read_gmsh_data(const std::filesystem::path& path, const CellDataKey& key) {
  if (key.components != 3)
    throw Error(path.string(), "cell data " + key.name, "a Gmsh file", "a .vtu or .vtk file");
  const std::string bytes = read_file(path, "a Gmsh mesh file");
  TextScanner scanner(path.string(), bytes);
  GmshReader reader(scanner, key.name);
  reader.read();
  return reader.vectors_of_tets();
}

}  // namespace palpate::io
