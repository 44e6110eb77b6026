#pragma once

#include <span>

#include <palpate/detection.hpp>
#include <palpate/mesh.hpp>
#include <palpate/settings.hpp>

#include "mesh/clusters.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// Throws Error if a given length is not > 0 and at most 1e150.
void check_cell_size(const CellSize& wanted);

/// Chooses the edge length of a cell (paper 5, "Cell size"): a given length, the mean or maximal edge length
/// at rest, or (automatic) the one with the least work at `positions` (n_points x 3).
///
/// Automatic tries lengths from half the smallest to twice the largest mean edge length of a body, each twice
/// the last, then the two beside the best. For each length it builds the grid of the points. Then it counts
/// the rows of cells to look up and the points found there, for a sample of at most 20000 tets (or clusters,
/// if the query uses them). The choice depends on counts and not on times, so it is the same on every
/// machine. The paper's rules suit bodies with elements of similar size. Where sizes differ a hundredfold,
/// the mean makes large tets cover a million cells, and the maximum puts whole bodies into one cell. `wanted`
/// must have passed check_cell_size(). `included` marks points (n_points); `clusters` are the clusters of the
/// query, null where it works on single tets. O(n_points) for each length tried.
CellSizeChoice choose_cell_size(const parallel::Threads& threads, const Bodies& bodies,
                                std::span<const Vec3> positions, std::span<const std::uint8_t> included,
                                const CellSize& wanted, const Clusters* clusters = nullptr);

}  // namespace palpate
