#include "grid/z_order.hpp"

#include <bit>

namespace palpate {

ZOrder::ZOrder(const Cell& size) {
  std::array<std::array<int, axis_bits_>, 3> place{};
  std::array<int, 3> used{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    used[axis] = static_cast<int>(std::bit_width(static_cast<std::uint32_t>(size[axis] - 1)));
  for (int level = 0; level < axis_bits_; ++level) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (level >= used[axis]) continue;
      at(axis_of_bit_, bits_) = static_cast<std::uint8_t>(axis);
      at(place[axis], level) = bits_++;
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (int bit = 0; bit < used[axis]; ++bit) {
      auto& table = at(spread_[axis], bit / chunk_bits_);
      for (std::uint32_t value = 0; value < chunk_; ++value) {
        if ((value >> (bit % chunk_bits_)) & 1U) table[value] |= std::uint64_t{1} << at(place[axis], bit);
      }
    }
  }
}

Cell ZOrder::cell_of(std::uint64_t index) const {
  Cell cell{0, 0, 0};
  std::array<int, 3> level{};
  for (int bit = 0; bit < bits_; ++bit) {
    const std::size_t axis = at(axis_of_bit_, bit);
    cell[axis] |= static_cast<std::int32_t>((index >> bit) & 1U) << level[axis]++;
  }
  return cell;
}

int ZOrder::low_bits(std::size_t axis, int count) const {
  int bits = 0;
  for (int bit = 0; bit < count; ++bit) bits += at(axis_of_bit_, bit) == axis ? 1 : 0;
  return bits;
}

}  // namespace palpate
