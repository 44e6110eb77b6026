#include "fem/block_matrix.hpp"

#include <algorithm>
#include <cstddef>
#include <string>

#include <palpate/error.hpp>

#include "fem/row_order.hpp"

namespace palpate::fem {
namespace {

constexpr std::size_t block_slice_grain = 8;
constexpr Index most_elements = Index{1} << 28;  // an element and two of its corners must fit into 32 bits
constexpr std::size_t most_tangent_values = std::size_t{1} << 31;  // twice a place must fit into 32 bits
constexpr std::uint32_t no_slot = 0xffffffffU;

}  // namespace

BlockMatrix::BlockMatrix(const Elements& elements, std::span<const std::uint8_t> free)
    : elements_(&elements), diagonal_(free.size(), 1.0) {
  if (elements.size() >= most_elements) {
    throw Error("dynamics", "elements", std::to_string(elements.size()),
                "fewer than " + std::to_string(most_elements));
  }
  if (elements.tangents().size() >= most_tangent_values) {
    throw Error("dynamics", "values of tangents", std::to_string(elements.tangents().size()),
                "fewer than " + std::to_string(most_tangent_values));
  }
  gather_corners();
  list_columns(free);
  order_rows(free);
  const std::size_t slices = point_of_row_.size() / simd::slice_rows + 1;
  halves_.emplace_back();
  slot_begin_.push_back(0);
  term_begin_.push_back(0);
  for (std::size_t slice = 0; slice < slices; ++slice) build_slice(slice);
  place_domains();
  mixed_ = has_mixed_bodies();
  slots_.resize(slot_begin_.back());
  masses_.resize(row_count());
  diagonal_blocks_.resize(simd::slice_symmetric * slices);
}

void BlockMatrix::gather_corners() {
  auto& begin = elements_of_point_.begin;
  begin.assign(diagonal_.size() + 1, 0);
  for (const Tet& corners : elements_->corners()) {
    for (const Index point : corners) ++at(begin, point + 1);
  }
  for (std::size_t i = 1; i < begin.size(); ++i) begin[i] += begin[i - 1];
  elements_of_point_.values.resize(static_cast<std::size_t>(begin.back()));
  corners_of_point_.resize(elements_of_point_.values.size());
  std::vector<Index> next(begin.begin(), begin.end() - 1);
  for (Index element = 0; element < elements_->size(); ++element) {
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const Index entry = at(next, at(elements_->corners(), element)[corner])++;
      at(elements_of_point_.values, entry) = element;
      at(corners_of_point_, entry) =
          4 * static_cast<std::uint32_t>(element) + static_cast<std::uint32_t>(corner);
    }
  }
}

void BlockMatrix::list_columns(std::span<const std::uint8_t> free) {
  column_begin_.assign(1, 0);
  for (Index point = 0; point < size(); ++point) {
    const std::size_t first = columns_.size();
    if (at(free, point) != 0) {
      columns_.push_back(static_cast<std::uint32_t>(point));
      for (const Index element : elements_of_point_[point]) {
        for (const Index other : at(elements_->corners(), element))
          columns_.push_back(static_cast<std::uint32_t>(other));
      }
      for (const SmoothingDomains::Entry& entry : elements_->smoothing().entries(point)) {
        for (const Index other : elements_->smoothing().points(entry.domain))
          columns_.push_back(static_cast<std::uint32_t>(other));
      }
      const auto own = columns_.begin() + static_cast<std::ptrdiff_t>(first);
      std::sort(own, columns_.end());
      columns_.erase(std::unique(own, columns_.end()), columns_.end());
    }
    column_begin_.push_back(static_cast<std::uint32_t>(columns_.size()));
  }
  slot_of_column_.assign(columns_.size(), no_slot);
}

/// Greedy colouring along the curve: no two points of an element have the same colour.
std::vector<int> BlockMatrix::color_points(std::span<const Index> points) {
  std::vector<int> color(diagonal_.size(), -1);
  std::vector<std::size_t> taken_by;  // per colour: the last point that has a neighbour of this colour
  for (std::size_t k = 0; k < points.size(); ++k) {
    for (const std::uint32_t other : columns(points[k])) {
      const int used = color[other];
      if (used >= 0) at(taken_by, used) = k + 1;
    }
    const auto least = std::ranges::find_if(taken_by, [&](std::size_t last) { return last != k + 1; });
    at(color, points[k]) = static_cast<int>(least - taken_by.begin());
    if (least == taken_by.end()) taken_by.push_back(0);
  }
  slices_of_color_.assign(taken_by.size(), {});
  return color;
}

/// Whether a point belongs to a body with tangent blocks. All elements of a body are stored in the same way.
bool BlockMatrix::has_tangent_blocks(Index point) const {
  const auto elements = elements_of_point_[point];
  return !elements.empty() && elements.front() >= elements_->tangent_begin();
}

void BlockMatrix::append_rows(std::span<const Index> points, std::span<const int> color) {
  // Rows of a slice are taken from one window. It is large enough for slices whose rows have similar numbers
  // of blocks, and small enough that neighbours in space stay close in memory.
  constexpr std::size_t window = 512;
  std::vector<Index> sorted(points.begin(), points.end());
  std::ranges::stable_sort(sorted, {}, [&](Index point) { return at(color, point); });
  const auto earlier = [&](Index point) {
    return std::ranges::count_if(columns(point),
                                 [&](std::uint32_t other) { return color[other] < at(color, point); });
  };
  const auto before = [&](Index a, Index b) {
    return columns(a).size() != columns(b).size() ? columns(a).size() > columns(b).size()
                                                  : earlier(a) > earlier(b);
  };
  for (auto first = sorted.begin(); first != sorted.end();) {
    const int own = at(color, *first);
    const auto last = std::find_if(first, sorted.end(), [&](Index point) { return at(color, point) != own; });
    const auto color_begin = static_cast<std::uint32_t>(point_of_row_.size());
    for (auto from = first; from != last;) {
      const auto to = last - from > static_cast<std::ptrdiff_t>(window) ? from + window : last;
      std::stable_sort(from, to, before);
      from = to;
    }
    point_of_row_.insert(point_of_row_.end(), first, last);
    pad_slice();
    while (simd::slice_rows * halves_.size() < point_of_row_.size()) {
      at(slices_of_color_, own).push_back(static_cast<std::uint32_t>(halves_.size()));
      halves_.push_back({.color_begin = color_begin});
    }
    first = last;
  }
}

void BlockMatrix::order_rows(std::span<const std::uint8_t> free) {
  std::vector<Index> points = points_along_curve(elements_->points_rest(), body_of_point(), free);
  const std::vector<int> color = color_points(points);
  const auto full =
      std::ranges::stable_partition(points, [&](Index point) { return !has_tangent_blocks(point); });
  const std::span all(points);
  append_rows(all.first(all.size() - full.size()), color);
  first_tangent_slice_ = point_of_row_.size() / simd::slice_rows;
  append_rows(all.last(full.size()), color);
  row_of_point_.assign(free.size(), -1);
  for (std::size_t row = 0; row < point_of_row_.size(); ++row) {
    if (point_of_row_[row] >= 0) at(row_of_point_, point_of_row_[row]) = static_cast<Index>(row);
  }
}

void BlockMatrix::pad_slice() {
  while (point_of_row_.size() % simd::slice_rows != 0) point_of_row_.push_back(-1);
}

/// Whether a column belongs to a row of an earlier colour.
bool BlockMatrix::is_earlier(std::uint32_t place, std::uint32_t color_begin) const {
  const Index row = row_of_point_[columns_[place]];
  return row >= 0 && static_cast<std::uint32_t>(row) < color_begin;
}

/// Lists the slots and terms of a slice. The blocks of a row with earlier colours come first. In each half
/// they are sorted by their number of terms, so that the blocks of a slot have similar numbers.
void BlockMatrix::build_slice(std::size_t slice) {
  struct LaneBlock {
    std::uint32_t place = 0;  ///< in columns_
    std::vector<std::uint32_t> terms;
  };
  std::array<std::vector<LaneBlock>, simd::slice_rows> lanes;
  std::size_t slots = 0;
  std::size_t most_earlier = 0;
  std::size_t least_earlier = ~std::size_t{0};
  const bool full = slice >= first_tangent_slice_;
  for (std::size_t lane = 0; lane < simd::slice_rows; ++lane) {
    const std::size_t row = simd::slice_rows * slice + lane;
    const Index point = row < point_of_row_.size() ? point_of_row_[row] : -1;
    if (point < 0) continue;
    for (std::uint32_t place = at(column_begin_, point); place < at(column_begin_, point + 1); ++place) {
      if (columns_[place] != static_cast<std::uint32_t>(point)) lanes[lane].push_back({place, {}});
    }
    for (Index entry = at(elements_of_point_.begin, point); entry < at(elements_of_point_.begin, point + 1);
         ++entry) {
      const std::uint32_t own = at(corners_of_point_, entry);
      if (elements_->is_smoothed(static_cast<Index>(own / 4))) continue;
      const Tet& corners = elements_->corners()[own / 4];
      for (std::uint32_t k = 1; k < 4; ++k) {
        const std::uint32_t other = (own + k) % 4;
        const auto block =
            std::ranges::lower_bound(lanes[lane], static_cast<std::uint32_t>(corners[other]), {},
                                     [&](const LaneBlock& b) { return columns_[b.place]; });
        block->terms.push_back(full ? tangent_term(static_cast<Index>(own / 4), static_cast<int>(own % 4),
                                                   static_cast<int>(other))
                                    : 4 * own + other);
      }
    }
    std::ranges::stable_sort(lanes[lane], std::greater(), [](const LaneBlock& b) { return b.terms.size(); });
    const auto later = std::ranges::stable_partition(
        lanes[lane], [&](const LaneBlock& b) { return is_earlier(b.place, halves_[slice].color_begin); });
    const std::size_t earlier = lanes[lane].size() - later.size();
    slots = std::max(slots, lanes[lane].size());
    most_earlier = std::max(most_earlier, earlier);
    if (!later.empty()) least_earlier = std::min(least_earlier, earlier);
  }
  halves_[slice].first_later =
      slot_begin_.back() + static_cast<std::uint32_t>(std::min(least_earlier, slots));
  halves_[slice].last_earlier = slot_begin_.back() + static_cast<std::uint32_t>(most_earlier);
  // A term whose values are zero.
  const auto empty = full ? empty_tangent_term() : 16 * static_cast<std::uint32_t>(elements_->size());
  const auto append_terms = [&](auto&& terms_of) {
    std::size_t most = 0;
    for (std::size_t lane = 0; lane < simd::slice_rows; ++lane) most = std::max(most, terms_of(lane).size());
    for (std::size_t t = 0; t < most; ++t) {
      for (std::size_t lane = 0; lane < simd::slice_rows; ++lane) {
        const auto terms = terms_of(lane);
        terms_.push_back(t < terms.size() ? terms[t] : empty);
      }
    }
    term_begin_.push_back(static_cast<std::uint32_t>(terms_.size() / simd::slice_rows));
  };
  const auto zero_row = static_cast<std::uint32_t>(point_of_row_.size());
  for (std::size_t s = 0; s < slots; ++s) {
    const auto slot = slot_begin_.back() + static_cast<std::uint32_t>(s);
    for (std::size_t lane = 0; lane < simd::slice_rows; ++lane) {
      if (s >= lanes[lane].size()) {
        column_of_lane_.push_back(static_cast<std::uint32_t>(simd::slice_rows * slice + lane));
        continue;
      }
      const std::uint32_t place = lanes[lane][s].place;
      slot_of_column_[place] = slot;
      const Index row = row_of_point_[columns_[place]];
      column_of_lane_.push_back(row < 0 ? zero_row : static_cast<std::uint32_t>(row));
    }
    append_terms([&](std::size_t lane) {
      return s < lanes[lane].size() ? std::span<const std::uint32_t>(lanes[lane][s].terms)
                                    : std::span<const std::uint32_t>();
    });
  }
  slot_begin_.push_back(slot_begin_.back() + static_cast<std::uint32_t>(slots));
}

/// Whether lambda / mu differs within a body. Then all rows use the slower loop: blocks (i, j) and (j, i)
/// must be computed in the same way, and a slice may have rows of several bodies.
bool BlockMatrix::has_mixed_bodies() const {
  const auto bodies = elements_->body_of_element();
  const auto ratios = elements_->ratios();
  for (std::size_t e = 1; e < static_cast<std::size_t>(elements_->tangent_begin()); ++e) {
    if (bodies[e] == bodies[e - 1] && ratios[e] != ratios[e - 1]) return true;
  }
  return false;
}

void BlockMatrix::assemble(const parallel::Threads& threads, std::span<const double> diagonal) {
  std::copy(diagonal.begin(), diagonal.end(), diagonal_.begin());
  for (std::size_t row = 0; row < point_of_row_.size(); ++row)
    masses_[row] = point_of_row_[row] < 0 ? 0.0F : static_cast<float>(at(diagonal, point_of_row_[row]));
  const simd::SlicedAssembly rows{.slot_begin = slot_begin_.data(),
                                  .term_begin = term_begin_.data(),
                                  .terms = terms_.data(),
                                  .gradients = elements_->gradients().data(),
                                  .masses = masses_.data(),
                                  .mixed = mixed_};
  float* values = slots_.empty() ? nullptr : slots_.front().values.data();
  elements_->smoothing().prepare_blocks(threads);
  parallel::for_chunks(
      threads, slice_count(), block_slice_grain, [&](std::size_t begin, std::size_t end, std::size_t) {
        const std::size_t full = std::clamp(first_tangent_slice_, begin, end);
        simd::assemble_slices(rows, values, diagonal_blocks_.data(), begin, full);
        if (!elements_->tense().all().empty()) {
          for (std::size_t row = simd::slice_rows * begin; row < simd::slice_rows * full; ++row)
            add_tension(row);
        }
        assemble_tangent(full, end);
      });
}

/// Adds the geometric stiffness of the elements at the point of a row, elements ascending; (i, j) and (j, i)
/// get transposed bits.
void BlockMatrix::add_tension(std::size_t row) {
  const Index point = row < point_of_row_.size() ? point_of_row_[row] : -1;
  if (point < 0) return;
  const std::size_t lane = row % simd::slice_rows;
  const auto own_columns = columns(point);
  float* const diagonal = diagonal_blocks_.data() + simd::slice_symmetric * (row / simd::slice_rows) + lane;
  const auto add = [](float* value, double by) { *value += static_cast<float>(by); };
  for (const Index element : elements_of_point_[point]) {
    const TenseElements::Tense* const tense = elements_->tense().find(element);
    if (tense == nullptr) continue;
    const Tet& corners = at(elements_->corners(), element);
    const auto own = static_cast<int>(std::ranges::find(corners, point) - corners.begin());
    for (int j = 0; j < 4; ++j) {
      const Matrix3 above = geometric_block(tense->q, elements_->gradient(element, std::min(own, j)),
                                            elements_->gradient(element, std::max(own, j)));
      if (own == j) {
        const SymmetricMatrix3 b = symmetric_part(above);
        std::size_t k = 0;
        for (const double value : {b.xx, b.yy, b.zz, b.xy, b.xz, b.yz})
          add(diagonal + simd::slice_rows * k++, value);
        continue;
      }
      const Matrix3 block = own < j ? above : transposed(above);
      const auto column = static_cast<std::uint32_t>(at(corners, j));
      const auto place = std::ranges::lower_bound(own_columns, column) - own_columns.begin();
      const std::uint32_t slot = slot_of_column_[at(column_begin_, point) + static_cast<std::size_t>(place)];
      for (std::size_t k = 0; k < 9; ++k)
        add(&slots_[slot].values[simd::slice_rows * k + lane], block.values[k]);
    }
  }
}

std::span<const std::uint32_t> BlockMatrix::columns(Index point) const {
  const std::uint32_t first = at(column_begin_, point);
  return std::span(columns_).subspan(first, at(column_begin_, point + 1) - first);
}

Matrix3 BlockMatrix::block(Index point, std::size_t place) const {
  const auto row = static_cast<std::size_t>(at(row_of_point_, point));
  const std::size_t lane = row % simd::slice_rows;
  const std::uint32_t slot = slot_of_column_[at(column_begin_, point) + place];
  Matrix3 block;
  if (slot != no_slot) {
    for (std::size_t k = 0; k < 9; ++k)
      block.values[k] = static_cast<double>(slots_[slot].values[simd::slice_rows * k + lane]);
    return block;
  }
  const float* own = diagonal_blocks_.data() + simd::slice_symmetric * (row / simd::slice_rows) + lane;
  constexpr std::array<std::size_t, 9> entry_of{0, 3, 4, 3, 1, 5, 4, 5, 2};
  for (std::size_t k = 0; k < 9; ++k)
    block.values[k] = static_cast<double>(own[simd::slice_rows * entry_of[k]]);
  return block;
}

std::vector<Index> BlockMatrix::body_of_point() const {
  std::vector<Index> bodies(diagonal_.size(), 0);
  for (std::size_t e = 0; e < elements_->corners().size(); ++e) {
    for (const Index point : elements_->corners()[e]) at(bodies, point) = elements_->body_of_element()[e];
  }
  return bodies;
}

simd::SlicedRows BlockMatrix::rows() const {
  return {.slot_begin = slot_begin_.data(),
          .halves = halves_.data(),
          .columns = column_of_lane_.data(),
          .values = slots_.empty() ? nullptr : slots_.front().values.data(),
          .masses = masses_.data()};
}

}  // namespace palpate::fem
