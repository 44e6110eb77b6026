#include "io/point_arrays.hpp"

#include <algorithm>

#include "io/file_bytes.hpp"
#include "io/vtu_arrays.hpp"
#include "io/vtu_structure.hpp"

namespace palpate::io {
namespace {

constexpr const char* what = "a frame of a run";
/// Maximum number of components; our arrays never have more.
constexpr std::int64_t most_components = 64;

}  // namespace

std::vector<PointArrayInfo> list_point_arrays(const std::filesystem::path& path) {
  const std::string text = read_file(path, what);
  const VtuStructure structure = read_vtu_structure(path.string(), text);
  std::vector<PointArrayInfo> list;
  if (structure.pieces.size() != 1) return list;
  for (const VtuArray& array : structure.pieces.front().point_data) {
    if (array.components >= 1 && array.components <= most_components)
      list.push_back({array.name, static_cast<int>(array.components)});
  }
  return list;
}

std::vector<double> read_point_array(const std::filesystem::path& path, const std::string& name) {
  const std::string text = read_file(path, what);
  const VtuStructure structure = read_vtu_structure(path.string(), text);
  if (structure.pieces.size() != 1) return {};
  const VtuPiece& piece = structure.pieces.front();
  const auto array = std::ranges::find(piece.point_data, name, &VtuArray::name);
  if (array == piece.point_data.end() || array->components < 1 || array->components > most_components)
    return {};
  return VtuArrays(path.string(), text, structure).reals_or_nan(*array, array->components * piece.points);
}

}  // namespace palpate::io
