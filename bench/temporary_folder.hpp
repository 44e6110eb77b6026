#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

#include <palpate/error.hpp>

namespace palpate::bench {

/// A new folder for what goes to another program and back; it goes with the object.
class TemporaryFolder {
 public:
  /// Throws Error if no folder can be made.
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "palpate-bench-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw Error(name, "", "no folder", "one that can be made");
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace palpate::bench
