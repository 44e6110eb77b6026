#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <variant>

#include <palpate/mesh.hpp>
#include <palpate/types.hpp>

namespace palpate::io {

/// A named array of a .vtu file, one value per point or per tet. Its values must outlive it.
struct NamedArray {
  std::string name;  ///< not empty, without <, & and "
  /// Written as Float64 (rows of `components`), Float64 with 3 components, Int32 or UInt8.
  std::variant<std::span<const double>, std::span<const Vec3>, std::span<const Index>,
               std::span<const std::uint8_t>>
      values;
  int components = 1;  ///< numbers per row, where `values` are plain numbers
  std::string unit{};  ///< stored as the array's UNITS_LABEL; empty: none
};

/// The content of a .vtu file. Spans must outlive it.
struct VtuData {
  std::span<const Vec3> points;              ///< (n_points x 3)
  std::span<const Tet> tets;                 ///< (n_tets x 4), indices into points
  std::span<const NamedArray> point_arrays;  ///< each of n_points values
  std::span<const NamedArray> tet_arrays;    ///< each of n_tets values
  std::optional<double> time;                ///< stored as the field array "TimeValue", which ParaView shows
};

/// Writes a VTK XML unstructured grid: appended raw binary, zlib-compressed, little-endian, 64-bit block
/// headers.
///
/// The same data gives the same bytes. The file appears complete or not at all (AtomicFile). Throws Error
/// naming the path if it cannot be written, and naming the array or tet if an array's length or an index does
/// not fit. O(n).
void write_vtu(const std::filesystem::path& path, const VtuData& data);

/// The state of all bodies at one step, for a frame. Spans must outlive it.
struct FrameState {
  double time = 0.0;                         ///< s
  std::span<const Vec3> positions;           ///< (n_points x 3)
  std::span<const Vec3> velocities;          ///< (n_points x 3)
  std::span<const std::uint8_t> in_contact;  ///< (n_points), 1 for a point that is in a tet of another body
  std::span<const double> depths;  ///< (n_points), largest penetration depth of the point, 0 without contact
  std::string length_unit{};       ///< names of units, or empty
  std::string speed_unit{};
  std::span<const NamedArray> point_fields{};  ///< further fields, each of n_points rows
  std::span<const NamedArray> tet_fields{};    ///< further fields, each of n_tets rows
};

/// Writes a frame: the tets at `positions` with the point arrays displacement (from rest), velocity, body,
/// contact and depth, the tet array body, and the fields. Throws as write_vtu() does. O(n).
void write_frame(const std::filesystem::path& path, const Bodies& bodies, const FrameState& state);

}  // namespace palpate::io
