#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <palpate/types.hpp>

namespace palpate::app {

/// A scalar field: values at the points of a lattice, trilinear interpolation between them.
struct Lattice {
  std::array<int, 3> size{};  ///< points along x, y, z; each >= 2
  Vec3 origin{};              ///< of point (0, 0, 0)
  Vec3 spacing{1.0, 1.0, 1.0};
  std::vector<float> values;  ///< (z, y, x), x fastest

  [[nodiscard]] std::size_t index(int i, int j, int k) const {
    const auto row =
        static_cast<std::size_t>(k) * static_cast<std::size_t>(size[1]) + static_cast<std::size_t>(j);
    return row * static_cast<std::size_t>(size[0]) + static_cast<std::size_t>(i);
  }
  [[nodiscard]] Vec3 place(int i, int j, int k) const {
    return {origin.x + spacing.x * i, origin.y + spacing.y * j, origin.z + spacing.z * k};
  }
  /// The value at a position; outside the lattice, the value at the nearest position in it.
  [[nodiscard]] double operator()(const Vec3& p) const;
};

/// Calls f(i, j, k) for each point of the lattice, or for each cell by its lowest corner, in the order of
/// `values`.
template <class Function>
void for_points(const std::array<int, 3>& size, Function&& f) {
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) f(i, j, k);
    }
  }
}

/// The level for which the region above it has the given volume (by sampling cells); the least value where
/// the volume is larger than the lattice. O(points).
double level_of_volume(const Lattice& lattice, double volume);

/// Volume where the lattice is above 0, by sampling cells. O(points).
double positive_volume(const Lattice& lattice);

/// Twice the volume over the area, of the shape where the lattice is above 0; infinite without a surface.
/// O(points).
double mean_thickness(const Lattice& lattice);

/// Points where the surface of a shape crosses the lattice, as seeds of a mesher.
struct SurfaceSeeds {
  std::vector<Vec3> points;
  int components = 0;  ///< parts of the positive points of the lattice that no path along its edges joins
};

/// Points of the surface (value 0), no closer to each other than `spacing`, but closer on small components.
/// The same lattice gives the same points. O(points).
SurfaceSeeds surface_seeds(const Lattice& lattice, double spacing);

}  // namespace palpate::app
