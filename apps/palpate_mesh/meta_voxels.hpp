#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace palpate::app {

/// What MetaIO tells of the header of a MetaImage.
struct MetaVoxels {
  std::vector<std::int64_t> size;  ///< voxels along each axis
  std::int64_t voxel_bytes = 1;    ///< bytes of a voxel
  std::string file;                ///< ElementDataFile: LOCAL, a file, LIST, or a pattern of files
  bool binary = true;              ///< BinaryData
  bool compressed = false;         ///< CompressedData
  std::int64_t skipped_bytes = 0;  ///< HeaderSize; -1: the voxels are at the end of their file
};

/// Throws Error unless the files of a MetaImage hold all voxels that its header names: ITK leaves the memory
/// of the others as it is. Reads compressed voxels and those written as text once.
void require_meta_voxels(const std::filesystem::path& path, const MetaVoxels& voxels);

}  // namespace palpate::app
