#include "meta_voxels.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <fmt/format.h>
#include <fstream>
#include <functional>
#include <memory>
#include <numeric>
#include <sstream>
#include <zlib.h>

#include <palpate/error.hpp>

#include "io/file_bytes.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t block_bytes = 1 << 16;
using Block = std::array<char, block_bytes>;

/// A file with voxels of a MetaImage.
struct VoxelFile {
  fs::path path;
  std::int64_t begin = 0;   ///< byte
  std::int64_t voxels = 0;  ///< that it has to hold
};

[[noreturn]] void refuse(const fs::path& path, const std::string& found, std::int64_t expected,
                         const char* unit) {
  throw Error(path.string(), "voxels", found, fmt::format("{} {}: the file is cut", expected, unit));
}

std::string trimmed(std::string text) {
  const auto blank = [](unsigned char c) { return std::isspace(c) != 0; };
  text.erase(text.begin(), std::ranges::find_if_not(text, blank));
  while (!text.empty() && blank(static_cast<unsigned char>(text.back()))) text.pop_back();
  return text;
}

/// The lines of a header that MetaIO does not tell of.
class MetaHeader {
 public:
  explicit MetaHeader(const fs::path& path) : file_(path, std::ios::binary), path_(path) {
    for (std::string line; std::getline(file_, line);) {
      const auto sign = std::min(line.find_first_of("=:"), line.size());
      const std::string key = trimmed(line.substr(0, sign));
      if (key == "ElementDataFile") return;
      if (key == "CompressedDataSize" && sign < line.size())
        compressed_bytes_ = std::strtoll(line.c_str() + sign + 1, nullptr, 10);
    }
    throw Error(path.string(), "header", "no ElementDataFile", "ElementDataFile as the last line");
  }
  /// 0: all that the file has.
  [[nodiscard]] std::int64_t compressed_bytes() const { return compressed_bytes_; }
  /// The first byte after the header.
  [[nodiscard]] std::int64_t end() {
    if (file_.eof()) return static_cast<std::int64_t>(fs::file_size(path_));
    return file_.tellg();
  }
  /// The next line after the header; false at the end of the file.
  bool next_line(std::string& line) { return static_cast<bool>(std::getline(file_, line)); }

 private:
  std::ifstream file_;
  fs::path path_;
  std::int64_t compressed_bytes_ = 0;
};

std::int64_t product(const MetaVoxels& voxels, std::size_t axes) {
  return std::accumulate(voxels.size.begin(), voxels.size.begin() + static_cast<std::ptrdiff_t>(axes),
                         std::int64_t{1}, std::multiplies<>());
}

/// The files of "LIST" or "LIST AXES": their names follow the header, a line each.
std::vector<VoxelFile> listed_files(const fs::path& path, MetaHeader& header, const MetaVoxels& voxels,
                                    std::size_t axes) {
  const std::size_t all = voxels.size.size();
  if (axes == 0 || axes > all) axes = all - 1;
  const std::int64_t each = product(voxels, axes);
  const auto count = static_cast<std::size_t>(product(voxels, all) / std::max<std::int64_t>(each, 1));
  std::vector<VoxelFile> files;
  for (std::string line; files.size() < count && header.next_line(line);)
    files.push_back({path.parent_path() / trimmed(line), 0, each});
  if (files.size() < count) {
    throw Error(path.string(), "ElementDataFile", fmt::format("{} files", files.size()),
                fmt::format("{}", count));
  }
  return files;
}

/// The name of a file of a pattern as "slice%03d.raw".
std::string numbered(const std::string& pattern, std::int64_t number, const fs::path& path) {
  const auto begin = std::min(pattern.find('%'), pattern.size());
  auto end = begin + 1;
  while (end < pattern.size() && std::isdigit(static_cast<unsigned char>(pattern[end])) != 0) ++end;
  constexpr std::size_t most_digits = 2;
  if (end >= pattern.size() || pattern[end] != 'd' || end - begin - 1 > most_digits ||
      pattern.find('%', end) != std::string::npos)
    throw Error(path.string(), "ElementDataFile", "'" + pattern + "'", "a pattern with one %d, such as %03d");
  const std::string digits = pattern.substr(begin + 1, end - begin - 1);
  const int width = digits.empty() ? 0 : std::stoi(digits);
  const std::string text =
      digits.starts_with('0') ? fmt::format("{:0{}d}", number, width) : fmt::format("{:{}d}", number, width);
  return pattern.substr(0, begin) + text + pattern.substr(end + 1);
}

/// The files of "PATTERN FIRST LAST STEP", one for each slice.
std::vector<VoxelFile> numbered_files(const fs::path& path, const MetaVoxels& voxels) {
  std::istringstream words(voxels.file);
  const std::int64_t slices = voxels.size.back();
  std::string pattern;
  int first = 1;
  int last = 0;
  std::int64_t step = 1;
  words >> pattern;
  if (!(words >> first)) first = 1;
  const bool has_last = static_cast<bool>(words >> last);
  if (has_last && !(words >> step)) step = (std::int64_t{last} - first) / slices;  // as MetaIO does
  if (step < 1 || (has_last && (last < first || (std::int64_t{last} - first) / step + 1 != slices))) {
    throw Error(path.string(), "ElementDataFile", "'" + voxels.file + "'",
                fmt::format("numbers of {} files, one for each slice: FIRST LAST STEP", slices));
  }
  std::vector<VoxelFile> files;
  for (std::int64_t n = 0; n < slices; ++n) {
    files.push_back({path.parent_path() / numbered(pattern, first + n * step, path), 0,
                     product(voxels, voxels.size.size() - 1)});
  }
  return files;
}

std::vector<VoxelFile> files_of(const fs::path& path, MetaHeader& header, const MetaVoxels& voxels) {
  const std::int64_t all = product(voxels, voxels.size.size());
  std::istringstream words(voxels.file);
  std::string word;
  std::size_t axes = 0;
  words >> word;
  if (word == "LOCAL" || word == "Local" || word == "local") return {{path, header.end(), all}};
  if (word == "LIST") return listed_files(path, header, voxels, words >> axes ? axes : 0);
  if (voxels.file.find('%') != std::string::npos) return numbered_files(path, voxels);
  return {{path.parent_path() / voxels.file, 0, all}};
}

void require_numbers(const VoxelFile& file) {
  std::ifstream text(file.path, std::ios::binary);
  text.seekg(file.begin);
  std::int64_t found = 0;
  for (double number = 0.0; found < file.voxels && text >> number;) ++found;
  if (found < file.voxels) refuse(file.path, fmt::format("{} numbers", found), file.voxels, "numbers");
}

/// The number of bytes that `packed` bytes of a file expand to, but no more than `most`.
std::int64_t uncompressed_bytes(const VoxelFile& file, std::int64_t packed, std::int64_t most) {
  constexpr int zlib_or_gzip = 47;
  z_stream stream{};
  if (inflateInit2(&stream, zlib_or_gzip) != Z_OK) return 0;
  const std::unique_ptr<z_stream, int (*)(z_stream*)> end(&stream, inflateEnd);
  std::ifstream source(file.path, std::ios::binary);
  source.seekg(file.begin);
  const auto in = std::make_unique<Block>();
  const auto out = std::make_unique<Block>();
  std::int64_t found = 0;
  for (int state = Z_OK; state == Z_OK && found < most;) {
    if (stream.avail_in == 0) {
      source.read(in->data(), std::min<std::int64_t>(block_bytes, packed));
      packed -= source.gcount();
      stream.next_in = reinterpret_cast<Bytef*>(in->data());
      stream.avail_in = static_cast<uInt>(source.gcount());
    }
    stream.next_out = reinterpret_cast<Bytef*>(out->data());
    stream.avail_out = block_bytes;
    state = inflate(&stream, Z_NO_FLUSH);
    found += static_cast<std::int64_t>(block_bytes - stream.avail_out);
  }
  return found;
}

void require_compressed(VoxelFile file, const MetaVoxels& voxels, std::int64_t packed) {
  const auto file_bytes = static_cast<std::int64_t>(fs::file_size(file.path));
  if (packed == 0) {  // MetaIO then takes the whole file
    file.begin = 0;
    packed = file_bytes;
  }
  if (packed < 0 || packed > file_bytes - file.begin) {
    refuse(file.path, fmt::format("{} compressed bytes", file_bytes - file.begin), packed,
           "bytes (CompressedDataSize)");
  }
  const std::int64_t needed = file.voxels * voxels.voxel_bytes;
  const std::int64_t found = uncompressed_bytes(file, packed, needed);
  if (found < needed) refuse(file.path, fmt::format("compressed data of {} bytes", found), needed, "bytes");
}

void require_voxels(VoxelFile file, const MetaVoxels& voxels, std::int64_t compressed_bytes) {
  io::require_regular_file(file.path, "voxels of a MetaImage");
  if (voxels.skipped_bytes > 0) file.begin = voxels.skipped_bytes;
  if (voxels.binary && voxels.compressed) return require_compressed(file, voxels, compressed_bytes);
  if (!voxels.binary) return require_numbers(file);
  if (voxels.skipped_bytes < 0) file.begin = 0;
  const std::int64_t needed = file.voxels * voxels.voxel_bytes;
  const auto bytes = static_cast<std::int64_t>(fs::file_size(file.path));
  const std::int64_t found = std::max<std::int64_t>(bytes - file.begin, 0);
  if (found < needed) refuse(file.path, fmt::format("{} bytes", found), needed, "bytes");
}

}  // namespace

void require_meta_voxels(const fs::path& path, const MetaVoxels& voxels) {
  if (product(voxels, voxels.size.size()) == 0) return;
  MetaHeader header(path);
  for (const VoxelFile& file : files_of(path, header, voxels))
    require_voxels(file, voxels, header.compressed_bytes());
}

}  // namespace palpate::app
