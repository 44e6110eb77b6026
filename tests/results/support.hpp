#pragma once

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <string>
#include <unistd.h>
#include <vector>

#include <palpate/mesh.hpp>

namespace palpate::test {

/// An empty folder for one test, removed at its end.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    path_ = std::filesystem::temp_directory_path() / (std::string("palpate_") + info->test_suite_name() +
                                                      "_" + info->name() + "_" + std::to_string(::getpid()));
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

inline std::string content_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline void put(const std::filesystem::path& path, const std::string& content) {
  std::ofstream(path, std::ios::binary) << content;
}

/// Names of all entries of a folder, hidden files too.
inline std::vector<std::string> names_in(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    names.push_back(entry.path().filename().string());
  }
  return names;
}

/// A box between two corners, cut into cells x cells x cells cubes of six tets each (Kuhn).
inline TetMesh box_mesh(const Vec3& low, const Vec3& high, Index cells = 2) {
  TetMesh mesh;
  const Index side = cells + 1;
  for (Index k = 0; k < side; ++k) {
    for (Index j = 0; j < side; ++j) {
      for (Index i = 0; i < side; ++i) {
        mesh.points.push_back({low.x + (high.x - low.x) * i / cells, low.y + (high.y - low.y) * j / cells,
                               low.z + (high.z - low.z) * k / cells});
      }
    }
  }
  constexpr Index paths[6][2] = {{1, 3}, {1, 5}, {2, 3},
                                 {2, 6}, {4, 5}, {4, 6}};  // from corner 0 to corner 7
  for (Index k = 0; k < cells; ++k) {
    for (Index j = 0; j < cells; ++j) {
      for (Index i = 0; i < cells; ++i) {
        const auto corner = [&](Index c) {
          return ((k + (c >> 2)) * side + j + ((c >> 1) & 1)) * side + i + (c & 1);
        };
        for (const auto& path : paths) {
          mesh.tets.push_back({corner(0), corner(path[0]), corner(path[1]), corner(7)});
        }
      }
    }
  }
  return mesh;
}

}  // namespace palpate::test
