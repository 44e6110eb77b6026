#pragma once

#include <cstddef>
#include <vector>

namespace palpate::simd {

/// Allocates memory that begins with a cache line. Large blocks ask the system for large pages: fewer TLB
/// misses. Free it with free_lines() and the same number of bytes. Throws std::bad_alloc.
void* allocate_lines(std::size_t bytes);
void free_lines(void* memory, std::size_t bytes);

/// Allocates from a cache line on, so that no vector of lanes crosses two lines.
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
