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

/// Bodies of tets whose contacts are found frame after frame, for programs that move the bodies themselves.
class World {
 public:
  World(const DetectionSettings& settings, int threads) : settings_(settings), threads_(threads) {}

  Index add(std::string name, TetMesh mesh, bool movable, bool self_collision);
  void set_ignored_pairs(std::vector<std::array<Index, 2>> pairs);
  void update(std::span<const Vec3> positions);

  /// The bodies as they are now; a later add() leaves them as they are.
  [[nodiscard]] std::shared_ptr<const Bodies> bodies() const { return bodies_; }
  /// The contacts of the last update(). They stay as they are when the world goes on. Taken from the detector
  /// without a copy.
  std::shared_ptr<const Contacts> contacts();
  /// Where border edges of the last update() leave the bodies.
  std::shared_ptr<const Crossings> crossings();
  /// Surface edges that passed through a body with both ends outside in the last update(). A copy.
  [[nodiscard]] EdgeContacts edge_contacts() const;
  /// What the last update() did: numbers of contacts, border edges, crossings, candidates, movers and more.
  [[nodiscard]] DetectionCounts stats() const;
  /// Seconds that the phases of the last update() took.
  [[nodiscard]] DetectionTimes times() const;
  /// (n_bodies) 1 where a budget did not suffice for all of a body in the last update(); empty without a
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
  std::vector<std::uint8_t> turned_;  ///< (n_tets) 1: two corners are swapped
  int threads_;
  std::unique_ptr<Detector> detector_;  ///< none: bodies or pairs changed since the last update
  bool has_results_ = false;
  std::shared_ptr<Contacts> contacts_;
  std::shared_ptr<Crossings> crossings_;
  Busy busy_;
};

/// For each tet of a body whether its corners are in another order than in the mesh that was given.
std::vector<std::uint8_t> turned_tets(std::span<const Tet> given, const Bodies& bodies, Index body);

/// Weights for the corners in the order in which they were given. O(contacts).
void order_weights_as_given(Contacts& contacts, std::span<const std::uint8_t> turned);

/// Contacts in other numbers of points, tets and bodies (each list: new number by old), in canonical order
/// again. Throws Error on a list that is too short. O(n log n).
Contacts renumbered(const Contacts& contacts, std::span<const Index> points, std::span<const Index> tets,
                    std::span<const Index> bodies);

}  // namespace palpate::python
