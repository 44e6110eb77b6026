#include "tissue_sizes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/vector.hpp"

namespace palpate::app {
namespace {

using Step = std::array<int, 3>;

/// Directions to the 26 neighbours of a voxel, one of each two opposite ones.
std::array<Step, 13> directions() {
  std::array<Step, 13> found{};
  std::size_t count = 0;
  for_points({3, 3, 3}, [&](int i, int j, int k) {
    if (count < found.size()) found[count++] = {i - 1, j - 1, k - 1};
  });
  return found;
}

Vec3 scaled(const Vec3& spacing, const Step& step) {
  return {spacing.x * step[0], spacing.y * step[1], spacing.z * step[2]};
}

/// Length of the run of voxels of one tissue through a voxel; `most` where it is longer, or leaves the map.
double run_length(const Tissues& tissues, const Step& voxel, const Step& step, double most) {
  const double length_of_step = length(scaled(tissues.spacing(), step));
  const int tissue = tissues.voxel(voxel[0], voxel[1], voxel[2]);
  double run = length_of_step;
  for (const int sign : {-1, 1}) {
    Step at = voxel;
    while (run < most) {
      for (std::size_t a = 0; a < 3; ++a) {
        at[a] += sign * step[a];
        if (at[a] < 0 || at[a] >= tissues.size()[a]) return most;
      }
      if (tissues.voxel(at[0], at[1], at[2]) != tissue) break;
      run += length_of_step;
    }
  }
  return std::min(run, most);
}

/// Lowers values so that they grow by at most `growth` times the distance, along the edges and diagonals of
/// the lattice: a forward and a backward pass (Borgefors 1986).
void limit_growth(Lattice& field, double growth) {
  const std::array<Step, 13> before = directions();
  const auto pass = [&](int sign) {
    for_points(field.size, [&](int x, int y, int z) {
      Step here{x, y, z};
      if (sign < 0) here = {field.size[0] - 1 - x, field.size[1] - 1 - y, field.size[2] - 1 - z};
      float& value = field.values[field.index(here[0], here[1], here[2])];
      for (const Step& step : before) {
        Step there{};
        bool inside = true;
        for (std::size_t a = 0; a < 3; ++a) {
          there[a] = here[a] + sign * step[a];
          inside = inside && there[a] >= 0 && there[a] < field.size[a];
        }
        if (!inside) continue;
        const double reach = growth * length(scaled(field.spacing, step));
        value = std::min(value,
                         field.values[field.index(there[0], there[1], there[2])] + static_cast<float>(reach));
      }
    });
  };
  pass(1);
  pass(-1);
}

bool meets(const Tissues& tissues, const Step& v, int other) {
  bool found = false;
  for_points({3, 3, 3}, [&](int i, int j, int k) {
    found = found || tissues.voxel(v[0] + i - 1, v[1] + j - 1, v[2] + k - 1) == other;
  });
  return found;
}

double size_at(const Tissues& tissues, const TissueSizes& sizes, const Step& v) {
  const int tissue = tissues.voxel(v[0], v[1], v[2]);
  const double own = sizes.own[static_cast<std::size_t>(tissue)];
  double size = own > 0.0 ? own : sizes.general;
  for (const auto& [pair, limit] : sizes.interfaces) {
    if (limit >= size || (pair[0] != tissue && pair[1] != tissue)) continue;
    if (meets(tissues, v, pair[0] == tissue ? pair[1] : pair[0])) size = limit;
  }
  for (const auto& [center, radius, limit] : sizes.focuses) {
    if (length(scaled(tissues.spacing(), v) - center) <= radius) size = std::min(size, limit);
  }
  return size;
}

}  // namespace

std::vector<float> thickness_of(const Tissues& tissues, double most) {
  const std::array<Step, 13> all = directions();
  std::vector<float> thickness;
  thickness.reserve(tissues.voxels().size());
  for_points(tissues.size(), [&](int i, int j, int k) {
    double least = most;
    for (const Step& step : all) least = std::min(least, run_length(tissues, {i, j, k}, step, least));
    thickness.push_back(static_cast<float>(least));
  });
  return thickness;
}

Lattice size_field(const Tissues& tissues, const TissueSizes& sizes, std::span<const float> thickness) {
  Lattice field{tissues.size(), {}, tissues.spacing(), {}};
  field.values.reserve(thickness.size());
  for_points(tissues.size(), [&](int i, int j, int k) {
    const double thin = sizes.of_thickness * static_cast<double>(thickness[field.values.size()]);
    field.values.push_back(static_cast<float>(std::min(thin, size_at(tissues, sizes, {i, j, k}))));
  });
  limit_growth(field, sizes.growth);
  return field;
}

}  // namespace palpate::app
