#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <filesystem>

namespace palpate::app {

/// The header of a NIfTI-1 file, .nii or .nii.gz (https://nifti.nimh.nih.gov/nifti-1).
class NiftiHeader {
 public:
  /// Throws Error unless it is one of this format, with finite numbers: ITK ends the process where those of
  /// the orientation are not.
  explicit NiftiHeader(const std::filesystem::path& path);

  /// Throws Error unless the file holds this many voxels: ITK takes 0 for the others. Reads a compressed file
  /// once.
  void require_voxels(std::int64_t voxels) const;

 private:
  static constexpr std::size_t size = 348;

  template <class Number>
  [[nodiscard]] Number at(std::size_t place) const {
    std::array<unsigned char, sizeof(Number)> bytes{};
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(place), bytes.size(), bytes.begin());
    if (swapped_) std::ranges::reverse(bytes);
    return std::bit_cast<Number>(bytes);
  }
  void check_numbers() const;
  [[nodiscard]] std::int64_t first_voxel() const;
  [[nodiscard]] std::int64_t voxel_bytes() const;

  std::filesystem::path path_;
  std::array<unsigned char, size> bytes_{};
  bool swapped_ = false;
};

}  // namespace palpate::app
