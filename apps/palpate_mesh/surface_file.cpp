#include "surface_file.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>

#include "io/file_bytes.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

struct Format {
  std::string_view extension;
  PolygonFile (*read)(const std::string& source, std::string_view bytes);
};
constexpr std::array<Format, 6> formats{{{".stl", &read_stl},
                                         {".obj", &read_obj},
                                         {".ply", &read_ply},
                                         {".off", &read_off},
                                         {".vtk", &read_vtk},
                                         {".vtp", &read_vtp}}};

std::size_t format_of(const fs::path& path) {
  std::string text = path.extension().string();
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return static_cast<std::size_t>(std::ranges::find(formats, text, &Format::extension) - formats.begin());
}

}  // namespace

bool is_surface(const fs::path& path) {
  return format_of(path) < formats.size();
}

PolygonFile read_surface_file(const fs::path& path) {
  return formats.at(format_of(path)).read(path.string(), io::read_file(path, "a surface mesh"));
}

}  // namespace palpate::app
