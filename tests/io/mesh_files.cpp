#include "io/mesh_files.hpp"

#include <atomic>
#include <fstream>
#include <gtest/gtest.h>
#include <unistd.h>

#include <palpate/error.hpp>

namespace palpate::io::testing {

Folder::Folder() {
  static std::atomic<int> counter = 0;
  const std::string name = "palpate_" + std::to_string(getpid()) + "_" + std::to_string(counter++);
  path_ = std::filesystem::temp_directory_path() / name;
  std::filesystem::create_directories(path_);
}

Folder::~Folder() {
  std::filesystem::remove_all(path_);
}

std::filesystem::path Folder::write(std::string_view name, std::string_view bytes) const {
  std::filesystem::remove(
      path_ / name);  // much faster than truncation, which waits for the disk on some file systems
  std::ofstream file(path_ / name, std::ios::binary | std::ios::trunc);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  EXPECT_TRUE(file.good());
  return path_ / name;
}

TetMesh sample_mesh() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1.5, 0.1, -0.00025}}, {{0, 1, 2, 3}, {1, 2, 3, 4}}};
}

bool same_mesh(const TetMesh& a, const TetMesh& b) {
  return a.points == b.points && a.tets == b.tets;
}

void expect_sample(const MeshFile& file, std::string_view format) {
  EXPECT_EQ(file.mesh.points, sample_mesh().points);
  EXPECT_EQ(file.mesh.tets, sample_mesh().tets);
  EXPECT_EQ(file.format, format);
  const std::vector<std::pair<std::string, Index>> one_triangle{{"triangle", 1}};
  EXPECT_EQ(file.dropped, one_triangle);
}

std::string error_of(const std::filesystem::path& path) {
  try {
    static_cast<void>(read_mesh(path));
  } catch (const Error& error) {
    const std::string message = error.what();
    const std::string folder = path.parent_path().string() + "/";
    return message.starts_with(folder) ? message.substr(folder.size()) : message;
  }
  return "no error";
}

std::string replaced(std::string_view text, std::string_view part, std::string_view by) {
  const auto begin = text.find(part);
  if (begin == std::string_view::npos) {
    ADD_FAILURE() << "no \"" << part << "\" in the text";
    return std::string(text);
  }
  std::string result(text);
  return result.replace(begin, part.size(), by);
}

}  // namespace palpate::io::testing
