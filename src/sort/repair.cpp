#include "sort/repair.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "room.hpp"
#include "simd/merge_events.hpp"
#include "sort/counting.hpp"
#include "sort/word.hpp"

namespace palpate {
namespace {

/// Words of a segment, and cells of a chunk.
constexpr std::size_t repair_grain = std::size_t{1} << 15;
/// Number of events above which a radix sort is faster.
constexpr std::size_t few_events = 256;

/// Words (and cells) that a full sort handles in the time in which one event moves the words after it.
constexpr std::size_t words_for_an_event = 32;

constexpr std::uint64_t unmarked(std::uint64_t event) {
  return event & ~simd::removal;
}

bool before(std::uint64_t event, std::uint64_t word) {
  return unmarked(event) < word;
}

}  // namespace

void RepairSort::sort_events(const parallel::Threads& threads, std::uint32_t key_count) {
  if (events_.size() < few_events) {
    std::sort(events_.begin(), events_.end(),
              [](std::uint64_t a, std::uint64_t b) { return unmarked(a) < unmarked(b); });
    return;
  }
  // Events are in the order of references, and the sort is stable, so it sorts by key only. Removed keys may
  // be those of a frame with more keys.
  std::uint64_t largest = make_word(key_count == 0 ? 0 : key_count - 1, no_key);
  for (const std::uint64_t event : events_) largest |= event;
  radix_(threads, events_, word_key_bit, largest);
}

void RepairSort::cut(const parallel::Threads& threads, std::span<const std::uint64_t> words) {
  const std::size_t count = std::max<std::size_t>(1, parallel::chunk_count(words.size(), repair_grain));
  segments_.assign(count + 1, {});
  for (std::size_t s = 1; s < count; ++s) {
    const auto first = std::lower_bound(events_.begin(), events_.end(), words[s * repair_grain], before);
    segments_[s].first_event = static_cast<std::size_t>(first - events_.begin());
  }
  segments_[count].first_event = events_.size();
  parallel::for_each(threads, count, 1, [&](std::size_t s) {
    const std::size_t begin = segments_[s].first_event;
    const std::size_t end = segments_[s + 1].first_event;
    std::size_t removals = 0;
    for (std::size_t e = begin; e < end; ++e) removals += (events_[e] & simd::removal) != 0 ? 1 : 0;
    const std::size_t first_word = std::min(words.size(), s * repair_grain);
    const std::size_t last_word = std::min(words.size(), (s + 1) * repair_grain);
    segments_[s + 1].first_merged = (last_word - first_word) + (end - begin) - 2 * removals;
  });
  for (std::size_t s = 1; s <= count; ++s) segments_[s].first_merged += segments_[s - 1].first_merged;
}

void RepairSort::shift_cells(const parallel::Threads& threads, std::span<const std::uint64_t> words,
                             std::vector<std::uint32_t>& cell_begin) const {
  // The begin of a cell grows by the words inserted before it, less those removed.
  parallel::for_chunks(
      threads, cell_begin.size(), repair_grain, [&](std::size_t begin, std::size_t end, std::size_t) {
        const std::uint64_t bound = make_word(static_cast<std::uint32_t>(begin), 0);
        const auto position = std::lower_bound(words.begin(), words.end(), bound) - words.begin();
        auto event = std::lower_bound(events_.begin(), events_.end(), bound, before);
        std::uint32_t shift = static_cast<std::uint32_t>(position) - cell_begin[begin];
        std::size_t cell = begin;
        while (cell < end) {
          const std::size_t stop =
              event == events_.end() ? end : std::min<std::size_t>(end, std::size_t{word_key(*event)} + 1);
          for (; cell < stop; ++cell) cell_begin[cell] += shift;
          if (event != events_.end()) {
            shift += (*event & simd::removal) != 0 ? 0xFFFFFFFFU : 1U;
            ++event;
          }
        }
      });
}

void RepairSort::operator()(const parallel::Threads& threads, KeyChanges& changes, std::uint32_t key_count,
                            std::vector<std::uint64_t>& words, std::vector<std::uint32_t>* cell_begin) {
  if (changes.movers() == 0) return;
  // Room for the events that the switch allows (two per mover), and for frames with more movers than this
  // one.
  make_room(events_, words.size() / 4);
  if (events_.capacity() < 2 * changes.movers()) events_.reserve(std::bit_ceil(4 * changes.movers()));
  changes.list_events(threads, events_);
  sort_events(threads, key_count);
  cut(threads, words);
  if (merged_.capacity() < changes.words_now()) {
    merged_.clear();  // no words to copy
    merged_.reserve(changes.words_now() + changes.words_now() / 8);
  }
  merged_.resize(changes.words_now());
  parallel::for_each(threads, segments_.size() - 1, 1, [&](std::size_t s) {
    const std::size_t first_word = std::min(words.size(), s * repair_grain);
    const std::size_t last_word = std::min(words.size(), (s + 1) * repair_grain);
    const Segment& from = segments_[s];
    const Segment& to = segments_[s + 1];
    simd::merge_events(
        std::span<const std::uint64_t>(words).subspan(first_word, last_word - first_word),
        std::span<const std::uint64_t>(events_).subspan(from.first_event, to.first_event - from.first_event),
        std::span(merged_).subspan(from.first_merged, to.first_merged - from.first_merged));
  });
  std::swap(words, merged_);
  if (cell_begin == nullptr) return;
  if (events_.size() * words_for_an_event < words.size() + key_count) {
    shift_cells(threads, words, *cell_begin);
  } else {
    index_cells(threads, words, key_count, *cell_begin);
  }
}

}  // namespace palpate
