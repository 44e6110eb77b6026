#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include <palpate/detection.hpp>

#include "geometry/vector.hpp"

namespace palpate {

/// How well the contacts of two bodies resist tilting, although those at rims have little force.
///
/// In a fine mesh, contacts away from rims extend nearly as far as all contacts. In two flush boxes of two
/// cells, only the middle contact is no rim, and eight are at rims. The measure compares two variances of
/// contact positions: of all contacts of the pair, and weighted by their scales at rims (RimFalloff). It is
/// the least ratio of the second to the first over all directions.
class PairSupport {
 public:
  /// \param scales  (n_contacts) 0 to 1
  ///
  /// O(contacts log pairs). Contacts of a body with itself do not count.
  void measure(const Bodies& bodies, std::span<const Vec3> positions, const Contacts& contacts,
               std::span<const double> scales);
  /// 0: points support the pair; 1: no point does, or all that do are on one line. O(log pairs).
  [[nodiscard]] double lack(Index body_a, Index body_b) const;

 private:
  using Pair = std::pair<Index, Index>;  ///< the lower body first
  /// Sums of weights, places and products of two coordinates (xx, yy, zz, xy, xz, yz).
  struct Moments {
    double weight = 0.0;
    Vec3 first;
    std::array<double, 6> second{};
    void add(double weight, const Vec3& x);
    [[nodiscard]] std::array<double, 6> variance() const;
  };
  struct Support {
    Pair pair;
    Vec3 origin;  ///< near the contacts, so that no digits are lost
    Moments all;
    Moments held;
    double lack = 0.0;
  };
  [[nodiscard]] static double lack_of(const Support& support);

  std::vector<Support> pairs_;  ///< sorted
};

}  // namespace palpate
