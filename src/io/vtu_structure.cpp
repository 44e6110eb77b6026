#include "io/vtu_structure.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <fmt/format.h>

#include "io/text_scanner.hpp"
#include "io/xml_scanner.hpp"

namespace palpate::io {
namespace {

class StructureReader {
 public:
  StructureReader(const std::string& source, std::string_view text, const VtkXmlGrid& grid)
      : text_(text), xml_(source, text), grid_(grid) {}

  VtuStructure read() {
    while (xml_.next(tag_)) {
      end_array();
      if (tag_.opens) path_.emplace_back(tag_.name);
      if (tag_.opens) open();
      if (tag_.closes) path_.pop_back();
    }
    if (!has_grid_) xml_.fail(text_.size(), fmt::format("no {}", grid_.type), "one");
    return std::move(result_);
  }

 private:
  void open() {
    if (path_.size() == 1) {
      read_root();
    } else if (is_at({"VTKFile", grid_.type})) {
      has_grid_ = true;
    } else if (is_at({"VTKFile", grid_.type, "Piece"})) {
      VtuPiece& piece = result_.pieces.emplace_back();
      piece.points = integer("NumberOfPoints");
      piece.cells.count = integer(grid_.count);
      if (!grid_.strips.empty() && !attribute(grid_.strips_count).empty())
        piece.strips.count = integer(grid_.strips_count);
    } else if (is_at({"VTKFile", grid_.type, "Piece", "Points", "DataArray"})) {
      open_array(result_.pieces.back().coordinates, "Points");
    } else if (is_at({"VTKFile", grid_.type, "Piece", "PointData", "DataArray"})) {
      open_data(result_.pieces.back().point_data);
    } else if (is_at({"VTKFile", grid_.type, "Piece", "CellData", "DataArray"})) {
      open_data(result_.pieces.back().cell_data);
    } else if (is_at({"VTKFile", grid_.type, "Piece", grid_.cells, "DataArray"})) {
      open_array_of(result_.pieces.back().cells);
    } else if (!grid_.strips.empty() && is_at({"VTKFile", grid_.type, "Piece", grid_.strips, "DataArray"})) {
      open_array_of(result_.pieces.back().strips);
    } else if (is_at({"VTKFile", "AppendedData"})) {
      read_appended();
    }
  }

  void open_array_of(VtuCells& cells) {
    const std::string_view name = attribute("Name");
    if (name == "connectivity") open_array(cells.connectivity, name);
    if (name == "offsets") open_array(cells.offsets, name);
    if (name == "types") open_array(cells.types, name);
  }

  /// The numbers of an array end at the next tag: its end tag, or the information keys that VTK adds behind
  /// them.
  void end_array() {
    if (array_ == nullptr) return;
    array_->end = tag_.begin;
    array_ = nullptr;
  }

  [[nodiscard]] bool is_at(std::initializer_list<std::string_view> path) const {
    return std::equal(path_.begin(), path_.end(), path.begin(), path.end());
  }

  [[nodiscard]] std::string_view attribute(std::string_view name, std::string_view absent = {}) const {
    for (const auto& [key, value] : tag_.attributes) {
      if (key == name) return value;
    }
    return absent;
  }

  /// A whole number, 0 or more.
  static std::optional<std::int64_t> count(std::string_view digits) {
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc{} || end != digits.data() + digits.size() || value < 0) return std::nullopt;
    return value;
  }
  static bool is_count(std::string_view digits) { return count(digits).has_value(); }

  std::int64_t integer(std::string_view name) {
    const std::optional<std::int64_t> value = count(attribute(name));
    if (!value) fail(fmt::format("{}={}", name, in_quotes(attribute(name))), "a whole number, 0 or more");
    return *value;
  }

  [[noreturn]] void fail(const std::string& found, const std::string& expected) {
    xml_.fail(tag_.begin, found, expected);
  }

  void read_root() {
    if (tag_.name != "VTKFile") fail(in_quotes(tag_.name), "the tag VTKFile");
    if (attribute("type") != grid_.type) {
      fail(fmt::format("a VTKFile of type {}", in_quotes(attribute("type"))),
           fmt::format("type \"{}\"", grid_.type));
    }
    const std::string_view order = attribute("byte_order", "LittleEndian");
    if (order != "LittleEndian" && order != "BigEndian") {
      fail(fmt::format("byte_order={}", in_quotes(order)), "LittleEndian or BigEndian");
    }
    result_.swapped = (order == "LittleEndian") != (std::endian::native == std::endian::little);
    const std::string_view header = attribute("header_type", "UInt32");
    if (header != "UInt32" && header != "UInt64") {
      fail(fmt::format("header_type={}", in_quotes(header)), "UInt32 or UInt64");
    }
    result_.header_bytes = header == "UInt64" ? 8 : 4;
    read_compressor(attribute("compressor"));
  }

  void read_compressor(std::string_view name) {
    using Compressor = VtuStructure::Compressor;
    if (name.empty()) return;
    if (name == "vtkZLibDataCompressor") {
      result_.compressor = Compressor::zlib;
    } else if (name == "vtkLZ4DataCompressor") {
      result_.compressor = Compressor::lz4;
    } else if (name == "vtkLZMADataCompressor") {
      result_.compressor = Compressor::lzma;
    } else {
      fail(fmt::format("compressor={}", in_quotes(name)),
           "vtkZLibDataCompressor, vtkLZ4DataCompressor or vtkLZMADataCompressor");
    }
  }

  /// Data that a mesh does not need is no reason to refuse the file: arrays of unknown types are left out.
  void open_data(std::vector<VtuArray>& arrays) {
    const std::string_view format = attribute("format", "ascii");
    const bool known = format == "ascii" || format == "binary" || format == "appended";
    if (!known || scalar_type(attribute("type")) == nullptr ||
        !is_count(attribute("NumberOfComponents", "1")) ||
        (format == "appended" && !is_count(attribute("offset"))))
      return;
    read_array(arrays.emplace_back(), attribute("Name"));
  }

  void open_array(std::optional<VtuArray>& array, std::string_view name) {
    if (array) fail(fmt::format("a second array of {}", name), "one");
    read_array(array.emplace(), name);
  }

  void read_array(VtuArray& array, std::string_view name) {
    const ScalarType* type = scalar_type(attribute("type"));
    if (type == nullptr) {
      fail(fmt::format("type={} of {}", in_quotes(attribute("type")), name),
           "a type of numbers such as Float64 or Int32");
    }
    array.name = name;
    array.type = *type;
    array.begin = tag_.end;
    array.end = tag_.end;
    if (!attribute("NumberOfComponents").empty()) array.components = integer("NumberOfComponents");
    const std::string_view format = attribute("format", "ascii");
    if (format == "appended") {
      array.format = VtuArray::Format::appended;
      array.offset = static_cast<std::uint64_t>(integer("offset"));
    } else if (format == "binary") {
      array.format = VtuArray::Format::binary;
    } else if (format != "ascii") {
      fail(fmt::format("format={} of {}", in_quotes(format), name), "ascii, binary or appended");
    }
    if (!tag_.closes) array_ = &array;
  }

  /// Raw AppendedData is not XML, so its end is searched from the end of the file.
  void read_appended() {
    const std::string_view encoding = attribute("encoding");
    if (encoding != "raw" && encoding != "base64")
      fail(fmt::format("encoding={}", in_quotes(encoding)), "raw or base64");
    result_.appended_is_base64 = encoding == "base64";
    const std::size_t mark = text_.find_first_not_of(" \t\r\n", tag_.end);
    const std::size_t end = text_.rfind("</AppendedData");
    if (mark == std::string_view::npos || text_[mark] != '_')
      fail("AppendedData that does not begin with \"_\"", "\"_\" before the data");
    if (end == std::string_view::npos || end <= mark) {
      xml_.fail(text_.size(), "the end of the file", "</AppendedData>");
    }
    result_.appended_begin = mark + 1;
    result_.appended_end = end;
    xml_.set_position(end);
  }

  std::string_view text_;
  XmlScanner xml_;
  const VtkXmlGrid& grid_;
  XmlTag tag_;
  std::vector<std::string_view> path_;
  VtuStructure result_;
  VtuArray* array_ = nullptr;  ///< the array whose element is open
  bool has_grid_ = false;
};

}  // namespace

VtuStructure read_vtu_structure(const std::string& source, std::string_view text, const VtkXmlGrid& grid) {
  return StructureReader(source, text, grid).read();
}

}  // namespace palpate::io
