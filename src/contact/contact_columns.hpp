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

/// Sets the number of rows of all columns. If rows are added, all values are lost.
template <class Group>
void resize_columns(Group& group, std::size_t rows) {
  std::apply([&](auto&... column) { (resize_with_room(column, rows), ...); }, group.columns());
}

/// Adds rows: values of new rows are undefined, existing values stay.
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

/// The penetration plane of a contact when it was last computed; see PlaneCache.
struct CachedPlanes {
  std::vector<Index> tet;                      ///< that contained the point; -1: no plane
  std::vector<std::uint8_t> age;               ///< detections since then; `oldest` if it came from neighbours
  std::vector<std::array<double, 4>> weights;  ///< of the point in the tet
  std::vector<double> depth;                   ///< m
  std::vector<Vec3> on_edges;  ///< products of the direction with the edges from the tet's first corner
  std::vector<double> certainty;

  static constexpr std::uint8_t oldest = 255;
  auto columns() { return std::tie(tet, age, weights, depth, on_edges, certainty); }
  auto columns() const { return std::tie(tet, age, weights, depth, on_edges, certainty); }
};

/// State of a contact from step to step, written by the response. A row of zeros: it has not acted yet.
struct ContactStates {
  std::vector<std::int32_t> seen;  ///< steps in a row, this one included; 0: it does not act
  std::vector<std::int32_t> lost;  ///< steps since it last acted; 0 while it does
  std::vector<std::uint8_t>
      speculative;         ///< 1: found within the last step, and not yet in contact at the end of a step
  std::vector<Vec3> slip;  ///< extension of the friction spring, m; orthogonal to the direction
  // When it last acted:
  std::vector<Vec3> force;              ///< along the direction, at the start of the step, N
  std::vector<Vec3> direction;          ///< unit
  std::vector<Vec3> velocity;           ///< of the point relative to the tet, at the start of the step, m/s
  std::vector<double> stiffness;        ///< N/m
  std::vector<double> chatter_damping;  ///< N s/m

  auto columns() {
    return std::tie(seen, lost, speculative, slip, force, direction, velocity, stiffness, chatter_damping);
  }
  auto columns() const {
    return std::tie(seen, lost, speculative, slip, force, direction, velocity, stiffness, chatter_damping);
  }
};

/// Cached result of the search for rims near a contact: that there was none within reach, and will be none
/// while points move little (RimFalloff). Saves work only and never changes a result, so it is not part of
/// saved states.
struct RimCache {
  enum State : std::uint8_t { unknown, near, clear };  ///< near: there is a rim, or possibly one

  std::vector<std::uint8_t> state;  ///< a State; the other columns are valid only if it is not unknown:
  std::vector<Index> tet;           ///< that contained the point
  std::vector<std::uint32_t> rest_of_point;  ///< number of the rest period of the point's body
  std::vector<std::uint32_t> rest_of_tet;
  std::vector<Vec3> direction;  ///< of the contact

  auto columns() { return std::tie(state, tet, rest_of_point, rest_of_tet, direction); }
  auto columns() const { return std::tie(state, tet, rest_of_point, rest_of_tet, direction); }
};

}  // namespace palpate
