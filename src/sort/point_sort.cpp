#include "sort/point_sort.hpp"

#include "sort/word.hpp"

namespace palpate {
namespace {

/// Keys per word up to which a domain counts as dense. Above that, writing the starts of empty cells costs
/// more than another pass of a radix sort (docs/notes/benchmarks.md).
constexpr std::size_t dense_keys_per_word = 4;

}  // namespace

Sort PointSort::choose(std::uint32_t key_count, bool wants_cells) {
  const bool dense = key_count <= dense_keys_per_word * changes_.words_now();
  if (method_ == Sort::counting) return dense ? Sort::counting : Sort::radix;
  if (method_ != Sort::adaptive) return method_;
  if (switch_.repairs(changes_.movers(), changes_.words_now())) return Sort::repair;
  // Counting sort is better because it also computes cell starts; without them radix sort is as fast.
  return dense && wants_cells ? Sort::counting : Sort::radix;
}

void PointSort::sort_by_comparison(const parallel::Threads& threads, std::span<const std::uint32_t> keys,
                                   std::vector<std::uint64_t>& words) {
  // Puts new keys into the last order, which is then predominantly sorted. Points that disappeared get no_key
  // and come last.
  parallel::for_each(threads, words.size(), std::size_t{1} << 14, [&](std::size_t i) {
    const std::uint32_t reference = word_reference(words[i]);
    words[i] = make_word(reference < keys.size() ? keys[reference] : no_key, reference);
  });
  changes_.append_appeared(words);
  comparison_(threads, words);
  words.resize(changes_.words_now());
}

PointSort::Result PointSort::update(const parallel::Threads& threads, std::span<const std::uint32_t> keys,
                                    std::uint32_t key_count, std::vector<std::uint64_t>& words,
                                    std::vector<std::uint32_t>* cell_begin) {
  if (words.size() != changes_.words_before()) {
    changes_.clear();
    words.clear();
  }
  changes_.find(threads, keys);
  const Result result{choose(key_count, cell_begin != nullptr), changes_.movers()};
  const bool has_cells = cell_begin != nullptr && cells_of_last_frame_ == key_count &&
                         cell_begin->size() == std::size_t{key_count} + 1 &&
                         cell_begin->back() == changes_.words_before();
  const bool repairs_cells = result.used == Sort::repair && has_cells;
  switch (result.used) {
    case Sort::counting:
      counting_(threads, keys, key_count, words, cell_begin != nullptr ? *cell_begin : own_cell_begin_);
      break;
    case Sort::comparison:
      sort_by_comparison(threads, keys, words);
      break;
    case Sort::repair:
      repair_(threads, changes_, key_count, words, repairs_cells ? cell_begin : nullptr);
      break;
    default:
      radix_.from_keys(threads, keys, key_count, words);
      break;
  }
  changes_.accept(threads);
  if (cell_begin != nullptr && !repairs_cells && result.used != Sort::counting)
    index_cells(threads, words, key_count, *cell_begin);
  cells_of_last_frame_ = cell_begin != nullptr ? key_count : 0;
  return result;
}

}  // namespace palpate
