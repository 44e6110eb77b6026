#pragma once

#include <array>
#include <functional>

#include <palpate/mesh.hpp>

namespace palpate::anatomy {

/// A plate that follows a surface.
struct PlateOptions {
  std::array<int, 2> cells{1, 1};                ///< along x and y, >= 1
  double cell = 1.0;                             ///< edge length, > 0
  double thickness = 1.0;                        ///< along z, > 0
  Vec3 start;                                    ///< corner with the least x and y
  std::function<double(double, double)> bottom;  ///< z of the lower side at (x, y)
  bool perforated = true;
};

/// A mesh of 5 tets for each cell, mirrored in alternate cells as in make_box(). In a perforated plate, inner
/// cells with odd numbers along both axes are holes. Throws Error if an option is out of range.
TetMesh make_plate(const PlateOptions& options);

}  // namespace palpate::anatomy
