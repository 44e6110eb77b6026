#include "csv_file.hpp"

#include <cerrno>
#include <fcntl.h>
#include <string_view>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include <palpate/error.hpp>

namespace palpate::app {
namespace {

constexpr auto longest_wait = std::chrono::milliseconds(500);

}  // namespace

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted.append(c == '"' ? 2 : 1, c);
  return quoted + '"';
}

CsvFile::CsvFile(std::filesystem::path path, std::string header)
    : path_(std::move(path)), lines_(std::move(header)) {
  open(O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC);
}

CsvFile::CsvFile(std::filesystem::path path, std::uint64_t bytes) : path_(std::move(path)), bytes_(bytes) {
  open(O_WRONLY | O_APPEND | O_CLOEXEC);
  const off_t size = ::lseek(descriptor_, 0, SEEK_END);
  if (size < 0 || static_cast<std::uint64_t>(size) < bytes) {
    ::close(std::exchange(descriptor_, -1));  // a destructor does not run after an exception here
    throw Error(path_.string(), "", std::to_string(size) + " bytes",
                std::to_string(bytes) + " or more, the size at the time of the checkpoint");
  }
  if (::ftruncate(descriptor_, static_cast<off_t>(bytes)) != 0) {
    const int error = errno;
    ::close(std::exchange(descriptor_, -1));
    errno = error;
    fail("truncating", "a file that can be written");
  }
}

void CsvFile::open(int flags) {
  descriptor_ = ::open(path_.c_str(), flags, 0666);
  if (descriptor_ < 0) fail("opening", "a file that can be written");
}

void CsvFile::fail(const char* doing, const char* expected) const {
  throw Error(path_.string(), doing, "'" + std::system_category().message(errno) + "'", expected);
}

CsvFile::~CsvFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void CsvFile::add(const std::string& line) {
  lines_ += line;
  if (std::chrono::steady_clock::now() - flushed_ > longest_wait) flush();
}

void CsvFile::flush() {
  std::string_view left = lines_;
  while (!left.empty()) {
    const ssize_t written = ::write(descriptor_, left.data(), left.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail("writing", "enough space on the disk");
    left.remove_prefix(static_cast<std::size_t>(written));
    bytes_ += static_cast<std::uint64_t>(written);
  }
  // Writing to a removed file succeeds, but its content would be lost.
  struct stat status {};
  if (::fstat(descriptor_, &status) == 0 && status.st_nlink == 0) {
    throw Error(path_.string(), "writing", "that the file was removed during the run",
                "it to stay until the run ends");
  }
  lines_.clear();
  flushed_ = std::chrono::steady_clock::now();
}

void CsvFile::sync() {
  flush();
  if (::fsync(descriptor_) != 0) fail("writing to the disk", "enough space on the disk");
}

}  // namespace palpate::app
