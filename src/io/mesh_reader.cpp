#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <numeric>

#include <palpate/error.hpp>
#include <palpate/io/cell_vectors.hpp>
#include <palpate/io/mesh_reader.hpp>

#include "io/mesh_formats.hpp"

namespace palpate::io {
namespace {

struct Format {
  std::string_view extension;
  MeshFile (*read)(const std::filesystem::path&);
  std::vector<double> (*read_data)(const std::filesystem::path&, const CellDataKey&) = nullptr;
};

constexpr std::array<Format, 6> formats{{{".vtu", read_vtu, read_vtu_data},
                                         {".vtk", read_vtk_legacy, read_vtk_legacy_data},
                                         {".msh", read_gmsh, read_gmsh_data},
                                         {".node", read_tetgen},
                                         {".ele", read_tetgen},
                                         {".mesh", read_medit}}};

constexpr auto extensions = [] {
  std::array<std::string_view, formats.size()> result;
  for (std::size_t i = 0; i < formats.size(); ++i) result[i] = formats[i].extension;
  return result;
}();

/// Levenshtein distance, one row of the table at a time.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (const char letter : a) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (letter == b[j] ? 0U : 1U);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

[[noreturn]] void fail_extension(const std::filesystem::path& path, const std::string& extension) {
  std::string expected = "one of";
  for (const std::string_view known : extensions) expected += ' ' + std::string(known);
  const auto nearest = std::min_element(extensions.begin(), extensions.end(), [&](auto a, auto b) {
    return edit_distance(a, extension) < edit_distance(b, extension);
  });
  constexpr std::size_t close = 2;
  if (!extension.empty() && edit_distance(*nearest, extension) <= close) {
    expected += " (did you mean " + std::string(*nearest) + "?)";
  }
  throw Error(path.string(), "", extension.empty() ? "no file extension" : "the extension " + extension,
              expected);
}

const Format& format_of(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto format = std::find_if(formats.begin(), formats.end(),
                                   [&](const Format& known) { return known.extension == extension; });
  if (format == formats.end()) fail_extension(path, extension);
  return *format;
}

}  // namespace

std::span<const std::string_view> mesh_extensions() {
  return extensions;
}

MeshFile read_mesh(const std::filesystem::path& path) {
  return format_of(path).read(path);
}

std::vector<Vec3> read_cell_vectors(const std::filesystem::path& path, const std::string& name) {
  constexpr std::size_t dimensions = 3;
  const std::vector<double> data = read_cell_data(path, name, dimensions);
  std::vector<Vec3> vectors;
  vectors.reserve(data.size() / dimensions);
  for (std::size_t i = 0; i < data.size(); i += dimensions)
    vectors.push_back({data[i], data[i + 1], data[i + 2]});
  return vectors;
}

std::vector<double> read_cell_data(const std::filesystem::path& path, const std::string& name,
                                   std::size_t components) {
  const Format& format = format_of(path);
  if (format.read_data == nullptr) {
    throw Error(path.string(), "cell data " + name, "the extension " + std::string(format.extension),
                ".vtu, .vtk or .msh: of other files data of cells are not read");
  }
  return format.read_data(path, {name, components});
}

}  // namespace palpate::io
