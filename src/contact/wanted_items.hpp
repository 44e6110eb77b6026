#pragma once

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include <palpate/types.hpp>

#include "geometry/vector.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// Items of a fixed number that threads ask for, listed in their order, each once.
class WantedItems {
 public:
  /// Reserves memory for all items, so that later steps allocate none.
  void resize(std::size_t items) {
    marks_.assign(items, unknown);
    listed_.reserve(items);
    lists_.make_room_in_all(parallel::chunk_count(items, grain), std::min(items, grain));
  }
  /// Forgets all items. O(items listed).
  void forget() {
    for (const Index item : listed_) at(marks_, item) = unknown;
    listed_.clear();
  }
  /// Asks for an item. Any threads may call this at the same time.
  void want(Index item) {
    const std::atomic_ref mark(at(marks_, item));
    if (mark.load(std::memory_order_relaxed) == unknown) mark.store(wanted, std::memory_order_relaxed);
  }
  /// Asks for many items while none is listed. Any threads may do this at the same time.
  class FirstWanted {
   public:
    explicit FirstWanted(WantedItems& items) : marks_(items.marks_.data()) {}
    void want(Index item) const { std::atomic_ref(marks_[item]).store(wanted, std::memory_order_relaxed); }

   private:
    std::uint8_t* marks_;  ///< stays in a register, although bytes are written
  };
  /// Whether an item is in the list. Other threads may ask for items at the same time.
  [[nodiscard]] bool is_listed(Index item) const {
    auto& mark = const_cast<std::uint8_t&>(at(marks_, item));  // until C++26, atomic_ref takes no constant
    return std::atomic_ref(mark).load(std::memory_order_relaxed) == listed;
  }
  /// Lists the items that were asked for since the last call. O(those + items / 8), parallel.
  std::span<const Index> list(const parallel::Threads& threads) {
    lists_.fill(threads, marks_.size(), grain,
                [&](std::size_t begin, std::size_t end, std::vector<Index>& found) {
                  constexpr std::uint64_t any_wanted = 0x0101010101010101U * wanted;  // of eight marks
                  static_assert(std::endian::native == std::endian::little);
                  for (std::size_t i = begin; i < end; i += sizeof any_wanted) {
                    std::uint64_t marks = 0;
                    std::memcpy(&marks, &marks_[i], std::min(end - i, sizeof marks));
                    for (std::uint64_t left = marks & any_wanted; left != 0; left &= left - 1) {
                      const std::size_t item = i + static_cast<std::size_t>(std::countr_zero(left)) / 8;
                      marks_[item] = listed;
                      found.push_back(static_cast<Index>(item));
                    }
                  }
                });
    const std::size_t before = listed_.size();
    lists_.append(threads, listed_, parallel::chunk_count(marks_.size(), grain));
    return std::span<const Index>(listed_).subspan(before);
  }

 private:
  static constexpr std::size_t grain = 32768;
  enum Mark : std::uint8_t { unknown, wanted, listed };

  std::vector<std::uint8_t> marks_;  ///< (n_items) Mark
  std::vector<Index> listed_;
  parallel::ChunkedList<Index> lists_;
};

}  // namespace palpate
