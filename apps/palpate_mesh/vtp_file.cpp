#include <fmt/format.h>
#include <limits>
#include <optional>

#include <palpate/error.hpp>

#include "io/vtu_arrays.hpp"
#include "io/vtu_structure.hpp"
#include "surface_file.hpp"

namespace palpate::app {
namespace {

constexpr io::VtkXmlGrid poly_data{"PolyData", "NumberOfPolys", "Polys"};

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
    if (piece.points > most - static_cast<std::int64_t>(first) || piece.cells > most) {
      throw Error(source_, "", fmt::format("{} points and {} polygons in a piece", piece.points, piece.cells),
                  fmt::format("at most {} of each", most));
    }
    if (piece.points > 0) {
      const std::vector<double> values =
          arrays_.reals(require(piece.coordinates, "Points"), 3 * piece.points);
      for (std::size_t i = 0; i < values.size(); i += 3)
        file_.points.push_back({values[i], values[i + 1], values[i + 2]});
    }
    if (piece.cells > 0) append_polygons(piece, static_cast<Index>(first));
  }

  void append_polygons(const io::VtuPiece& piece, Index first) {
    const std::vector<std::int64_t> ends = arrays_.integers(require(piece.offsets, "offsets"), piece.cells);
    std::int64_t begin = 0;
    for (std::size_t c = 0; c < ends.size(); ++c) {
      if (ends[c] < begin) {
        throw Error(source_, fmt::format("offsets, number {}", c), fmt::format("{}", ends[c]),
                    fmt::format("{} or more: they ascend", begin));
      }
      begin = ends[c];
    }
    const std::vector<std::int64_t> corners =
        arrays_.integers(require(piece.connectivity, "connectivity"), begin);
    std::size_t next = 0;
    for (const std::int64_t end : ends) {
      std::vector<Index>& polygon = file_.polygons.emplace_back();
      for (; next < static_cast<std::size_t>(end); ++next) {
        if (corners[next] < 0 || corners[next] >= piece.points) {
          throw Error(source_, fmt::format("polygon {}", file_.polygons.size() - 1),
                      fmt::format("point {}", corners[next]), fmt::format("one of {} points", piece.points));
        }
        polygon.push_back(first + static_cast<Index>(corners[next]));
      }
    }
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
