#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include <palpate/io/mesh_reader.hpp>

namespace palpate::io::testing {

/// An empty folder that is removed with the object.
class Folder {
 public:
  Folder();
  ~Folder();
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// Writes a file into the folder (over an older one) and returns its path.
  [[nodiscard]] std::filesystem::path write(std::string_view name, std::string_view bytes) const;

 private:
  std::filesystem::path path_;
};

/// The mesh that all samples hold: 5 points, 2 tets; the files also have one triangle.
TetMesh sample_mesh();
bool same_mesh(const TetMesh& a, const TetMesh& b);
void expect_sample(const MeshFile& file, std::string_view format);

/// what() of the Error that read_mesh() throws, without the folder of `path`; "no error" if it does not
/// throw.
std::string error_of(const std::filesystem::path& path);

/// A text with one part replaced; the part must be there.
std::string replaced(std::string_view text, std::string_view part, std::string_view by);

}  // namespace palpate::io::testing
