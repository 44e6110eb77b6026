#pragma once

#include <cstddef>
#include <vector>

namespace palpate::simd {

/// Memory of so many bytes that begins with a cache line; what is large lies in pages as large as the system
/// has them, where it can be asked for that: fewer to look up. To be given back by free_lines() with the same
/// number. Throws std::bad_alloc.
void* allocate_lines(std::size_t bytes);
void free_lines(void* memory, std::size_t bytes);

/// Memory that begins with a cache line, so that no vector of lanes lies across two.
template <class T>
struct LineAllocator {
  using value_type = T;
  LineAllocator() = default;
  template <class U>
  LineAllocator(const LineAllocator<U>& /*other*/) {
  }  // NOLINT(google-explicit-constructor): allocators convert
  T* allocate(std::size_t count) { return static_cast<T*>(allocate_lines(count * sizeof(T))); }
  void deallocate(T* items, std::size_t count) { free_lines(items, count * sizeof(T)); }
  friend bool operator==(const LineAllocator&, const LineAllocator&) { return true; }
};

template <class T>
using AlignedVector = std::vector<T, LineAllocator<T>>;

}  // namespace palpate::simd
