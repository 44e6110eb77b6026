#pragma once

#include <filesystem>

namespace palpate::app {

/// Holds a folder of results for one run: a lock (flock) on FOLDER/.lock, which ends with the process however
/// that ends.
class FolderLock {
 public:
  /// Creates the folder where it is not there. Throws Error where another run holds it, or where it cannot be
  /// written. On file systems without locks there is none.
  explicit FolderLock(const std::filesystem::path& folder);
  /// Removes the file.
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

}  // namespace palpate::app
