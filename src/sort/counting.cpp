#include "sort/counting.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>

#include "sort/digit_pass.hpp"
#include "sort/word.hpp"

namespace palpate {
namespace {

constexpr int fewest_digit_bits = 6;  ///< so that there are enough ranges for the threads
constexpr int range_bits = 12;  ///< cells of a range, if there are enough ranges: their starts fill 16 KiB

/// Bits of the key below those that choose the range.
int low_bits(int key_bits) {
  if (key_bits <= most_digit_bits) return 0;
  return key_bits - std::clamp(key_bits - range_bits, fewest_digit_bits, most_digit_bits);
}

/// Sorts the words of one range of cells, which begin at `first_word` of all, from `in` to `out`; `begin` are
/// the starts of the cells from `first_cell`.
void sort_range(std::span<const std::uint64_t> in, std::uint32_t first_word, std::size_t first_cell,
                std::span<std::uint32_t> begin, std::uint64_t* out) {
  std::fill(begin.begin(), begin.end(), 0U);
  for (const std::uint64_t word : in) ++begin[word_key(word) - first_cell];
  std::uint32_t position = first_word;
  for (std::uint32_t& slot : begin) {
    const std::uint32_t count = slot;
    slot = position;
    position += count;
  }
  for (const std::uint64_t word : in) out[begin[word_key(word) - first_cell]++] = word;
  // The writes have advanced each start to that of the next cell: shift them back.
  std::copy_backward(begin.begin(), begin.end() - 1, begin.end());
  begin.front() = first_word;
}

}  // namespace

void CountingSort::operator()(const parallel::Threads& threads, std::span<const std::uint32_t> keys,
                              std::uint32_t key_count, std::vector<std::uint64_t>& words,
                              std::vector<std::uint32_t>& cell_begin) {
  const int bits = key_count == 0 ? 0 : static_cast<int>(std::bit_width(key_count - 1));
  const int low = low_bits(bits);
  const std::size_t ranges = std::size_t{1} << (bits - low);
  std::vector<std::uint64_t>& by_range = low == 0 ? words : scratch_;
  by_range.resize(keys.size());
  scatter_keys(threads, keys, low, ranges, histograms_, range_begin_, by_range);
  const std::size_t total = range_begin_.back();
  words.resize(total);
  cell_begin.resize(std::size_t{key_count} + 1);
  cell_begin.back() = static_cast<std::uint32_t>(total);
  if (low == 0) {
    std::copy_n(range_begin_.begin(), key_count, cell_begin.begin());
    return;
  }
  parallel::for_each(threads, ranges, 1, [&](std::size_t range) {
    const std::size_t first_cell = range << low;
    if (first_cell >= key_count) return;
    const std::size_t cells = std::min<std::size_t>(std::size_t{1} << low, key_count - first_cell);
    const std::uint32_t begin = range_begin_[range];
    sort_range(std::span(scratch_).subspan(begin, range_begin_[range + 1] - begin), begin, first_cell,
               std::span(cell_begin).subspan(first_cell, cells), words.data());
  });
}

void index_cells(const parallel::Threads& threads, std::span<const std::uint64_t> words,
                 std::uint32_t key_count, std::vector<std::uint32_t>& cell_begin) {
  cell_begin.resize(std::size_t{key_count} + 1);
  const auto begin_of = [&](std::size_t cell) {
    return static_cast<std::size_t>(std::lower_bound(words.begin(), words.end(), std::uint64_t{cell} << 32) -
                                    words.begin());
  };
  // Without a branch on whether a word begins a cell, which is unpredictable. Each word writes where the next
  // cell begins, so the last word of a cell decides. Empty cells copy the value of the cell before.
  parallel::for_chunks(
      threads, cell_begin.size(), std::size_t{1} << 14, [&](std::size_t begin, std::size_t end, std::size_t) {
        const std::size_t first = begin_of(begin);
        const std::size_t last = begin_of(end - 1);  // later words write starts of the next chunk
        std::uint32_t* const cells = cell_begin.data();
        std::fill(cells + begin, cells + end, 0U);
        cells[begin] = static_cast<std::uint32_t>(first);
        for (std::size_t i = first; i < last; ++i)
          cells[word_key(words[i]) + 1] = static_cast<std::uint32_t>(i + 1);
        for (std::size_t cell = begin + 1; cell < end; ++cell)
          cells[cell] = std::max(cells[cell], cells[cell - 1]);
      });
}

}  // namespace palpate
