#include "nifti_header.hpp"

#include <cmath>
#include <fmt/format.h>
#include <memory>
#include <string>
#include <zlib.h>

#include <palpate/error.hpp>

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t datatype_place = 70;  // bytes of the header
constexpr std::size_t vox_offset_place = 108;

using GzipFile = std::unique_ptr<gzFile_s, int (*)(gzFile)>;

/// Opens a file that may be compressed or not.
GzipFile open(const fs::path& path) {
  return {gzopen(path.c_str(), "rb"), gzclose};
}

/// Throws Error if the compressed data that were read are damaged or end too early.
void check_compression(const fs::path& path, const GzipFile& file) {
  int state = Z_OK;
  const std::string words = gzerror(file.get(), &state);
  if (state == Z_OK || state == Z_STREAM_END) return;
  throw Error(path.string(), "", "damaged compressed data (" + words + ")", "a whole gzip file");
}

/// The bytes of a file after it is uncompressed. Throws Error if its end or its check sum is wrong, unless it
/// holds less than `least`.
std::int64_t uncompressed_bytes(const fs::path& path, std::int64_t least) {
  constexpr std::size_t block_bytes = 1 << 16;
  const auto block = std::make_unique<std::array<char, block_bytes>>();
  const GzipFile file = open(path);
  if (!file) return 0;
  std::int64_t found = 0;
  int read = 0;
  while ((read = gzread(file.get(), block->data(), block_bytes)) > 0) found += read;
  if (found >= least) check_compression(path, file);
  return found;
}

}  // namespace

NiftiHeader::NiftiHeader(const fs::path& path) : path_(path) {
  const GzipFile file = open(path);
  const int read = file ? gzread(file.get(), bytes_.data(), size) : 0;
  if (read < 0) check_compression(path, file);
  if (read < static_cast<int>(size))
    throw Error(path.string(), "header", fmt::format("{} bytes", std::max(read, 0)), "348");
  const auto found = at<std::uint32_t>(0);
  swapped_ = found != size;
  if (at<std::uint32_t>(0) != size)
    throw Error(path.string(), "header", fmt::format("a size of {}", found), "348: NIfTI-1");
  check_numbers();
}

void NiftiHeader::check_numbers() const {
  struct Numbers {
    std::size_t begin;
    std::size_t count;
  };
  constexpr std::array<Numbers, 3> numbers{
      {{76, 8}, {vox_offset_place, 1}, {256, 18}}};  // pixdim; vox_offset; qform and sform
  for (const auto& [begin, count] : numbers) {
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t place = begin + sizeof(float) * i;
      const auto value = at<float>(place);
      if (!std::isfinite(value)) {
        throw Error(path_.string(), fmt::format("header, byte {}", place), fmt::format("{}", value),
                    "a finite number");
      }
    }
  }
  constexpr std::size_t dimensions_place = 40;
  constexpr std::size_t sizes_place = 80;
  for (std::size_t axis = 0; at<std::int16_t>(dimensions_place) >= 3 && axis < 3; ++axis) {
    const std::size_t place = sizes_place + sizeof(float) * axis;
    if (at<float>(place) == 0.0F) {
      throw Error(path_.string(), fmt::format("header, byte {}", place), "0",
                  "the size of a voxel in mm (pixdim)");
    }
  }
  constexpr float most = 1e9F;
  const auto offset = at<float>(vox_offset_place);
  if (offset < 0.0F || offset > most) {
    throw Error(path_.string(), fmt::format("header, byte {}", vox_offset_place), fmt::format("{}", offset),
                "the first byte of the voxels (vox_offset), 0 to 1e9");
  }
}

std::int64_t NiftiHeader::first_voxel() const {
  return std::max(static_cast<std::int64_t>(at<float>(vox_offset_place)), std::int64_t{size});
}

/// 0 for data that is no single number: ITK refuses it.
std::int64_t NiftiHeader::voxel_bytes() const {
  struct Datatype {
    int code;
    int bytes;
  };
  constexpr std::array<Datatype, 10> datatypes{{{2, 1},     // integers: uint8
                                                {256, 1},   // int8
                                                {4, 2},     // int16
                                                {512, 2},   // uint16
                                                {8, 4},     // int32
                                                {768, 4},   // uint32
                                                {1024, 8},  // int64
                                                {1280, 8},  // uint64
                                                {16, 4},    // float
                                                {64, 8}}};  // double
  const auto same = [&](const Datatype& type) { return type.code == at<std::int16_t>(datatype_place); };
  const auto found = std::ranges::find_if(datatypes, same);
  return found == datatypes.end() ? 0 : found->bytes;
}

void NiftiHeader::require_voxels(std::int64_t voxels) const {
  const std::int64_t expected = first_voxel() + voxels * voxel_bytes();
  const std::int64_t found = uncompressed_bytes(path_, expected);
  if (found < expected) {
    throw Error(path_.string(), "voxels", fmt::format("the end of the file after {} bytes", found),
                fmt::format("{} bytes (of the uncompressed file)", expected));
  }
}

}  // namespace palpate::app
