#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <mutex>
#include <span>
#include <vector>

#include "parallel/threads.hpp"
#include "room.hpp"

/// All parallel loops. Work is cut into chunks of a fixed number of items, never by the number of threads.
/// Every result is written to the element of its item or chunk, so results have the same bits for every
/// thread count.
namespace palpate::parallel {

/// Number of chunks of `grain` items that cover `items`.
constexpr std::size_t chunk_count(std::size_t items, std::size_t grain) {
  return (items + grain - 1) / grain;
}

/// Calls body(begin, end, chunk) for each chunk of `grain` items of [0, items), in any order, on any thread.
/// An exception in a chunk is rethrown here; of several, that of the lowest chunk.
///
/// Loop and chunk are not inlined, so that a profile has the instructions of each loop's chunks apart from
/// all others (`palpate bench speed --only instructions`).
template <class Body>
[[gnu::noinline]] void for_chunks(const Threads& threads, std::size_t items, std::size_t grain, Body&& body) {
  const std::size_t chunks = chunk_count(items, grain);
  const auto run = [&](std::size_t chunk) __attribute__((noinline)) {
    body(chunk * grain, std::min(items, (chunk + 1) * grain), chunk);
  };
  if (threads.count() == 1 || chunks <= 1) {
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) run(chunk);
    return;
  }
  std::exception_ptr failure;
  std::size_t failed_chunk = chunks;
  std::mutex failure_mutex;
  threads.run(chunks, [&](std::size_t chunk) {
    try {
      run(chunk);
    } catch (...) {
      const std::lock_guard lock(failure_mutex);
      if (chunk < failed_chunk) {
        failed_chunk = chunk;
        failure = std::current_exception();
      }
    }
  });
  if (failure) std::rethrow_exception(failure);
}

/// Calls body(i) for each i of [0, items).
template <class Body>
void for_each(const Threads& threads, std::size_t items, std::size_t grain, Body&& body) {
  for_chunks(threads, items, grain, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; ++i) body(i);
  });
}

/// Items of a chunk in a sum: part of the result's definition, so that sums have the same bits everywhere.
inline constexpr std::size_t sum_grain = 1024;

/// Sum of map(i) over [0, items): chunk sums in item order, added in chunk order. `partial` is scratch that a
/// caller keeps between calls so that a steady step allocates nothing.
template <class Map>
double sum(const Threads& threads, std::size_t items, std::vector<double>& partial, Map&& map) {
  assign_with_room(partial, chunk_count(items, sum_grain), 0.0);
  for_chunks(threads, items, sum_grain, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
    double s = 0.0;
    for (std::size_t i = begin; i < end; ++i) s += map(i);
    partial[chunk] = s;
  });
  double total = 0.0;
  for (const double s : partial) total += s;
  return total;
}

/// Lists that chunks fill independently and that are then joined in chunk order. So the order is the order of
/// the items, for every schedule of the threads. Keeps its memory between uses.
template <class T>
class ChunkedList {
 public:
  /// Calls body(begin, end, list) for each chunk; `list` is that chunk's own, empty vector.
  template <class Body>
  void fill(const Threads& threads, std::size_t items, std::size_t grain, Body&& body) {
    used_ = chunk_count(items, grain);
    if (lists_.size() < used_) {
      make_room(lists_, used_);
      lists_.resize(used_);
    }
    for_chunks(threads, items, grain, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
      std::vector<T>& list = lists_[chunk];
      const std::size_t capacity = list.capacity();
      list.clear();
      body(begin, end, list);
      keep_room(list, capacity, list.size() + 16);
    });
  }
  /// Reserves room in all lists for half more than the largest so far, and half more lists.
  /// For chunks whose work varies from frame to frame: only the first frames allocate.
  void make_even_room() {
    std::size_t most = 0;
    for (std::size_t chunk = 0; chunk < used_; ++chunk) most = std::max(most, lists_[chunk].size());
    if (most > most_of_chunk_) most_of_chunk_ = most + most / 2;
    make_room_in_all(used_ + used_ / 2 + 4, most_of_chunk_);
  }
  /// Reserves room for `items` items in the lists of `chunks` chunks.
  void make_room_in_all(std::size_t chunks, std::size_t items) {
    if (lists_.size() < chunks) lists_.resize(chunks);
    make_room(places_, chunks);
    for (std::vector<T>& list : lists_) make_room(list, items);
  }
  /// Replaces `joined` by all lists in chunk order. O(items), parallel.
  void join(const Threads& threads, std::vector<T>& joined) {
    place(used_, 0);
    resize_with_room(joined, total_);
    copy_lists(threads, joined, used_);
  }
  /// The list of a chunk of the last fill().
  [[nodiscard]] std::span<const T> list(std::size_t chunk) const { return lists_[chunk]; }
  /// Appends the lists of the first so many chunks, in their order. O(items), in part parallel.
  void append(const Threads& threads, std::vector<T>& joined, std::size_t chunks) {
    place(chunks, joined.size());
    make_room(joined, total_);
    if (threads.count() == 1) {
      for (std::size_t chunk = 0; chunk < chunks; ++chunk)
        joined.insert(joined.end(), lists_[chunk].begin(), lists_[chunk].end());
      return;
    }
    joined.resize(total_);
    copy_lists(threads, joined, chunks);
  }

 private:
  /// Finds the places of the first so many lists.
  void place(std::size_t chunks, std::size_t first) {
    resize_with_room(places_, chunks);
    total_ = first;
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
      places_[chunk] = total_;
      total_ += lists_[chunk].size();
    }
  }
  void copy_lists(const Threads& threads, std::vector<T>& joined, std::size_t chunks) const {
    constexpr std::size_t items_at_once = 4096;  // a thread copies them faster than it is told to
    const std::size_t grain =
        std::max<std::size_t>(1, chunks * items_at_once / std::max<std::size_t>(total_, 1));
    for_each(threads, chunks, grain, [&](std::size_t chunk) {
      std::copy(lists_[chunk].begin(), lists_[chunk].end(),
                joined.begin() + static_cast<std::ptrdiff_t>(places_[chunk]));
    });
  }

  std::vector<std::vector<T>> lists_;
  std::vector<std::size_t> places_;  ///< of the first item of each list, where they are joined
  std::size_t total_ = 0;
  std::size_t used_ = 0;
  std::size_t most_of_chunk_ = 0;  ///< room of each, by make_even_room()
};

}  // namespace palpate::parallel
