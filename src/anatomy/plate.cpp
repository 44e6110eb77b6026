#include "anatomy/plate.hpp"

#include "anatomy/largest_part.hpp"
#include "scene/generators.hpp"

namespace palpate::anatomy {
namespace {

bool is_hole(int i, int j, const std::array<int, 2>& cells) {
  return i % 2 == 1 && j % 2 == 1 && i + 1 < cells[0] && j + 1 < cells[1];
}

}  // namespace

TetMesh make_plate(const PlateOptions& options) {
  const auto& [nx, ny] = options.cells;
  const Vec3 size{nx * options.cell, ny * options.cell, options.thickness};
  TetMesh plate = make_box({nx, ny, 1}, size);
  constexpr std::size_t tets_a_cell = 5;
  std::vector<Tet> kept;
  for (std::size_t t = 0; t < plate.tets.size(); ++t) {
    const auto cell = static_cast<int>(t / tets_a_cell);
    if (!options.perforated || !is_hole(cell % nx, cell / nx, options.cells)) kept.push_back(plate.tets[t]);
  }
  plate.tets = kept;
  for (Vec3& p : plate.points) {
    const double x = p.x + 0.5 * size.x + options.start.x;
    const double y = p.y + 0.5 * size.y + options.start.y;
    p = {x, y, options.bottom(x, y) + p.z + 0.5 * size.z};
  }
  return largest_part(plate);
}

}  // namespace palpate::anatomy
