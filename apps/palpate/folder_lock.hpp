#pragma once

#include <filesystem>

namespace palpate::app {

/// Reserves a folder of results for one run: a lock (flock) on FOLDER/.lock. The system releases it when the
/// process ends, also by a crash.
class FolderLock {
 public:
  /// Creates the folder if it does not exist. Throws Error if another run holds the lock, or the folder
  /// cannot be written. On file systems without locks nothing is locked.
  explicit FolderLock(const std::filesystem::path& folder);
  /// Removes the lock file.
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

}  // namespace palpate::app
