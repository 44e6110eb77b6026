#pragma once

#include <filesystem>
#include <string_view>

namespace palpate::io {

/// A file that appears complete or not at all: written under a temporary name in its own folder, then
/// renamed.
///
/// Readers see the old content or the new, also if the process is killed in between (for a power cut this
/// holds only after sync(), since nothing else forces data to the disk). A symbolic link is followed, so that
/// its target is replaced and not the link.
class AtomicFile {
 public:
  /// Opens the temporary. Throws Error naming `path` if its folder does not exist or cannot be written, or if
  /// `path` is there and is not a regular file (a folder, a device).
  explicit AtomicFile(const std::filesystem::path& path);
  /// Removes the temporary unless commit() succeeded.
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Appends bytes. Throws Error naming the path when the system refuses them (disk full, quota, size limit).
  void write(std::string_view bytes);
  /// Waits until the written bytes are on the disk. Throws Error naming the path.
  void sync();
  /// Closes and renames to the final path. Throws Error naming the path; the old content is then still there.
  /// To be called once.
  void commit();

 private:
  std::filesystem::path path_;
  std::filesystem::path temporary_;
  int descriptor_ = -1;
};

/// Replaces the content of `path` by `bytes`, whole or not at all. Throws as AtomicFile does.
void write_atomically(const std::filesystem::path& path, std::string_view bytes);

/// Creates a folder and those above it. Throws Error naming `path` if it cannot, for instance if a file
/// has that name.
void create_folder(const std::filesystem::path& path);

}  // namespace palpate::io
