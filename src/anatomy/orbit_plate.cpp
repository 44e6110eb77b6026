#include <algorithm>
#include <cmath>

#include "anatomy/eye_shapes.hpp"
#include "anatomy/millimetres.hpp"
#include "anatomy/organs.hpp"
#include "anatomy/plate.hpp"

namespace palpate::anatomy {

TetMesh make_orbit_plate(const OrbitPlate& options) {
  const MillimetreCheck check{"make_orbit_plate"};
  check("width", options.width, 4.0, 26.0);
  check("length", options.length, 4.0, 30.0);
  check("x", options.x, -8.0, 8.0);
  check("y", options.y, 0.0, 16.0);
  check("thickness", options.thickness, 0.2, 3.0);
  check("above", options.above, 0.0, 5.0);
  constexpr double about = 1.2;
  const auto across = static_cast<int>(std::lround(options.width / about));
  const double cell = options.width / across;
  const auto along = static_cast<int>(std::lround(options.length / cell));
  const Vec3 start{options.x - 0.5 * options.width, options.y - 0.5 * along * cell, 0.0};
  // The lower side of a flat plate: the lowest plane z = steep y + height that is nowhere below the floor.
  constexpr double steep = 0.25;
  double height = -100.0;
  for (int i = 0; i <= across; ++i) {
    for (int j = 0; j <= along; ++j) {
      const double y = start.y + j * cell;
      height = std::max(height, over_orbit_floor(start.x + i * cell, y, options.above) - steep * y);
    }
  }
  const auto bottom = [&](double x, double y) {
    return options.flat ? steep * y + height : over_orbit_floor(x, y, options.above);
  };
  return make_plate({.cells = {across, along},
                     .cell = cell,
                     .thickness = options.thickness,
                     .start = start,
                     .bottom = bottom,
                     .perforated = false});
}

}  // namespace palpate::anatomy
