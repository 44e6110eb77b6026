#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/contact_columns.hpp"
#include "contact/nearest_surface.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// Distance from a side of a body from which on it is no rim, m: a quarter of the mean edge at rest.
/// O(edges).
[[nodiscard]] double rim_reach(const Bodies& bodies, Index body);

/// Scale of a contact's stiffness near a rim of the body, a place where its surface turns away
/// (ContactResponse says why): zero close to it, one from some distance on.
///
/// Most contacts have no rim within reach, and a walk through the body to see that is most of the work of
/// forces. So a contact whose bodies rest caches that a walk a little further found no surface that could
/// become a side (RimCache); while no point of both bodies has moved by more than a part of that margin, it
/// need not walk again. A body rests from one record of its positions to the next, which is made when a point
/// has moved by `most_moved` of the reach; contacts walk further only in bodies that have rested for some
/// steps, so that moving ones cost nothing more.
class RimFalloff {
 public:
  explicit RimFalloff(const Bodies& bodies);

  /// Distance from a side from which on the scale is one, m.
  [[nodiscard]] double reach(Index body) const { return rims_[static_cast<std::size_t>(body)].outer; }

  /// Once before the scales at new positions: finds which bodies have moved. O(points), and nothing where
  /// contacts are few.
  void begin(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
             std::size_t contacts);

  /// 0 to 1. Uses row c of the cache, or fills it; of any thread.
  [[nodiscard]] double scale(const Bodies& bodies, std::span<const Vec3> positions, const Contacts& contacts,
                             std::size_t c, ExitSearch& search, RimCache& cache) const;
  /// The same by a walk.
  [[nodiscard]] double scale(const Bodies& bodies, std::span<const Vec3> positions, const Contacts& contacts,
                             std::size_t c, ExitSearch& search) const;

 private:
  /// Distances from a side between which the scale grows from zero to one, m.
  struct Rim {
    double inner = 0.0;
    double outer = 0.0;
  };
  /// Since the last record of a body's positions.
  struct Rest {
    std::uint32_t number = 0;
    int steps = 0;
  };
  void compare(const parallel::Threads& threads, Range points, std::span<const Vec3> positions, double most,
               Rest& rest);

  std::vector<Rim> rims_;         ///< (n_bodies)
  std::vector<Rest> rests_;       ///< (n_bodies)
  std::vector<double> moved_;     ///< (n_bodies) by which a point of a body at rest may move, m
  std::vector<Vec3> recorded_;    ///< (n_points) positions
  std::vector<double> farthest_;  ///< scratch
  bool compares_ = false;         ///< the last begin() did
};

}  // namespace palpate
