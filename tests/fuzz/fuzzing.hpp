#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <unistd.h>

#include <palpate/error.hpp>

/// Common parts of the fuzzers. A fault ends the process: a signal, a sanitizer, an exception that is no
/// palpate::Error, or fail().
namespace palpate::fuzz {

/// For conditions that hold for every input.
inline void require(bool holds) {
  if (!holds) std::abort();
}

inline std::string_view text(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// A folder in memory, removed at the end.
class Folder {
 public:
  Folder() : path_("/dev/shm/palpate_fuzz_" + std::to_string(::getpid())) {
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  std::filesystem::path write(const std::string& name, std::string_view bytes) const {
    const auto file = path_ / name;
    std::ofstream stream(file, std::ios::binary);
    stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return file;
  }

 private:
  std::filesystem::path path_;
};

/// Calls `read`. Refused input must give an Error of one line.
template <class Read>
void refusing(Read&& read) {
  try {
    read();
  } catch (const Error& error) {
    require(std::string_view(error.what()).size() < 10000);
  }
}

}  // namespace palpate::fuzz
