#include <algorithm>
#include <cmath>
#include <utility>

#include "anatomy/eye_shapes.hpp"
#include "anatomy/millimetres.hpp"
#include "anatomy/organs.hpp"
#include "anatomy/plate.hpp"

namespace palpate::anatomy {
namespace {

constexpr double cell_size = 1.2;   ///< about
constexpr double steepness = 0.25;  ///< of a flat plate, and of the floor in front of a plate

void check_options(const OrbitPlate& options, const char* function) {
  const MillimetreCheck check{function};
  check("width", options.width, 4.0, 26.0);
  check("length", options.length, 4.0, 30.0);
  check("x", options.x, -8.0, 8.0);
  check("y", options.y, 0.0, 16.0);
  check("thickness", options.thickness, 0.2, 3.0);
  check("above", options.above, 0.0, 5.0);
}

/// The cells of a plate, and the function of its lower side.
PlateOptions plate_options(const OrbitPlate& options) {
  const auto across = static_cast<int>(std::lround(options.width / cell_size));
  const double cell = options.width / across;
  const auto along = static_cast<int>(std::lround(options.length / cell));
  const Vec3 start{options.x - 0.5 * options.width, options.y - 0.5 * along * cell, 0.0};
  PlateOptions plate{.cells = {across, along},
                     .cell = cell,
                     .thickness = options.thickness,
                     .start = start,
                     .bottom = {},
                     .perforated = false};
  plate.bottom = [above = options.above](double x, double y) { return over_orbit_floor(x, y, above); };
  if (!options.flat) return plate;
  // The lowest plane z = steepness y + height that is nowhere below the floor.
  double height = -100.0;
  for (int i = 0; i <= across; ++i) {
    for (int j = 0; j <= along; ++j) {
      const double y = start.y + j * cell;
      height = std::max(height, plate.bottom(start.x + i * cell, y) - steepness * y);
    }
  }
  plate.bottom = [height](double, double y) { return steepness * y + height; };
  return plate;
}

/// The upper side of a retractor: over the plate and in front of it `clearance` above the plate's upper side.
/// Beside and behind the plate it descends to `sunk` below the floor, so that its border presses no tissue.
class RetractorTop {
 public:
  static constexpr double clearance = 0.8;
  static constexpr double slope = 5.0;  ///< width of the descent, mm
  static constexpr double sunk = 0.6;
  static constexpr double wall = 7.0;  ///< at most this high over the middle of the floor, mm

  RetractorTop(PlateOptions plate, double middle)
      : plate_(std::move(plate)),
        middle_(middle),
        upper_{plate_.start.x + plate_.cells[0] * plate_.cell, plate_.start.y + plate_.cells[1] * plate_.cell,
               0.0} {}

  double operator()(double x, double y) const {
    const double u = std::clamp(x, plate_.start.x, upper_.x);
    const double v = std::clamp(y, plate_.start.y, upper_.y);
    const double rise = plate_.bottom(u, v) + plate_.thickness + clearance - floor(u, v);
    const double fall = smooth_step(std::abs(x - u) / slope) + smooth_step(std::max(y - v, 0.0) / slope);
    const double kept = std::max(1.0 - fall, 0.0);
    return std::min(floor(x, y) + kept * rise - (1.0 - kept) * sunk, floor(middle_, y) + wall);
  }

 private:
  static double smooth_step(double t) {
    const double s = std::clamp(t, 0.0, 1.0);
    return s * s * (3.0 - 2.0 * s);
  }
  /// The floor, in front of the plate as steep as a flat plate: there the orbit ends.
  [[nodiscard]] double floor(double x, double y) const {
    const double inside = std::max(y, plate_.start.y);
    return over_orbit_floor(x, inside, 0.0) + steepness * (y - inside);
  }

  PlateOptions plate_;
  double middle_;
  Vec3 upper_;
};

}  // namespace

TetMesh make_orbit_plate(const OrbitPlate& options) {
  check_options(options, "make_orbit_plate");
  return make_plate(plate_options(options));
}

TetMesh make_orbit_retractor(const OrbitPlate& options) {
  check_options(options, "make_orbit_retractor");
  constexpr double thickness = 0.8;
  constexpr double front = -10.0;  // y: in front of the tissue
  const RetractorTop top(plate_options(options), options.x);
  const double half = 0.5 * options.width + RetractorTop::slope;
  const double back = options.y + 0.5 * options.length + RetractorTop::slope;
  const auto across = static_cast<int>(std::lround(2.0 * half / cell_size));
  const double cell = 2.0 * half / across;
  return make_plate({.cells = {across, static_cast<int>(std::lround((back - front) / cell))},
                     .cell = cell,
                     .thickness = thickness,
                     .start = {options.x - half, front, 0.0},
                     .bottom = [&](double x, double y) { return top(x, y) - thickness; },
                     .perforated = false});
}

}  // namespace palpate::anatomy
