#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include <palpate/types.hpp>

#include "room.hpp"

/// Groups of columns of the ContactTable (docs/contact-table.md): structures of arrays, which list their
/// arrays by columns().
namespace palpate {

/// Calls f(column of a, column of b) for each column of two groups of one kind.
template <class A, class B, class F>
void zip_columns(A& a, B& b, F&& f) {
  auto of_a = a.columns();
  auto of_b = b.columns();
  [&]<std::size_t... i>(std::index_sequence<i...>) {
    (f(std::get<i>(of_a), std::get<i>(of_b)), ...);
  }
  (std::make_index_sequence<std::tuple_size_v<decltype(of_a)>>{});
}

/// Sets the number of rows of all columns. If the number grows, all values are lost.
template <class Group>
void resize_columns(Group& group, std::size_t rows) {
  std::apply([&](auto&... column) { (resize_with_room(column, rows), ...); }, group.columns());
}

/// Adds rows. Existing values stay; values of new rows are undefined.
template <class T>
void grow_column(std::vector<T>& column, std::size_t rows) {
  make_room(column, rows);
  column.resize(rows);
}
template <class Group>
void grow_columns(Group& group, std::size_t rows) {
  std::apply([&](auto&... column) { (grow_column(column, rows), ...); }, group.columns());
}

/// Sets all values of a row to zero.
template <class Group>
void clear_row(Group& group, std::size_t row) {
  std::apply([&](auto&... column) { ((column[row] = {}), ...); }, group.columns());
}

template <class Group>
void copy_row(const Group& from, std::size_t row_from, Group& to, std::size_t row) {
  zip_columns(from, to, [&](const auto& a, auto& b) { b[row] = a[row_from]; });
}

/// The penetration plane of each contact when it was last computed; see PlaneCache.
struct CachedPlanes {
  std::vector<Index> tet;  ///< tet that contained the point then; -1: no plane
  std::vector<std::uint8_t>
      age;  ///< number of detections since then; `oldest` if the plane was propagated from neighbours
  std::vector<std::array<double, 4>> weights;  ///< of the point in that tet
  std::vector<double> depth;                   ///< m
  std::vector<Vec3> on_edges;  ///< dot products of the direction with the edges from the tet's first corner
  std::vector<double> certainty;

  static constexpr std::uint8_t oldest = 255;
  auto columns() { return std::tie(tet, age, weights, depth, on_edges, certainty); }
  auto columns() const { return std::tie(tet, age, weights, depth, on_edges, certainty); }
};

/// State of each contact from step to step, written by the response. A row of zeros means that the contact
/// has not acted yet.
struct ContactStates {
  std::vector<std::int32_t>
      seen;  ///< consecutive steps in which it acted, including this one; 0: it does not act
  std::vector<std::int32_t> lost;  ///< steps since it last acted; 0 while it acts
  std::vector<std::uint8_t>
      speculative;  ///< 1: found at predicted positions, and not yet in contact at the end of a step
  /// 0, or the number of steps in which it has acted softly, since it began deep.
  std::vector<std::uint8_t> soft;
  std::vector<Vec3> slip;  ///< extension of the friction spring, m; orthogonal to the direction
  // Values of the last step in which it acted:
  std::vector<Vec3> force;              ///< along the direction, at the start of the step, N
  std::vector<Vec3> direction;          ///< unit
  std::vector<Vec3> velocity;           ///< of the point relative to the tet, at the start of the step, m/s
  std::vector<double> stiffness;        ///< N/m
  std::vector<double> chatter_damping;  ///< N s/m

  auto columns() {
    return std::tie(seen, lost, speculative, soft, slip, force, direction, velocity, stiffness,
                    chatter_damping);
  }
  auto columns() const {
    return std::tie(seen, lost, speculative, soft, slip, force, direction, velocity, stiffness,
                    chatter_damping);
  }
};

/// Cached result of the search for rims near a contact (RimFalloff): there was none within reach, and there
/// will be none while points move little. It saves work and never changes a result, so it is not part of
/// saved states.
struct RimCache {
  enum State : std::uint8_t { unknown, near, clear };  ///< near: there is a rim, or there may be one

  std::vector<std::uint8_t> state;           ///< a State; if it is unknown, the other columns are invalid
  std::vector<Index> tet;                    ///< tet that contained the point
  std::vector<std::uint32_t> rest_of_point;  ///< number of the rest period of the point's body
  std::vector<std::uint32_t> rest_of_tet;
  std::vector<Vec3> direction;  ///< direction of the contact

  auto columns() { return std::tie(state, tet, rest_of_point, rest_of_tet, direction); }
  auto columns() const { return std::tie(state, tet, rest_of_point, rest_of_tet, direction); }
};

}  // namespace palpate
