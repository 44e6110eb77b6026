#include "grid/compact.hpp"

#include <algorithm>
#include <bit>
#include <numeric>
#include <utility>

namespace palpate {

void CompactGrid::choose_shifts(std::size_t primitives) {
  constexpr int key_bits = 63 - entry_key_bit;  // the largest 32-bit number says "no key"
  const std::uint64_t last = index_.last();
  key_shift_ = std::max(0, static_cast<int>(std::bit_width(last)) - key_bits);
  const std::uint64_t most = most_cells_for(primitives);
  start_shift_ = 0;
  while ((last >> key_shift_ >> start_shift_) >= most) ++start_shift_;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    block_bits_[axis] = index_.order() == Order::z ? index_.z().low_bits(axis, key_shift_) : 0;
  }
}

void CompactGrid::sort_entries(const parallel::Threads& threads, std::uint32_t largest_key) {
  if (sort_ == Sort::comparison) {
    comparison_sort_(threads, entries_);
    return;
  }
  // Primitives that cover several cells have no previous order to repair. Entries were written in order of
  // their references, so a stable sort by key alone gives the order of words.
  radix_sort_(threads, entries_, entry_key_bit, make_entry(largest_key, 0));
}

void CompactGrid::index_entries(const parallel::Threads& threads) {
  const std::uint32_t last_key = key_of(index_.last());
  const std::size_t blocks = std::size_t{last_key >> start_shift_} + 1;
  cell_begin_.resize(blocks + 1);
  const auto block_of = [&](std::size_t e) { return std::size_t{cell_key_of(entries_[e]) >> start_shift_}; };
  // Entry e writes the starts of all blocks after that of its predecessor, up to its own. So each start is
  // written once.
  const std::size_t n = entries_.size();
  parallel::for_each(threads, n + 1, std::size_t{1} << 14, [&](std::size_t e) {
    const std::size_t first = e == 0 ? 0 : block_of(e - 1) + 1;
    const std::size_t last = e == n ? blocks : block_of(e);
    for (std::size_t block = first; block <= last; ++block)
      cell_begin_[block] = static_cast<std::uint32_t>(e);
  });
}

Sort CompactGrid::sort_points(const parallel::Threads& threads) {
  // Results must not depend on frames for which no grid was built. After one, sort from scratch: do not start
  // from the order of the last build.
  if (std::exchange(skipped_, false)) point_sort_.forget();
  // If each start belongs to one key, the sort also computes C.
  std::vector<std::uint32_t>* const starts = start_shift_ == 0 ? &cell_begin_ : nullptr;
  const PointSort::Result result =
      point_sort_.update(threads, keys_, key_of(index_.last()) + 1, entries_, starts);
  if (starts == nullptr) index_entries(threads);
  movers_ = result.movers;
  return result.used;
}

Sort CompactGrid::build_points(const parallel::Threads& threads, const Lattice& lattice,
                               const FixedPositions& points) {
  if (!skipped_) {
    write_keys(threads, lattice, points);
    return sort_points(threads);
  }
  skip_points(threads, lattice, points);
  const std::size_t movers = movers_;
  const Sort used = sort_points(threads);
  movers_ = movers;
  return used;
}

void CompactGrid::skip_points(const parallel::Threads& threads, const Lattice& lattice,
                              const FixedPositions& points) {
  std::swap(keys_, keys_before_);
  write_keys(threads, lattice, points);
  skipped_ = true;
  movers_ = keys_.size();
  if (keys_before_.size() != keys_.size()) return;
  constexpr std::size_t grain = 8192;
  mover_scratch_.assign(parallel::chunk_count(keys_.size(), grain), 0.0);
  parallel::for_chunks(threads, keys_.size(), grain,
                       [&](std::size_t begin, std::size_t end, std::size_t chunk) {
                         std::uint32_t moved = 0;
                         for (std::size_t p = begin; p < end; ++p)
                           moved += keys_[p] != keys_before_[p] ? 1U : 0U;
                         mover_scratch_[chunk] = moved;
                       });
  movers_ = static_cast<std::size_t>(std::accumulate(mover_scratch_.begin(), mover_scratch_.end(), 0.0));
}

void CompactGrid::write_keys(const parallel::Threads& threads, const Lattice& lattice,
                             const FixedPositions& points) {
  const std::size_t count = points.points().size();
  index_.resize(lattice.size());
  choose_shifts(count);
  const bool linear =
      index_.order() == Order::linear && key_shift_ == 0 && std::bit_width(index_.last()) < 32;
  if (linear) return points.write_linear_keys(threads, keys_);
  keys_.resize(count);
  parallel::for_each(threads, count, 2048, [&](std::size_t i) {
    const auto p = static_cast<Index>(i);
    keys_[i] = points.included(p) ? key_of(index_(points.cell_of(at(points.points(), p)))) : no_key;
  });
}

CompactGrid::Interval CompactGrid::within(Interval block, std::uint32_t first, std::uint32_t last) const {
  const auto before = [](Entry entry, std::uint32_t key) { return cell_key_of(entry) < key; };
  const auto after = [](std::uint32_t key, Entry entry) { return key < cell_key_of(entry); };
  const auto l = entries_.begin();
  const auto begin = std::lower_bound(l + block.begin, l + block.end, first, before);
  const auto end = std::upper_bound(begin, l + block.end, last, after);
  return {static_cast<std::uint32_t>(begin - l), static_cast<std::uint32_t>(end - l)};
}

}  // namespace palpate
