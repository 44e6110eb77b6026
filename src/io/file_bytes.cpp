#include "io/file_bytes.hpp"

#include <array>
#include <cerrno>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <system_error>

#include <palpate/error.hpp>

namespace palpate::io {
namespace {

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& found,
                       const std::string& expected) {
  throw Error(path.string(), "", found, expected);
}

/// The first line of a pointer file (Git LFS Specification, "The Pointer").
void refuse_lfs_pointer(const std::filesystem::path& path, const std::string& expected) {
  constexpr std::string_view head = "version https://git-lfs.github.com/spec/";
  std::array<char, head.size()> bytes{};
  const std::unique_ptr<std::FILE, CloseFile> file(std::fopen(path.c_str(), "rb"));
  if (!file || std::fread(bytes.data(), 1, bytes.size(), file.get()) != bytes.size()) return;
  if (std::string_view(bytes.data(), bytes.size()) != head) return;
  fail(path, "a git-LFS pointer instead of the file itself",
       expected + "; 'git lfs pull' in the repository fetches it");
}

}  // namespace

void require_regular_file(const std::filesystem::path& path, const std::string& expected) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found) fail(path, "no such file", expected);
  if (error) fail(path, "a path that cannot be read (" + error.message() + ")", expected);
  if (std::filesystem::is_directory(status)) fail(path, "a folder", expected);
  if (!std::filesystem::is_regular_file(status)) fail(path, "something that is not a regular file", expected);
  refuse_lfs_pointer(path, expected);
}

std::string read_file(const std::filesystem::path& path, const std::string& expected) {
  require_regular_file(path, expected);
  const std::unique_ptr<std::FILE, CloseFile> file(std::fopen(path.c_str(), "rb"));
  if (!file) {
    const std::string reason = std::error_code(errno, std::generic_category()).message();
    fail(path, "a file that cannot be opened (" + reason + ")", expected);
  }
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  if (error) fail(path, "a file of unknown size (" + error.message() + ")", expected);
  if (size == 0) fail(path, "an empty file", expected);
  std::string bytes(static_cast<std::size_t>(size), '\0');
  if (std::fread(bytes.data(), 1, bytes.size(), file.get()) != bytes.size()) {
    fail(path, "a read error or a file that shrinks while it is read", std::to_string(size) + " bytes");
  }
  return bytes;
}

}  // namespace palpate::io
