#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <palpate/detection.hpp>
#include <palpate/mesh.hpp>

#include "crossings.hpp"
#include "one_thread.hpp"

namespace palpate::python {

/// Bodies of tets whose contacts are detected frame by frame, for programs that move the bodies themselves.
class World {
 public:
  World(const DetectionSettings& settings, int threads) : settings_(settings), threads_(threads) {}

  Index add(std::string name, TetMesh mesh, bool movable, bool self_collision);
  void set_ignored_pairs(std::vector<std::array<Index, 2>> pairs);
  void update(std::span<const Vec3> positions);

  /// The current bodies; a later add() does not change the result.
  [[nodiscard]] std::shared_ptr<const Bodies> bodies() const { return bodies_; }
  /// The contacts of the last update(). Later updates do not change the result. Moved from the detector
  /// without a copy.
  std::shared_ptr<const Contacts> contacts();
  /// Crossings of border edges in the last update().
  std::shared_ptr<const Crossings> crossings();
  /// Surface edges that pass through a body with both ends outside, in the last update(). A copy.
  [[nodiscard]] EdgeContacts edge_contacts() const;
  /// Counts of the last update(): contacts, border edges, crossings, candidates, movers and more.
  [[nodiscard]] DetectionCounts stats() const;
  /// Seconds of the phases of the last update().
  [[nodiscard]] DetectionTimes times() const;
  /// (n_bodies) 1 for bodies that the budget did not completely cover in the last update(); empty without a
  /// budget.
  [[nodiscard]] std::vector<std::uint8_t> late_bodies() const;
  /// Memory of the spatial structures, bytes.
  [[nodiscard]] std::size_t structure_bytes() const;

 private:
  [[nodiscard]] const Detector& updated() const;
  void clear_results();

  std::shared_ptr<Bodies> bodies_ = std::make_shared<Bodies>();
  DetectionSettings settings_;
  std::vector<std::uint8_t> immovable_;
  std::vector<std::uint8_t> reoriented_;  ///< (n_tets) 1: two corners are swapped
  int threads_;
  std::unique_ptr<Detector> detector_;  ///< null: bodies or pairs changed since the last update
  bool has_results_ = false;
  std::shared_ptr<Contacts> contacts_;
  std::shared_ptr<Crossings> crossings_;
  Busy busy_;
};

/// Throws Error unless a name is not empty, has no NUL character and is that of no other body.
void check_name(const Bodies& bodies, const std::string& name, const char* what);

/// For each tet of a body, whether the order of its corners differs from the given mesh.
std::vector<std::uint8_t> reoriented_tets(std::span<const Tet> given, const Bodies& bodies, Index body);

/// Reorders weights to the given order of corners. O(contacts).
void order_weights_as_given(Contacts& contacts, std::span<const std::uint8_t> reoriented);

/// Contacts with other indices of points, tets and bodies (each list: new index by old), in canonical order.
/// Throws Error on a list that is too short. O(n log n).
Contacts renumbered(const Contacts& contacts, std::span<const Index> points, std::span<const Index> tets,
                    std::span<const Index> bodies);

}  // namespace palpate::python
