#include "grid/uniform.hpp"

#include <algorithm>
#include <limits>
#include <string>

#include <palpate/error.hpp>

#include "room.hpp"

namespace palpate {

void UniformGrid::clear(const Cell& size, std::size_t primitives) {
  for (const std::uint64_t cell : used_) cells_[cell] = {};
  used_.clear();
  blocks_.clear();
  left_blocks_.fill(no_block);

  const std::uint64_t most = most_cells_for(primitives);
  for (shift_ = 0;; ++shift_) {
    index_.resize(
        {((size[0] - 1) >> shift_) + 1, ((size[1] - 1) >> shift_) + 1, ((size[2] - 1) >> shift_) + 1});
    if (index_.last() < most) break;
  }
  if (cells_.size() <= index_.last()) {
    cells_.clear();  // all are empty: no need to copy them
    cells_.resize(index_.last() + 1);
  }
}

std::uint32_t UniformGrid::allocate_block(std::uint32_t size) {
  Index& left = left_blocks_[static_cast<std::size_t>(std::countr_zero(size))];
  if (left != no_block) {
    const Index block = left;
    left = at(blocks_, block);
    return static_cast<std::uint32_t>(block);
  }
  if (blocks_.size() + size > static_cast<std::size_t>(std::numeric_limits<Index>::max())) {
    throw Error("uniform grid", "", "more entries (cells covered by primitives)",
                "about 1000000000 at most; use a larger cell size");
  }
  const std::size_t block = blocks_.size();
  blocks_.resize(block + size);
  return static_cast<std::uint32_t>(block);
}

void UniformGrid::leave_block(std::uint32_t begin, std::uint32_t size) {
  Index& left = left_blocks_[static_cast<std::size_t>(std::countr_zero(size))];
  blocks_[begin] = left;
  left = static_cast<Index>(begin);
}

void UniformGrid::insert(std::uint64_t cell, Index reference) {
  CellArray& array = cells_[cell];
  if (array.size == 0) {
    used_.push_back(cell);
    array.begin = allocate_block(smallest_block);
  } else if (blocks_[array.begin + array.size - 1] == reference) {
    return;  // the primitive covers several lattice cells that belong to one cell of this grid
  } else if (array.size >= smallest_block && std::has_single_bit(array.size)) {
    const std::uint32_t larger = allocate_block(2 * array.size);
    std::copy_n(blocks_.begin() + array.begin, array.size, blocks_.begin() + larger);
    leave_block(array.begin, array.size);
    array.begin = larger;
  }
  blocks_[array.begin + array.size++] = reference;
}

void UniformGrid::keep_some_room(std::size_t capacity_before) {
  // Growth by doubling allocates up to twice the needed blocks. Blocks far beyond that are left over from
  // earlier frames.
  constexpr std::size_t most_spare = 8;
  keep_room(blocks_, capacity_before, blocks_.size() / 8);
  if (blocks_.capacity() > std::max<std::size_t>(65536, most_spare * blocks_.size())) {
    blocks_.shrink_to_fit();
    used_.shrink_to_fit();
  }
  make_room(used_, blocks_.capacity() / smallest_block);
}

}  // namespace palpate
