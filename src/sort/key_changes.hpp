#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "parallel/parallel.hpp"

namespace palpate {

/// Stores the key of each reference and finds those that changed since the last frame: the movers. One pass
/// over old and new keys in the order of references, without gathers.
class KeyChanges {
 public:
  /// Compares `keys` (one per reference, no_key for those without a word) with those of the last accept().
  /// References beyond the end of a list have no key. The stored keys change only in accept(). O(references).
  void find(const parallel::Threads& threads, std::span<const std::uint32_t> keys);

  /// References whose key changed, those that appeared or disappeared included.
  [[nodiscard]] std::size_t movers() const { return movers_; }
  /// Number of words of the last accepted keys, and of the keys of find().
  [[nodiscard]] std::size_t words_before() const { return words_; }
  [[nodiscard]] std::size_t words_now() const { return words_ + appeared_ - disappeared_; }

  /// Appends make_word of each reference that appeared, ascending by reference.
  void append_appeared(std::vector<std::uint64_t>& words) const;
  /// Replaces `events` by the changes, ascending by reference: the old word of each mover with simd::removal,
  /// then its new word. Parallel; up to two for each mover.
  void list_events(const parallel::Threads& threads, std::vector<std::uint64_t>& events);

  /// Stores the keys of the last find() as those of the last frame.
  void accept(const parallel::Threads& threads);
  /// Clears all keys.
  void clear();

 private:
  struct Chunk {
    std::uint32_t movers = 0;
    std::uint32_t appeared = 0;
    std::uint32_t disappeared = 0;
    std::size_t first_event = 0;
  };
  void find_in_chunk(std::size_t begin, std::size_t end, Chunk& chunk);
  /// Calls body(reference) for each mover of the chunk.
  template <class Body>
  void for_movers(std::size_t chunk, Body&& body) const;

  std::vector<std::uint32_t> before_;
  std::vector<std::uint32_t> padded_;              ///< keys of find(), where there are fewer than before
  std::span<const std::uint32_t> now_;             ///< as long as before_
  std::size_t references_ = 0;                     ///< of find()
  std::vector<std::uint32_t> references_changed_;  ///< of a chunk: from its first reference on
  std::vector<Chunk> chunks_;
  std::size_t words_ = 0;
  std::size_t movers_ = 0;
  std::size_t appeared_ = 0;
  std::size_t disappeared_ = 0;
};

}  // namespace palpate
