#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <palpate/types.hpp>

namespace palpate::fem {

/// A tet to be put into a patch.
struct PatchTet {
  Tet corners{};
  Index material = 0;  ///< a patch has tets of one material
};

/// Divides tets into patches, the domains of constant pressure of nearly incompressible tissue
/// (smoothing_domains.hpp). Returns the patch of each tet, 0 to the number of patches.
///
/// A patch is the tets at one point, its centre, and tets beside them. Centres are chosen greedily, points
/// with the most tets first, such that no two share a tet. Each tet left joins the patch with which it shares
/// the most faces, then the smaller patch. A patch of fewer than `least_patch_tets` is joined to the one with
/// which it shares the most faces: a small patch at a corner of the body would have almost no freedom beside
/// its constraint of volume. Depends only on the numbering of points and tets, not on positions.
/// O(n_tets log).
[[nodiscard]] std::vector<std::uint32_t> volume_patches(std::span<const PatchTet> tets);

inline constexpr std::size_t least_patch_tets = 8;

}  // namespace palpate::fem
