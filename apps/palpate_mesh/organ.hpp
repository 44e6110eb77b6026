#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "label_map.hpp"
#include "lattice.hpp"
#include "mesh_options.hpp"

namespace palpate::app {

/// Something to mesh: a label of a map, or a closed surface.
struct Organ {
  std::string name;
  std::optional<std::array<double, 3>> color;
  Lattice field;              ///< approximate distance to the surface, > 0 inside, mm; in the organ's frame
  Frame frame;                ///< from the axes of the field to the world
  double input_volume = 0.0;  ///< of the voxels of the label, or inside the surface, mm^3
  std::vector<std::string> remarks;  ///< for the user
  double thickness = 0.0;            ///< twice the volume over the area, mm; 0: unknown
};

/// The mask of a label, 1 in it and 0 elsewhere, blurred; on voxel centres of its box with a margin. `map`
/// must hold the label in `extent`. O(voxels of the box), 20 bytes each.
Lattice blurred_mask(const LabelMap& map, const LabelExtent& extent, const Shaping& shaping);

/// Width of a blurred step, mm: one over its slope, which is about 1 / (s sqrt(2 pi)) for the blur s.
double blur_width(const LabelMap& map, const Shaping& shaping);

/// Approximate distance in mm to the voxel faces of the labels for which `counts` is true, > 0 outside them,
/// at the points of blurred_mask(); none where there are no such labels. Costs as much as blurred_mask().
std::optional<Lattice> distance_to_labels(const LabelMap& map, const LabelExtent& extent,
                                          const Shaping& shaping,
                                          const std::function<bool(std::int32_t)>& counts);

/// The smooth shape of a label: the level set of its blurred mask that has the volume of its voxels, at a
/// distance of half the gap from other labels. `map` must hold the label in `extent`. O(voxels of the box),
/// 20 bytes each.
Lattice label_field(const LabelMap& map, const LabelExtent& extent, const Shaping& shaping);

/// The shape of a closed surface.
struct SurfaceShape {
  Lattice field;                     ///< like that of an Organ
  double volume = 0.0;               ///< like Organ::input_volume
  double thickness = 0.0;            ///< like Organ::thickness
  std::vector<std::string> remarks;  ///< for the user
};

/// The smooth shape of a closed surface mesh: its signed distance at the points of a lattice with 150 steps
/// along the diagonal of its box, less half the gap. Throws Error naming the file if it is missing or
/// damaged, empty, or not closed (see closed_surface()).
SurfaceShape surface_field(const std::filesystem::path& path, const Shaping& shaping);

}  // namespace palpate::app
