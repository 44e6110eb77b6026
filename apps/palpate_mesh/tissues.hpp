#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "domain_mesher.hpp"
#include "label_map.hpp"
#include "lattice.hpp"
#include "organ.hpp"

namespace palpate::app {

/// The tissues of a label map as smooth shapes without gaps between them. At each position the tissue with
/// the largest value wins: its blurred mask plus an offset that keeps its volume. In the axes of the map, mm.
class Tissues {
 public:
  /// Reads the labels in `extents`, in that order: tissue t + 1 is extents[t], 0 is all the rest. O(voxels x
  /// tissues).
  Tissues(const LabelMap& map, const std::vector<LabelExtent>& extents, double smoothing);

  /// Moves the surface of a tissue back by half of `gap` (mm) where it meets certain other tissues.
  /// \param distance_to_others  distance to these tissues at the points of a lattice, mm; > 0 outside them
  void draw_back(int tissue, Lattice distance_to_others, double gap);

  /// The tissue at a position, 0 for none. O(tissues) near interfaces, otherwise O(1).
  [[nodiscard]] int at(const Vec3& p) const;

  /// The tissue of each voxel in the map, 0 for none; i fastest.
  [[nodiscard]] const std::vector<std::uint16_t>& voxels() const { return voxels_; }
  /// The tissue of one voxel; 0 outside of the map.
  [[nodiscard]] int voxel(int i, int j, int k) const;
  /// The index of a voxel in the map.
  [[nodiscard]] std::size_t voxel_index(int i, int j, int k) const;
  [[nodiscard]] const std::array<int, 3>& size() const { return size_; }
  [[nodiscard]] const Vec3& spacing() const { return spacing_; }
  [[nodiscard]] int count() const { return static_cast<int>(fields_.size()); }
  /// Box around all tissues.
  [[nodiscard]] Vec3 lower() const;
  [[nodiscard]] Vec3 upper() const;

  /// Seeds where two tissues meet, no closer to each other than `apart`, but some for each component of a
  /// tissue. O(voxels).
  [[nodiscard]] std::vector<InterfaceSeed> seeds(double apart) const;

 private:
  void find_winners();
  void keep_volumes(const std::vector<LabelExtent>& extents, double width);
  [[nodiscard]] std::vector<double> volumes() const;
  [[nodiscard]] std::vector<double> surface_areas() const;
  [[nodiscard]] int evaluated(const Vec3& p) const;
  [[nodiscard]] bool is_drawn_back(int tissue, const Vec3& p) const;
  [[nodiscard]] std::size_t cell_index(int i, int j, int k) const;
  [[nodiscard]] std::optional<InterfaceSeed> crossing(Vec3 low, Vec3 high) const;

  std::array<int, 3> size_{};  ///< of the map
  Vec3 spacing_{};
  std::vector<std::uint16_t> voxels_;
  std::vector<Lattice> fields_;  ///< blurred masks, of the box of each tissue
  std::vector<double> offsets_;  ///< (n_tissues)
  std::vector<Lattice> free_;    ///< (n_tissues), > 0 where the tissue is allowed; empty without a gap
  /// Number of cells per axis. Their corners are voxel centres, also in a margin round the map.
  std::array<int, 3> cells_{};
  std::vector<std::int16_t> cell_;  ///< (n_cells) the tissue of a cell that has only one; -1: several
};

}  // namespace palpate::app
