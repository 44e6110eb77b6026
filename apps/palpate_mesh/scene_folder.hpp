#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace palpate::app {

/// A folder with a scene and its meshes that appear together or not at all. A scene names points of its
/// meshes, so an old scene beside new meshes would be wrong without a sign of it.
///
/// Files are written to a hidden folder in it. commit() removes the old scene, moves the meshes to their
/// places, and the scene last. So also if the process is killed in between, there is no scene with the
/// meshes of another one.
class SceneFolder {
 public:
  /// Creates the folder and those above it. Throws Error naming it if it cannot.
  explicit SceneFolder(std::filesystem::path folder);
  /// Removes what was not committed, and the folder if it is new and empty.
  ~SceneFolder();
  SceneFolder(const SceneFolder&) = delete;
  SceneFolder& operator=(const SceneFolder&) = delete;

  /// Where to write a mesh. \param name  of a file, other than scene.json. Throws Error naming its final path
  /// if a folder has that name.
  [[nodiscard]] std::filesystem::path place(const std::string& name);
  /// Moves all files to their places. Returns the names of meshes that an earlier scene may have left in the
  /// folder: .vtu files that are not of this one. To be called once, when all places are written.
  std::vector<std::string> commit(std::string_view scene);

 private:
  std::filesystem::path folder_;
  std::filesystem::path unfinished_;
  bool is_new_ = false;
  std::vector<std::string> names_;
};

/// Adds a warning of meshes that an earlier scene may have left.
void add_warning_of_others(const std::vector<std::string>& names, std::vector<std::string>& warnings);

}  // namespace palpate::app
