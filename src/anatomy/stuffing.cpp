#include "anatomy/stuffing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include <palpate/error.hpp>

#include "anatomy/largest_part.hpp"
#include "geometry/vector.hpp"
#include "number_text.hpp"

namespace palpate::anatomy {
namespace {

/// Fractions of an edge within which a lattice point is moved to a cut (their table 2, the thresholds for the
/// best smallest angle).
constexpr double warp_long = 0.24999;
constexpr double warp_short = 0.41189;
constexpr int bisections = 40;

/// Steps from a lattice point to its 14 neighbours, in half cells; the first six are the long edges.
constexpr std::array<std::array<int, 3>, 14> steps{{{2, 0, 0},
                                                    {-2, 0, 0},
                                                    {0, 2, 0},
                                                    {0, -2, 0},
                                                    {0, 0, 2},
                                                    {0, 0, -2},
                                                    {1, 1, 1},
                                                    {1, 1, -1},
                                                    {1, -1, 1},
                                                    {1, -1, -1},
                                                    {-1, 1, 1},
                                                    {-1, 1, -1},
                                                    {-1, -1, 1},
                                                    {-1, -1, -1}}};
constexpr std::size_t long_steps = 6;

/// The body-centred cubic lattice over a box: points with coordinates that are all even (corners of cells) or
/// all odd (centres), in half cells.
class Lattice {
 public:
  explicit Lattice(const StuffingOptions& options) : half_(0.5 * options.cell), origin_(options.lower) {
    const Vec3 extent = options.upper - options.lower;
    const std::array<double, 3> extents{extent.x, extent.y, extent.z};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      // One cell more on each side, so that the surface never meets the lattice's end.
      size_[axis] = 2 * (static_cast<int>(std::ceil(extents[axis] / options.cell)) + 2) + 1;
    }
    origin_ -= Vec3{options.cell, options.cell, options.cell};
  }

  [[nodiscard]] std::size_t count() const {
    return static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1]) *
           static_cast<std::size_t>(size_[2]);
  }
  [[nodiscard]] const std::array<int, 3>& size() const { return size_; }
  [[nodiscard]] bool contains(const std::array<int, 3>& p) const {
    return std::ranges::all_of(std::array{0, 1, 2},
                               [&](int axis) { return at(p, axis) >= 0 && at(p, axis) < at(size_, axis); });
  }
  [[nodiscard]] std::size_t index(const std::array<int, 3>& p) const {
    return (static_cast<std::size_t>(p[2]) * static_cast<std::size_t>(size_[1]) +
            static_cast<std::size_t>(p[1])) *
               static_cast<std::size_t>(size_[0]) +
           static_cast<std::size_t>(p[0]);
  }
  [[nodiscard]] Vec3 position(const std::array<int, 3>& p) const {
    return origin_ + Vec3{half_ * p[0], half_ * p[1], half_ * p[2]};
  }
  /// Values f(p) at the points of the lattice, in the order of their indices.
  template <class F>
  void for_each_point(F&& f) const {
    for (int k = 0; k < size_[2]; ++k) {
      for (int j = k % 2; j < size_[1]; j += 2) {
        for (int i = k % 2; i < size_[0]; i += 2) f(std::array{i, j, k});
      }
    }
  }

 private:
  double half_;
  Vec3 origin_;
  std::array<int, 3> size_{};
};

std::array<int, 3> moved(std::array<int, 3> p, const std::array<int, 3>& step) {
  for (std::size_t axis = 0; axis < 3; ++axis) p[axis] += step[axis];
  return p;
}

bool is_long(const std::array<int, 3>& a, const std::array<int, 3>& b) {
  return (a[0] - b[0]) % 2 == 0;
}

/// The state of a lattice point: inside, on the surface, or outside.
enum class Side : std::int8_t { inside = -1, on = 0, outside = 1 };

class Stuffing {
 public:
  Stuffing(const Distance& shape, const StuffingOptions& options)
      : shape_(shape),
        lattice_(options),
        sides_(lattice_.count(), Side::outside),
        positions_(lattice_.count()) {
    lattice_.for_each_point([&](const Place& p) {
      const std::size_t i = lattice_.index(p);
      positions_[i] = lattice_.position(p);
      const double value = shape_(positions_[i]);
      sides_[i] = value < 0.0 ? Side::inside : value > 0.0 ? Side::outside : Side::on;
    });
    lattice_.for_each_point([&](const Place& p) { warp(p); });
    lattice_.for_each_point([&](const Place& p) { add_tets(p); });
  }

  TetMesh take() { return std::move(mesh_); }

 private:
  using Place = std::array<int, 3>;  ///< of a lattice point, half cells

  [[nodiscard]] Side side(const Place& p) const { return sides_[lattice_.index(p)]; }
  [[nodiscard]] static bool differ(Side a, Side b) { return static_cast<int>(a) * static_cast<int>(b) < 0; }

  /// Fraction of the segment from a to b at which it meets the surface; a and b are on either side of it.
  [[nodiscard]] double cut_fraction(const Place& a, const Place& b) const {
    const Vec3& from = positions_[lattice_.index(a)];
    const Vec3 segment = positions_[lattice_.index(b)] - from;
    const bool starts_inside = side(a) == Side::inside;
    double low = 0.0;
    double high = 1.0;
    for (int i = 0; i < bisections; ++i) {
      const double middle = 0.5 * (low + high);
      ((shape_(from + middle * segment) < 0.0) == starts_inside ? low : high) = middle;
    }
    return 0.5 * (low + high);
  }

  /// Moves a lattice point to the nearest cut of its edges, if one is near enough. The point is then on the
  /// surface, so its edges have no cuts.
  void warp(const Place& p) {
    const std::size_t i = lattice_.index(p);
    if (sides_[i] == Side::on) return;
    double nearest = 1.0;  // in cells
    Vec3 target{};
    for (std::size_t s = 0; s < steps.size(); ++s) {
      const Place q = moved(p, steps[s]);
      if (!lattice_.contains(q) || !differ(sides_[i], side(q))) continue;
      const double fraction = cut_fraction(p, q);
      const bool is_long_edge = s < long_steps;
      if (fraction > (is_long_edge ? warp_long : warp_short)) continue;
      const Vec3 segment = positions_[lattice_.index(q)] - positions_[i];
      const double distance = fraction * (is_long_edge ? 1.0 : 0.5 * std::sqrt(3.0));
      if (distance >= nearest) continue;
      nearest = distance;
      target = positions_[i] + fraction * segment;
    }
    if (nearest == 1.0) return;
    // Moved points have no cuts, so neighbours measure their cuts on edges of the original lattice.
    positions_[i] = target;
    sides_[i] = Side::on;
  }

  /// Adds the tets around the long edges from p to p + 2 e, for each axis e. Their other long edge is on the
  /// face between the two cells.
  void add_tets(const Place& p) {
    if (p[0] % 2 == 0) return;  // so that each tet is added once, by its edge between two centres
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Place next = p;
      next[axis] += 2;
      if (!lattice_.contains(next)) continue;
      const std::size_t u = (axis + 1) % 3;
      const std::size_t v = (axis + 2) % 3;
      constexpr std::array<std::array<int, 2>, 5> around{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}, {-1, -1}}};
      for (std::size_t k = 0; k < 4; ++k) {
        const auto corner = [&](std::size_t c) {
          Place q = p;
          q[axis] += 1;
          q[u] += around[c][0];
          q[v] += around[c][1];
          return q;
        };
        const Place a = corner(k);
        const Place b = corner(k + 1);
        if (lattice_.contains(a) && lattice_.contains(b)) add_tet({p, next, a, b});
      }
    }
  }

  void add_tet(const std::array<Place, 4>& corners) {
    std::vector<Place> inside;
    std::vector<Place> on;
    std::vector<Place> outside;
    for (const Place& corner : corners) {
      const Side s = side(corner);
      (s == Side::inside ? inside : s == Side::on ? on : outside).push_back(corner);
    }
    if (inside.empty()) return;
    if (outside.empty()) {
      emit({point(corners[0]), point(corners[1]), point(corners[2]), point(corners[3])});
    } else if (inside.size() == 1) {
      add_corner(inside[0], on, outside);
    } else if (inside.size() == 2 && outside.size() == 1) {
      add_pyramid(point(on[0]), inside[0], inside[1], outside[0]);
    } else if (inside.size() == 2) {
      add_wedge(inside[0], inside[1], outside[0], outside[1]);
    } else {
      add_prism({inside[0], inside[1], inside[2]}, outside[0]);
    }
  }

  void add_corner(const Place& a, const std::vector<Place>& on, const std::vector<Place>& outside) {
    std::vector<Index> tet{point(a)};
    tet.reserve(4);
    for (const Place& p : on) tet.push_back(point(p));
    for (const Place& p : outside) tet.push_back(cut(a, p));
    emit({tet[0], tet[1], tet[2], tet[3]});
  }

  /// Of a face with a and b inside and m outside, the quadrilateral a b cut(b m) cut(a m) is common to two
  /// tets, which must cut it along the same diagonal: the one that ends at a (true) or at b. The other end is
  /// a cut on a long edge where there is one; else the parity of the path from the outer point decides (their
  /// section 3.3).
  [[nodiscard]] static bool diagonal_at_first(const Place& a, const Place& b, const Place& m) {
    if (is_long(a, m)) return false;
    if (is_long(b, m)) return true;
    int larger = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) larger += a[axis] > m[axis] ? 1 : 0;
    return larger % 2 == 0;
  }

  /// Adds the pyramid over that quadrilateral.
  void add_pyramid(Index apex, const Place& a, const Place& b, const Place& m) {
    const bool at_first = diagonal_at_first(a, b, m);
    const Index near = at_first ? point(a) : point(b);
    const Index other = at_first ? point(b) : point(a);
    const Index near_cut = at_first ? cut(a, m) : cut(b, m);
    const Index other_cut = at_first ? cut(b, m) : cut(a, m);
    emit({apex, near, other, other_cut});
    emit({apex, near, other_cut, near_cut});
  }

  /// Adds the tets for a and b inside, m and n outside. The diagonals of the two shared faces never end at
  /// the same point.
  void add_wedge(const Place& a, const Place& b, const Place& m, const Place& n) {
    const bool swapped = diagonal_at_first(a, b, m);
    const Place& to_b = swapped ? n : m;  // the face whose diagonal ends at b
    const Place& to_a = swapped ? m : n;
    emit({point(a), cut(a, to_b), cut(a, to_a), cut(b, to_a)});
    emit({point(a), cut(a, to_b), cut(b, to_a), point(b)});
    emit({point(b), cut(a, to_b), cut(b, to_b), cut(b, to_a)});
  }

  /// Adds the tets for three points inside and m outside. One of the three is on both diagonals of its faces.
  void add_prism(std::array<Place, 3> inside, const Place& m) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Place& a = inside[i];
      const Place& b = inside[(i + 1) % 3];
      const Place& c = inside[(i + 2) % 3];
      if (!diagonal_at_first(a, b, m) || !diagonal_at_first(a, c, m)) continue;
      emit({point(a), cut(a, m), cut(b, m), cut(c, m)});
      add_pyramid(point(a), b, c, m);
      return;
    }
  }

  Index point(const Place& p) {
    const std::size_t key = lattice_.index(p);
    const auto [entry, is_new] = points_.try_emplace(key, static_cast<Index>(mesh_.points.size()));
    if (is_new) mesh_.points.push_back(positions_[key]);
    return entry->second;
  }
  Index cut(const Place& a, const Place& b) {
    const std::size_t key = lattice_.index(a) * lattice_.count() + lattice_.index(b);
    const auto [entry, is_new] = cuts_.try_emplace(key, static_cast<Index>(mesh_.points.size()));
    if (is_new) {
      const Vec3& from = positions_[lattice_.index(a)];
      mesh_.points.push_back(from + cut_fraction(a, b) * (positions_[lattice_.index(b)] - from));
    }
    return entry->second;
  }
  void emit(Tet tet) {
    const auto corner = [&](std::size_t i) { return at(mesh_.points, tet[i]); };
    if (dot(cross(corner(1) - corner(0), corner(2) - corner(0)), corner(3) - corner(0)) < 0.0)
      std::swap(tet[2], tet[3]);
    mesh_.tets.push_back(tet);
  }

  const Distance& shape_;
  Lattice lattice_;
  std::vector<Side> sides_;      ///< by index of the lattice
  std::vector<Vec3> positions_;  ///< by index of the lattice
  std::unordered_map<std::size_t, Index> points_;
  std::unordered_map<std::size_t, Index> cuts_;  ///< by inner and outer end
  TetMesh mesh_;
};

void check(const StuffingOptions& options) {
  const auto refuse = [](const char* what, const std::string& found, const char* expected) {
    throw Error("stuff", what, found, expected);
  };
  if (!(options.cell > 0.0) || !std::isfinite(options.cell))
    refuse("cell", number_text(options.cell), "a finite number > 0");
  const Vec3 extent = options.upper - options.lower;
  const bool ordered = extent.x > 0.0 && extent.y > 0.0 && extent.z > 0.0;
  if (!ordered || !is_finite(extent)) refuse("box", "an empty or infinite box", "lower < upper on each axis");
  constexpr double most_cells = 1024.0;
  if (std::max({extent.x, extent.y, extent.z}) > most_cells * options.cell)
    refuse("cell", number_text(options.cell), "at least a thousandth of the box");
}

}  // namespace

TetMesh stuff(const Distance& shape, const StuffingOptions& options) {
  check(options);
  TetMesh mesh = largest_part(without_pinched_edges(Stuffing(shape, options).take()));
  if (mesh.tets.empty())
    throw Error("stuff", "shape", "no part of the shape in the box", "a shape at least as thick as a cell");
  return mesh;
}

}  // namespace palpate::anatomy
