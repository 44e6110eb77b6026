#pragma once

#include <cstdint>

#include <palpate/settings.hpp>

#include "grid/lattice.hpp"
#include "grid/z_order.hpp"

namespace palpate {

/// Maps the coordinates of a cell to one number of at most 63 bits: eq. 1 of the paper, or Z-order. Both grow
/// with each coordinate, so the corners of a range have its lowest and highest index.
class CellIndex {
 public:
  explicit CellIndex(Order order = Order::linear) : order_(order) {}

  /// Sets the number of cells along each axis, each in [1, 2^21].
  void resize(const Cell& size) {
    if (size == size_) return;
    size_ = size;
    if (order_ == Order::z) z_ = ZOrder(size);
  }

  /// The index is part(0, i) + part(1, j) + part(2, k): loops over a row add only the last.
  [[nodiscard]] std::uint64_t part(std::size_t axis, std::int32_t coordinate) const {
    if (order_ == Order::z) return z_.part(axis, coordinate);
    const auto c = static_cast<std::uint64_t>(coordinate);
    if (axis == 0) return c;
    const std::uint64_t row = c * static_cast<std::uint64_t>(size_[0]);
    return axis == 1 ? row : row * static_cast<std::uint64_t>(size_[1]);
  }
  [[nodiscard]] std::uint64_t operator()(const Cell& cell) const {
    return part(0, cell[0]) + part(1, cell[1]) + part(2, cell[2]);
  }
  /// The inverse.
  [[nodiscard]] Cell cell_of(std::uint64_t index) const {
    if (order_ == Order::z) return z_.cell_of(index);
    const auto sx = static_cast<std::uint64_t>(size_[0]);
    const auto sy = static_cast<std::uint64_t>(size_[1]);
    return {static_cast<std::int32_t>(index % sx), static_cast<std::int32_t>(index / sx % sy),
            static_cast<std::int32_t>(index / sx / sy)};
  }
  /// The highest index.
  [[nodiscard]] std::uint64_t last() const { return (*this)({size_[0] - 1, size_[1] - 1, size_[2] - 1}); }
  [[nodiscard]] Order order() const { return order_; }
  [[nodiscard]] const ZOrder& z() const { return z_; }

 private:
  Order order_;
  Cell size_{0, 0, 0};
  ZOrder z_;
};

}  // namespace palpate
