#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/nearest_surface.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// What a contact knows of the sides near it: whether there was none within reach, and none will be while
/// nothing moves much. A note only saves work; it never changes a result.
struct SideNote {
  Index tet = -1;                   ///< that held the point; -1: it knows nothing
  std::uint32_t stay_of_point = 0;  ///< of the point's body, see SideShares
  std::uint32_t stay_of_tet = 0;
  bool clear = false;  ///< of sides; else they are near or it cannot tell, and need not try again
  Vec3 direction;      ///< of the contact
};

/// Share of its stiffness that a contact has so near to a side of the body (ContactResponse says why).
///
/// Most contacts have no side within reach, and a walk through the body to see that is most of the work of
/// forces. So a contact whose bodies stay where they are notes that a walk a little further found no surface
/// that could become a side; while no point of both bodies has moved by more than a part of that margin, it
/// need not look again. A body stays from one record of its positions to the next, which is made when a
/// point has moved by `most_moved` of the reach; contacts walk further only in bodies that have stayed for
/// some steps, so that moving ones cost nothing more.
class SideShares {
 public:
  explicit SideShares(const Bodies& bodies);

  /// Once before the shares at new positions: looks which bodies have moved. O(points), and nothing where
  /// contacts are few.
  void begin(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
             std::size_t contacts);

  /// 0 to 1. With a note, which it uses or makes anew; of any thread.
  [[nodiscard]] double share(const Bodies& bodies, std::span<const Vec3> positions, const Contacts& contacts,
                             std::size_t c, ExitSearch& search, SideNote& note) const;
  /// The same by a walk.
  [[nodiscard]] double share(const Bodies& bodies, std::span<const Vec3> positions, const Contacts& contacts,
                             std::size_t c, ExitSearch& search) const;

 private:
  /// Distances from a side between which the share grows from zero to one, m.
  struct Rim {
    double inner = 0.0;
    double outer = 0.0;
  };
  /// Since the last record of a body's positions.
  struct Stay {
    std::uint32_t number = 0;
    int steps = 0;
  };
  void look_at(const parallel::Threads& threads, Range points, std::span<const Vec3> positions, double most,
               Stay& stay);

  std::vector<Rim> rims_;         ///< (n_bodies)
  std::vector<Stay> stays_;       ///< (n_bodies)
  std::vector<double> moved_;     ///< (n_bodies) by which a point may move within a stay, m
  std::vector<Vec3> recorded_;    ///< (n_points) positions
  std::vector<double> farthest_;  ///< scratch
  bool looks_ = false;            ///< the last begin() did
};

}  // namespace palpate
