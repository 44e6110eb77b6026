#include "simd/aligned.hpp"

#include <new>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace palpate::simd {
namespace {

constexpr std::size_t line = 64;
/// Of x86-64 and most others; elsewhere it only aligns more than there is need for.
constexpr std::size_t large_page = std::size_t{1} << 21;

/// From half a page on: no more than as much again is wasted.
bool is_large(std::size_t bytes) {
  return bytes >= large_page / 2;
}

std::align_val_t alignment_of(std::size_t bytes) {
  return std::align_val_t{is_large(bytes) ? large_page : line};
}

}  // namespace

void* allocate_lines(std::size_t bytes) {
  const std::size_t whole = is_large(bytes) ? (bytes + large_page - 1) / large_page * large_page : bytes;
  void* memory = ::operator new(whole, alignment_of(bytes));
#if defined(__linux__) && defined(MADV_HUGEPAGE)
  // A wish: where it is not granted all works as well, only slower.
  if (is_large(bytes)) static_cast<void>(::madvise(memory, whole, MADV_HUGEPAGE));
#endif
  return memory;
}

void free_lines(void* memory, std::size_t bytes) {
  ::operator delete(memory, alignment_of(bytes));
}

}  // namespace palpate::simd
