#include "measure/sorters.hpp"

#include <algorithm>
#include <cstring>
#include <memory>

#include "sort/point_sort.hpp"
#include "sort/word.hpp"

namespace palpate::measure {
namespace {

Sorter point_sort(Sort method, bool with_cells) {
  struct State {
    PointSort sort;
    parallel::Threads threads{1};
    std::vector<std::uint64_t> words;
    std::vector<std::uint32_t> cell_begin;
  };
  auto state = std::make_shared<State>();
  state->sort = PointSort(method);
  return
      [state, with_cells](const SortFrames& frames, std::size_t frame) -> const std::vector<std::uint64_t>& {
        state->sort.update(state->threads, frames.keys[frame], frames.key_count, state->words,
                           with_cells ? &state->cell_begin : nullptr);
        return state->words;
      };
}

/// std::sort, from last frame's order with the new keys (as the paper does) or from the order of references.
Sorter std_sort(bool from_last_order) {
  auto words = std::make_shared<std::vector<std::uint64_t>>();
  return [words, from_last_order](const SortFrames& frames,
                                  std::size_t frame) -> const std::vector<std::uint64_t>& {
    const std::vector<std::uint32_t>& keys = frames.keys[frame];
    if (from_last_order && words->size() == keys.size()) {
      for (std::uint64_t& word : *words) word = make_word(keys[word_reference(word)], word_reference(word));
    } else {
      words->resize(keys.size());
      for (std::size_t i = 0; i < keys.size(); ++i)
        (*words)[i] = make_word(keys[i], static_cast<std::uint32_t>(i));
    }
    std::sort(words->begin(), words->end());
    return *words;
  };
}

/// The lower bound: copies the expected result.
Sorter copy() {
  auto words = std::make_shared<std::vector<std::uint64_t>>();
  return [words](const SortFrames& frames, std::size_t) -> const std::vector<std::uint64_t>& {
    // Always copy the first frame, so that no more memory is used than by a sort in place.
    const std::vector<std::uint64_t>& from = frames.sorted.front();
    words->resize(from.size());
    std::memcpy(words->data(), from.data(), from.size() * sizeof(std::uint64_t));
    return *words;
  };
}

}  // namespace

std::vector<Competitor> competitors() {
  return {
      {"memcpy", copy},
      {"std_sort_last_order", [] { return std_sort(true); }},
      {"std_sort_reference_order", [] { return std_sort(false); }},
      {"comparison", [] { return point_sort(Sort::comparison, false); }},
      {"radix", [] { return point_sort(Sort::radix, false); }},
      {"counting", [] { return point_sort(Sort::counting, false); }},
      {"repair", [] { return point_sort(Sort::repair, false); }},
      {"adaptive", [] { return point_sort(Sort::adaptive, false); }},
      {"radix_with_C", [] { return point_sort(Sort::radix, true); }},
      {"counting_with_C", [] { return point_sort(Sort::counting, true); }},
      {"repair_with_C", [] { return point_sort(Sort::repair, true); }},
  };
}

}  // namespace palpate::measure
