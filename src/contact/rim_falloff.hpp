#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/contact_columns.hpp"
#include "contact/nearest_surface.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// Width of the rim over the mean edge length of the body at rest.
inline constexpr double reach_of_an_edge = 0.25;
/// Width of the rim, m: the distance from a side at which the falloff ends. O(edges).
[[nodiscard]] double rim_reach(const Bodies& bodies, Index body);

/// Scale of a contact's stiffness near a rim, where the surface of the body turns away (ContactResponse says
/// why it is needed). It is zero near the rim and one from some distance on.
///
/// Most contacts have no rim within reach. The walk through the body that shows this is most of the work of
/// contact forces. So for bodies at rest the result is cached: a slightly longer walk found no surface that
/// could become a side (RimCache). While no point of both bodies has moved by more than a fraction of that
/// margin, no walk is needed.
///
/// A rest period of a body lasts from one record of its positions to the next. A new record is made when a
/// point has moved by `most_moved` of the reach. Longer walks are made only in bodies that have rested for
/// some steps, so moving bodies have no extra cost.
class RimFalloff {
 public:
  explicit RimFalloff(const Bodies& bodies);

  /// Distance from a side at which the scale reaches one, m.
  [[nodiscard]] double reach(Index body) const { return rims_[static_cast<std::size_t>(body)].outer; }

  /// Distance from a side up to which the scale is zero, m: 0.075 of the mean height of the body's tets, or
  /// half of the reach where that is less.
  [[nodiscard]] double inner(Index body) const { return rims_[static_cast<std::size_t>(body)].inner; }

  /// Call once for new positions, before the scales: finds which bodies have moved. O(points); does nothing
  /// if contacts are few.
  void begin(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
             std::size_t contacts);

  /// The scale, 0 to 1. Uses row c of the cache if it is valid, otherwise fills it. May be called from any
  /// thread.
  [[nodiscard]] double scale(const Bodies& bodies, std::span<const Vec3> positions, const Contacts& contacts,
                             std::size_t c, ExitSearch& search, RimCache& cache) const;
  /// The scale at `x`, a position in `tet` that leaves the tet's body along `direction`, without the cache.
  [[nodiscard]] double scale(const Bodies& bodies, std::span<const Vec3> positions, const Vec3& x, Index tet,
                             const Vec3& direction, ExitSearch& search) const;
  /// The same with sides that fade in (ExitSearch::distance_to_side): never below scale() if `width`,
  /// the distance from a side at which it reaches one, is the reach. A narrower one has a narrower zone of
  /// zero, too.
  [[nodiscard]] double fading_scale(const Bodies& bodies, std::span<const Vec3> positions, const Vec3& x,
                                    Index tet, const Vec3& direction, double width, ExitSearch& search) const;

 private:
  /// Distances from a side between which the scale grows from zero to one, m.
  struct Rim {
    double inner = 0.0;
    double outer = 0.0;
  };
  /// The rest period of a body: the time since the last record of its positions.
  struct Rest {
    std::uint32_t number = 0;
    int steps = 0;
  };
  void compare(const parallel::Threads& threads, Range points, std::span<const Vec3> positions, double most,
               Rest& rest);

  std::vector<Rim> rims_;         ///< (n_bodies)
  std::vector<Rest> rests_;       ///< (n_bodies)
  std::vector<double> moved_;     ///< (n_bodies) allowed motion of a body's points at rest, m
  std::vector<Vec3> recorded_;    ///< (n_points) positions
  std::vector<double> farthest_;  ///< scratch
  bool compares_ = false;         ///< whether the last begin() compared positions
};

}  // namespace palpate
