#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <palpate/types.hpp>

/// Label maps and surfaces as text or bytes of their formats, written by hand from the formats' descriptions.
namespace palpate::test {

/// The label at a voxel.
using LabelAt = std::function<int(int i, int j, int k)>;

struct TestMap {
  std::array<int, 3> size{};
  std::array<Vec3, 3> steps{
      {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  ///< from a voxel to its neighbour along i, j, k
  Vec3 origin{};                           ///< centre of voxel (0, 0, 0)
  std::vector<std::uint8_t> labels;        ///< i fastest

  TestMap(std::array<int, 3> voxels, const LabelAt& label);
  [[nodiscard]] std::size_t count(int label) const;
  /// Volume of the voxels of a label.
  [[nodiscard]] double volume(int label) const;
  [[nodiscard]] Vec3 place(double i, double j, double k) const;
};

/// NRRD with raw data; `space` is that of its header, `more` are further lines of it.
std::string nrrd(const TestMap& map, const std::string& space = "left-posterior-superior",
                 const std::string& more = "");
/// NIfTI-1 with an sform: steps and origin are in RAS, as always there.
std::string nifti(const TestMap& map);
/// MetaImage in one file; LPS.
std::string meta_image(const TestMap& map);

/// Fewer than 65536 bytes as a zlib stream or a gzip file, stored without compression (RFC 1950 to 1952).
std::string zlib_stored(const std::string& bytes);
std::string gzip_stored(const std::string& bytes);

/// DICOM (explicit little-endian) of the slice k of a map, of a class of objects by its UID; LPS.
std::string dicom_slice(const TestMap& map, int k, const std::string& object_class);
inline constexpr const char* dicom_ct = "1.2.840.10008.5.1.4.1.1.2";
inline constexpr const char* dicom_secondary_capture = "1.2.840.10008.5.1.4.1.1.7";

/// Lines of a .seg.nrrd as 3D Slicer writes them.
std::string segment(int number, int label, const std::string& name, const std::string& color);

/// ASCII STL of a box; without its last triangle if it is to be open.
std::string box_stl(const Vec3& lower, const Vec3& upper, bool open = false);

}  // namespace palpate::test
