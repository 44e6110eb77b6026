#pragma once

#include <string>
#include <vector>

#include "mesh_options.hpp"
#include "organ_source.hpp"
#include "tissue_bodies.hpp"
#include "tissue_sizes.hpp"

namespace palpate::app {

/// The settings of the tissues of a map by the flags; tissue t + 1 is label t of the map.
struct TissuePlan {
  std::vector<std::string> names;  ///< (n_tissues)
  std::vector<bool> rigid;         ///< (n_tissues)
  Relations relations;
  TissueSizes sizes;  ///< sizes without the general size
};

/// Throws BadInput if a flag names a tissue that does not exist.
TissuePlan plan_of(const MeshOptions& options, const NamedMap& map);

/// Throws Error if the relations of tissues whose voxels touch contradict each other, so that the user learns
/// it before meshing. O(voxels log).
void check_plan(const TissuePlan& plan, const NamedMap& map);

/// Remarks for the user on the labels, one line each: labels cut by the border of the map, islands, labels of
/// a few voxels. O(voxels).
std::vector<std::string> label_warnings(const NamedMap& map);

}  // namespace palpate::app
