#include "grid/uniform.hpp"

#include <algorithm>

namespace palpate {

void UniformGrid::clear(const Cell& size, std::size_t primitives) {
  for (const std::uint64_t cell : used_) cells_[cell].clear();
  used_.clear();
  // Growth by doubling asks for up to twice the references; what is far beyond that is left from other
  // frames.
  constexpr std::size_t most_spare = 8;
  if (capacity_ > std::max<std::size_t>(65536, most_spare * references_)) {
    std::vector<std::vector<Index>>().swap(cells_);
    capacity_ = 0;
  }
  references_ = 0;

  const std::uint64_t most = most_cells_for(primitives);
  for (shift_ = 0;; ++shift_) {
    index_.resize(
        {((size[0] - 1) >> shift_) + 1, ((size[1] - 1) >> shift_) + 1, ((size[2] - 1) >> shift_) + 1});
    if (index_.last() < most) break;
  }
  if (cells_.size() <= index_.last()) {
    std::vector<std::vector<Index>>().swap(cells_);  // all empty: not worth moving
    capacity_ = 0;
    cells_.resize(index_.last() + 1);
  }
}

void UniformGrid::insert(std::uint64_t cell, Index reference) {
  std::vector<Index>& references = cells_[cell];
  if (references.empty()) {
    used_.push_back(cell);
  } else if (references.back() == reference) {
    return;  // this primitive covers several cells of the lattice that are one here
  }
  const std::size_t before = references.capacity();
  references.push_back(reference);
  capacity_ += references.capacity() - before;
  ++references_;
}

}  // namespace palpate
