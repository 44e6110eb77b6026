#include "folder_lock.hpp"

#include <cerrno>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include <palpate/error.hpp>

#include "io/atomic_file.hpp"

namespace palpate::app {
namespace {

/// Whether the path still names the open file: the run that held the lock before may have removed the file.
bool leads_to(const std::filesystem::path& path, int descriptor) {
  struct stat there {};
  struct stat open {};
  return ::stat(path.c_str(), &there) == 0 && ::fstat(descriptor, &open) == 0 &&
         there.st_dev == open.st_dev && there.st_ino == open.st_ino;
}

}  // namespace

FolderLock::FolderLock(const std::filesystem::path& folder) : path_(folder / ".lock") {
  io::create_folder(folder);
  while (true) {
    descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor_ < 0) {
      throw Error(path_.string(), "opening", "'" + std::system_category().message(errno) + "'",
                  "a folder that can be written to");
    }
    const bool held_elsewhere = ::flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    if (held_elsewhere) {
      ::close(std::exchange(descriptor_, -1));  // a destructor does not run after an exception here
      throw Error(folder.string(), "", "another run that is writing into this folder",
                  "another folder (--out DIR), or to start after that run has ended");
    }
    if (leads_to(path_, descriptor_)) return;
    ::close(std::exchange(descriptor_, -1));
  }
}

FolderLock::~FolderLock() {
  // Remove the name before releasing the lock. A run that opens the file in between then sees that the path
  // no longer names it.
  if (leads_to(path_, descriptor_)) ::unlink(path_.c_str());
  ::close(descriptor_);
}

}  // namespace palpate::app
