#include "simd/aligned.hpp"

#include <new>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace palpate::simd {
namespace {

constexpr std::size_t line = 64;
/// Page size of x86-64 and most other processors. On others the memory is aligned more than needed.
constexpr std::size_t large_page = std::size_t{1} << 21;

/// Large pages are used for blocks of half a page or more, so that rounding up at most doubles the memory.
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
  // This is only a hint: without large pages everything works, but more slowly.
  if (is_large(bytes)) static_cast<void>(::madvise(memory, whole, MADV_HUGEPAGE));
#endif
  return memory;
}

void free_lines(void* memory, std::size_t bytes) {
  ::operator delete(memory, alignment_of(bytes));
}

}  // namespace palpate::simd
