#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/vtk_scalars.hpp"

namespace palpate::io {

/// A kind of VTK XML file: the names of its elements.
struct VtkXmlGrid {
  std::string_view type;          ///< "UnstructuredGrid"
  std::string_view count;         ///< the number of cells of a piece: "NumberOfCells"
  std::string_view cells;         ///< what holds their arrays: "Cells"
  std::string_view strips_count;  ///< the same of triangle strips; empty where there are none
  std::string_view strips;
};
inline constexpr VtkXmlGrid unstructured_grid{"UnstructuredGrid", "NumberOfCells", "Cells", "", ""};

/// A DataArray of a .vtu file: type and place of its numbers.
struct VtuArray {
  enum class Format { ascii, binary, appended };
  std::string name;  ///< in words for messages: "Points", "connectivity" …
  ScalarType type;
  Format format = Format::ascii;
  std::int64_t components = 1;
  std::uint64_t offset = 0;  ///< appended data: offset after the '_'
  std::size_t begin = 0;     ///< offset of the element's content in the file
  std::size_t end = 0;
};

/// The arrays of the cells of a piece.
struct VtuCells {
  std::int64_t count = 0;
  std::optional<VtuArray> connectivity;
  std::optional<VtuArray> offsets;
  std::optional<VtuArray> types;  ///< none for polygons and strips
};

/// One Piece: the arrays that a mesh needs.
struct VtuPiece {
  std::int64_t points = 0;
  std::optional<VtuArray> coordinates;
  VtuCells cells;
  VtuCells strips;
  std::vector<VtuArray> point_data;  ///< those with a known type of numbers
  std::vector<VtuArray> cell_data;   ///< the same
};

/// The structure of a .vtu file, without the numbers of its arrays.
struct VtuStructure {
  enum class Compressor { none, zlib, lz4, lzma };
  bool swapped = false;          ///< the byte order is not this machine's
  std::size_t header_bytes = 4;  ///< of each header word before binary data
  Compressor compressor = Compressor::none;
  std::vector<VtuPiece> pieces;
  std::size_t appended_begin = 0;  ///< after the '_' of AppendedData
  std::size_t appended_end = 0;
  bool appended_is_base64 = false;
};

/// Reads the structure. Throws Error naming the line unless the file is a complete VTK XML file of such a
/// grid.
VtuStructure read_vtu_structure(const std::string& source, std::string_view text,
                                const VtkXmlGrid& grid = unstructured_grid);

}  // namespace palpate::io
