#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/pair_filter.hpp"
#include "grid/cell_slots.hpp"
#include "grid/fixed_positions.hpp"
#include "grid/lattice.hpp"
#include "mesh/clusters.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// Whether queries work on clusters of tets and triangles. In approximate mode they do not, since slots
/// belong to single tets.
inline bool works_on_clusters(const DetectionSettings& settings) {
  return settings.structure == Structure::compact && !settings.cells_per_primitive;
}

/// The input of all queries of a detection: the positions, the lattice of cells around them, their fixed
/// positions, and which bodies may touch. Queries only read it.
class Frame {
 public:
  /// Throws Error if a setting is out of range.
  /// \param bodies     must outlive the frame
  /// \param immovable  per body; empty: none is
  Frame(const Bodies& bodies, const DetectionSettings& settings, std::vector<std::uint8_t> immovable,
        int threads);

  /// Begins a detection. Makes a new lattice where the last one does not fit. Throws Error if a position is
  /// not finite. O(points), parallel; the first call also chooses the cell size.
  /// \param positions  (n_points x 3), valid until the next call
  /// \param clusters   of the tets, if the query of points works on clusters; or null
  void place(std::span<const Vec3> positions, const Clusters* clusters);
  /// Ends a detection: the next one gets other random numbers (approximate mode).
  void end() { ++detections_; }

  [[nodiscard]] const Bodies& bodies() const { return *bodies_; }
  [[nodiscard]] std::span<const Vec3> positions() const { return positions_; }
  [[nodiscard]] const parallel::Threads& threads() const { return threads_; }
  /// The threads for short loops over all points: the calling thread alone if waking another takes longer
  /// than the loops.
  [[nodiscard]] const parallel::Threads& grid_threads() const {
    constexpr std::size_t points_worth_sharing = 100000;
    return in_a_tet_.size() < points_worth_sharing ? one_thread_ : threads_;
  }
  [[nodiscard]] const Lattice& lattice() const { return lattice_; }
  /// Whether cells are others than in the last detection.
  [[nodiscard]] bool has_new_lattice() const { return has_new_lattice_; }
  /// The fixed positions. Null: they are not wanted, or the lattice has cells too small for them.
  [[nodiscard]] const FixedPositions* fixed() const {
    return fixed_ && FixedPositions::represents(lattice_) ? &*fixed_ : nullptr;
  }
  /// The cell of a point; none for points in no tet.
  [[nodiscard]] std::optional<Cell> cell_of(Index point) const {
    if (at(in_a_tet_, point) == 0) return std::nullopt;
    return lattice_.cell_of(at(positions_, point));
  }
  [[nodiscard]] CellSlots slots() const { return CellSlots(slots_, detections_); }
  [[nodiscard]] PairFilter may_touch() const {
    return {immovable_, self_collision_, ignored_pairs_, tied_points_, tied_bodies_};
  }
  /// \param points  with the bodies to which they are tied, ascending (PairFilter)
  void set_tied_points(std::vector<std::array<Index, 2>> points);
  /// How the cell size was chosen, in the first detection.
  [[nodiscard]] const CellSizeChoice& cell_size() const { return cell_size_; }
  /// Number of detections so far.
  [[nodiscard]] std::uint64_t detections() const { return detections_; }
  [[nodiscard]] std::size_t bytes() const { return fixed_ ? fixed_->bytes() : 0; }

  /// Stores the lattice and the number of detections, for swap_back().
  void hold();
  void swap_back();
  /// Whether swap_back() has changed the lattice since the last detection.
  [[nodiscard]] bool is_swapped() const { return is_swapped_; }
  /// Restores a saved lattice and number of detections.
  void recall(double cell_size, std::vector<CellSizeTrial> trials, const Box& domain,
              std::uint64_t detections);

 private:
  const Bodies* bodies_;
  parallel::Threads threads_;
  parallel::Threads one_thread_{1};
  std::vector<std::uint8_t> immovable_;       ///< (n_bodies)
  std::vector<std::uint8_t> self_collision_;  ///< (n_bodies)
  std::vector<std::array<Index, 2>> ignored_pairs_;
  std::vector<std::array<Index, 2>> tied_points_;
  std::vector<std::array<Index, 2>> tied_bodies_;
  int slots_;                           ///< cells per primitive; 0: all
  std::vector<std::uint8_t> in_a_tet_;  ///< (n_points)
  std::span<const Vec3> positions_;
  CellSizeChoice cell_size_;
  Lattice lattice_;
  Lattice held_lattice_;
  bool has_new_lattice_ = true;
  bool is_swapped_ = false;
  std::uint64_t detections_ = 0;
  std::uint64_t held_detections_ = 0;
  std::optional<FixedPositions> fixed_;  ///< for queries of clusters
  std::vector<Box> box_scratch_;
};

/// Counts the points whose cell changed since the last detection.
class MoverCount {
 public:
  /// All points after a new lattice. O(points), parallel.
  std::size_t count(const Frame& frame);

 private:
  std::vector<std::uint64_t> cell_of_point_;  ///< (n_points)
  std::vector<double> scratch_;
};

}  // namespace palpate
