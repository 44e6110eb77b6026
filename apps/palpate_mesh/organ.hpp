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
  Lattice field;              ///< about the distance to the surface, > 0 inside, mm; in the organ's frame
  Frame frame;                ///< from the axes of the field to the world
  double input_volume = 0.0;  ///< of the voxels of the label, or inside the surface, mm^3
  std::vector<std::string> remarks;  ///< what is worth telling of the input
  double thickness = 0.0;            ///< twice the volume over the area, mm; 0: not known
};

/// The mask of a label, 1 in it and 0 elsewhere, blurred; on voxel centres of its box with a margin. `map`
/// must hold the label in `extent`. O(voxels of the box), 20 bytes each.
Lattice blurred_mask(const LabelMap& map, const LabelExtent& extent, const Shaping& shaping);

/// One over the slope of a blurred step, about: 1 / (s sqrt(2 pi)) for the blur s; mm.
double blur_width(const LabelMap& map, const Shaping& shaping);

/// About the distance in mm to the faces of the voxels of labels that count, > 0 outside them, on the points
/// of blurred_mask(); none where there are none. Costs what blurred_mask() does.
std::optional<Lattice> distance_to_labels(const LabelMap& map, const LabelExtent& extent,
                                          const Shaping& shaping,
                                          const std::function<bool(std::int32_t)>& counts);

/// The smooth shape of a label: its blurred mask, cut at the value at which it has the volume of its voxels,
/// and away from other labels by half the gap. `map` must hold the label in `extent`. O(voxels of the box),
/// 20 bytes each.
Lattice label_field(const LabelMap& map, const LabelExtent& extent, const Shaping& shaping);

/// The shape of a closed surface.
struct SurfaceShape {
  Lattice field;                     ///< as that of an organ
  double volume = 0.0;               ///< inside the surface, mm^3
  double thickness = 0.0;            ///< as that of an organ
  std::vector<std::string> remarks;  ///< what is worth telling of the surface
};

/// The smooth shape of a closed surface mesh: its signed distance at the points of a lattice with 150 steps
/// along the diagonal of its box, less half the gap. Throws Error naming the file where it is missing or
/// damaged, empty, or not closed (see closed_surface()).
SurfaceShape surface_field(const std::filesystem::path& path, const Shaping& shaping);

}  // namespace palpate::app
