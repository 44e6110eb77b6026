#include "io/atomic_file.hpp"

#include <atomic>
#include <cerrno>
#include <fcntl.h>
#include <string>
#include <system_error>
#include <unistd.h>
#include <utility>

#include <palpate/error.hpp>

namespace palpate::io {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, std::string doing, int error_number, std::string expected) {
  throw Error(path.string(), std::move(doing), "'" + std::system_category().message(error_number) + "'",
              std::move(expected));
}

fs::path follow_links(const fs::path& path) {
  std::error_code ignored;
  if (!fs::is_symlink(path, ignored)) return path;
  std::error_code failed;
  fs::path target = fs::weakly_canonical(path, failed);
  return failed ? path : target;
}

/// A hidden name, unique among processes and threads that write to the same folder.
fs::path temporary_beside(const fs::path& path) {
  static std::atomic<unsigned> counter{0};
  std::string name{'.'};  // appended to: g++ 12 warns, wrongly, of "." + string
  name += path.filename().string() + '.' + std::to_string(::getpid()) + '.';
  name += std::to_string(counter.fetch_add(1)) + ".part";
  return path.parent_path() / name;
}

}  // namespace

AtomicFile::AtomicFile(const fs::path& path)
    : path_(follow_links(path)), temporary_(temporary_beside(path_)) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path_, ignored);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw Error(path_.string(), "", fs::is_directory(status) ? "a folder" : "a device or special file",
                "a regular file, or none yet");
  }
  descriptor_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor_ < 0) fail(path_, "creating", errno, "a folder that exists and can be written to");
}

AtomicFile::~AtomicFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void AtomicFile::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(path_, "writing", errno, "enough space on the disk");
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

void AtomicFile::sync() {
  if (::fsync(descriptor_) != 0) fail(path_, "writing to the disk", errno, "enough space on the disk");
}

void AtomicFile::commit() {
  // Some file systems report a failed write only here.
  if (::close(std::exchange(descriptor_, -1)) != 0) fail(path_, "closing", errno, "enough space on the disk");
  if (::rename(temporary_.c_str(), path_.c_str()) != 0) {
    fail(path_, "renaming into place", errno, "a folder that still exists and can be written to");
  }
  temporary_.clear();
}

void write_atomically(const fs::path& path, std::string_view bytes) {
  AtomicFile file(path);
  file.write(bytes);
  file.commit();
}

void create_folder(const fs::path& path) {
  std::error_code failed;
  fs::create_directories(path, failed);
  if (!failed && !fs::is_directory(path, failed)) failed = std::make_error_code(std::errc::not_a_directory);
  if (failed) {
    throw Error(path.string(), "creating the folder", "'" + failed.message() + "'",
                "a folder that can be created");
  }
}

}  // namespace palpate::io
