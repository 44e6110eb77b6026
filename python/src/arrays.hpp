#pragma once

#include <cstddef>
#include <cstdint>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include <palpate/mesh.hpp>
#include <palpate/types.hpp>

/// NumPy arrays as spans and back. Arguments already have type and layout from palpate/_arrays.py, so these
/// functions never copy. Results are views that keep their owner alive, or own their memory.
namespace palpate::python {

namespace nb = nanobind;

template <class T, std::int64_t... shape>
using ArrayIn = nb::ndarray<const T, nb::shape<shape...>, nb::c_contig, nb::device::cpu>;
template <class T, std::int64_t... shape>
using ArrayOut = nb::ndarray<nb::numpy, const T, nb::shape<shape...>, nb::c_contig>;

using PointsIn = ArrayIn<double, -1, 3>;
using PointsOut = ArrayOut<double, -1, 3>;
using TetsIn = ArrayIn<Index, -1, 4>;

static_assert(sizeof(Vec3) == 3 * sizeof(double) && sizeof(Tet) == 4 * sizeof(Index));

inline std::span<const Vec3> points_of(const PointsIn& array) {
  return {reinterpret_cast<const Vec3*>(array.data()), array.shape(0)};
}
inline std::span<const Tet> tets_of(const TetsIn& array) {
  return {reinterpret_cast<const Tet*>(array.data()), array.shape(0)};
}
template <class T>
std::span<const T> values_of(const ArrayIn<T, -1>& array) {
  return {array.data(), array.shape(0)};
}
template <class T>
std::vector<T> vector_of(std::span<const T> values) {
  return {values.begin(), values.end()};
}
inline TetMesh mesh_of(const PointsIn& points, const TetsIn& tets) {
  return {vector_of(points_of(points)), vector_of(tets_of(tets))};
}

/// An (n) or (n x columns) array over memory of `owner`, which lives as long as the array.
template <class T, class Item>
nb::ndarray<nb::numpy, const T, nb::c_contig> view(std::span<const Item> items, nb::handle owner) {
  constexpr std::size_t columns =
      std::is_same_v<Item, T>
          ? 1
          : sizeof(Item) / sizeof(T);  // NOLINT(bugprone-sizeof-expression): of a plain array of T
  const std::size_t shape[2] = {items.size(), columns};
  return {reinterpret_cast<const T*>(items.data()), columns == 1 ? 1U : 2U, shape, owner};
}
template <class T, class Item>
auto view(const std::vector<Item>& items, nb::handle owner) {
  return view<T>(std::span<const Item>(items), owner);
}

/// An array that owns the memory of `items`.
template <class T, class Item>
nb::ndarray<nb::numpy, const T, nb::c_contig> moved(std::vector<Item> items) {
  auto* kept = new std::vector<Item>(std::move(items));
  const nb::capsule owner(kept,
                          [](void* memory) noexcept { delete static_cast<std::vector<Item>*>(memory); });
  return view<T>(*kept, owner);
}
template <class T, class Item>
auto copied(std::span<const Item> items) {
  return moved<T>(vector_of(items));
}

}  // namespace palpate::python
