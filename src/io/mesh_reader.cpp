#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <numeric>

#include <palpate/error.hpp>
#include <palpate/io/mesh_reader.hpp>

#include "io/mesh_formats.hpp"

namespace palpate::io {
namespace {

struct Format {
  std::string_view extension;
  MeshFile (*read)(const std::filesystem::path&);
};

constexpr std::array<Format, 6> formats{{{".vtu", read_vtu},
                                         {".vtk", read_vtk_legacy},
                                         {".msh", read_gmsh},
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

}  // namespace

std::span<const std::string_view> mesh_extensions() {
  return extensions;
}

MeshFile read_mesh(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto format = std::find_if(formats.begin(), formats.end(),
                                   [&](const Format& known) { return known.extension == extension; });
  if (format == formats.end()) fail_extension(path, extension);
  return format->read(path);
}

}  // namespace palpate::io
