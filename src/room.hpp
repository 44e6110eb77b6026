#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

/// Memory of lists whose length differs from step to step. A list that grows to just what it needs asks for
/// memory again and again while its length wavers; these ask for an eighth more, so that a steady run asks in
/// its first steps only.
namespace palpate {

/// Makes room for `size` items where there is not enough. Items stay. O(1), or O(items) where it grows.
template <class T, class Allocator>
void make_room(std::vector<T, Allocator>& list, std::size_t size) {
  constexpr std::size_t a_few = 16;
  if (list.capacity() < size) list.reserve(size + size / 8 + a_few);
}

/// list.resize(size) for a list that is about to be overwritten: where it grows, its items are lost.
template <class T, class Allocator>
void resize_with_room(std::vector<T, Allocator>& list, std::size_t size) {
  if (list.capacity() < size) list.clear();
  make_room(list, size);
  list.resize(size);
}

/// list.assign(size, value).
template <class T, class Allocator>
void assign_with_room(std::vector<T, Allocator>& list, std::size_t size, const T& value) {
  resize_with_room(list, size);
  std::fill(list.begin(), list.end(), value);
}

/// For a list that grows by itself, item by item: where its capacity is no longer `before`, or is none, makes
/// room for `spare` items beyond those that it has.
template <class T, class Allocator>
void keep_room(std::vector<T, Allocator>& list, std::size_t before, std::size_t spare) {
  if (list.capacity() != before || before == 0) list.reserve(list.size() + spare);
}

}  // namespace palpate
