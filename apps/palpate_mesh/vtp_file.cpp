#include <algorithm>
#include <fmt/format.h>
#include <limits>
#include <optional>

#include <palpate/error.hpp>

#include "io/vtu_arrays.hpp"
#include "io/vtu_structure.hpp"
#include "surface_file.hpp"
#include "vtk_polygons.hpp"

namespace palpate::app {
namespace {

constexpr io::VtkXmlGrid poly_data{"PolyData", "NumberOfPolys", "Polys", "NumberOfStrips", "Strips"};

class VtpReader {
 public:
  VtpReader(const std::string& source, std::string_view bytes)
      : source_(source),
        structure_(io::read_vtu_structure(source, bytes, poly_data)),
        arrays_(source, bytes, structure_) {}

  PolygonFile read() {
    for (const io::VtuPiece& piece : structure_.pieces) append(piece);
    return std::move(file_);
  }

 private:
  [[nodiscard]] const io::VtuArray& require(const std::optional<io::VtuArray>& array,
                                            const char* name) const {
    if (!array) throw Error(source_, "", fmt::format("a piece without an array of {}", name), "one");
    return *array;
  }

  void append(const io::VtuPiece& piece) {
    const std::size_t first = file_.points.size();
    constexpr std::int64_t most = std::numeric_limits<Index>::max();
    const std::int64_t cells = std::max(piece.cells.count, piece.strips.count);
    if (piece.points > most - static_cast<std::int64_t>(first) || cells > most) {
      throw Error(source_, "", fmt::format("{} points and {} polygons in a piece", piece.points, cells),
                  fmt::format("at most {} of each", most));
    }
    if (piece.points > 0) {
      const std::vector<double> values =
          arrays_.reals(require(piece.coordinates, "Points"), 3 * piece.points);
      for (std::size_t i = 0; i < values.size(); i += 3)
        file_.points.push_back({values[i], values[i + 1], values[i + 2]});
    }
    const auto points = static_cast<Index>(piece.points);
    append_polygons(arrays_of(piece.cells), static_cast<Index>(first), points, source_, file_);
    append_strips(arrays_of(piece.strips), static_cast<Index>(first), points, source_, file_);
  }

  [[nodiscard]] io::VtkCells arrays_of(const io::VtuCells& cells) const {
    io::VtkCells read;
    if (cells.count == 0) return read;
    read.ends = arrays_.integers(require(cells.offsets, "offsets"), cells.count);
    for (std::size_t c = 0; c < read.ends.size(); ++c) {
      const std::int64_t before = c == 0 ? 0 : read.ends[c - 1];
      if (read.ends[c] >= before) continue;
      throw Error(source_, fmt::format("offsets, number {}", c), fmt::format("{}", read.ends[c]),
                  fmt::format("{} or more, since offsets ascend", before));
    }
    read.connectivity = arrays_.integers(require(cells.connectivity, "connectivity"), read.ends.back());
    return read;
  }

  const std::string& source_;
  io::VtuStructure structure_;
  io::VtuArrays arrays_;
  PolygonFile file_;
};

}  // namespace

PolygonFile read_vtp(const std::string& source, std::string_view bytes) {
  return VtpReader(source, bytes).read();
}

}  // namespace palpate::app
