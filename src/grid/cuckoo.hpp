#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <type_traits>
#include <vector>

#include <palpate/detection.hpp>
#include <palpate/settings.hpp>

#include "grid/cell_index.hpp"
#include "grid/footprints.hpp"
#include "grid/lattice.hpp"
#include "parallel/parallel.hpp"
#include "room.hpp"
#include "sort/radix.hpp"

namespace palpate {

/// Sizes and limits of a CuckooGrid. The defaults are the values of Alcantara et al.; other values are for
/// tests.
struct CuckooParameters {
  std::size_t bucket_target = 409;    ///< keys of a bucket on average: 80 % of its capacity
  std::size_t bucket_capacity = 512;  ///< maximum number of keys of a bucket
  std::size_t table_slots = 192;      ///< slots of each of the three sub-tables: 409 / (3 x 192) = 71 %
  int most_rounds = 48;               ///< maximum rounds of eviction before a bucket takes new hash functions
  int most_functions = 16;     ///< maximum sets of hash functions tried for a bucket before the table grows
  int most_distributions = 4;  ///< maximum hash functions into buckets tried before the table grows
  int most_growths = 16;       ///< maximum growths, each by a quarter, before an Error
  std::uint64_t seed = 0;
};

/// Parallel two-level cuckoo hashing (Alcantara et al., "Real-time parallel hashing on the GPU", 2009; paper
/// 4.3). A key is the index of a cell that is not empty. A first hash distributes the keys to buckets; each
/// bucket then finds, on its own, a slot for each of its keys in one of three sub-tables, with hash
/// functions of its own. A key leads to (start, count) in the array of references.
///
/// The paper does not say how distinct keys are found. Here the entries are sorted (radix) by the 32 bits of
/// the first hash. Then equal keys are adjacent, the references of a key are one ascending interval, and the
/// keys of a bucket (the leading part of the hash) are one interval too.
///
/// Deviations: within a bucket keys are inserted one after the other, so that the result is the same for
/// every number of threads. The three sub-tables of a bucket are adjacent in memory. If new hash functions do
/// not help, the table grows. All functions come from a counter-based hash of (seed, attempt).
class CuckooGrid {
 public:
  explicit CuckooGrid(Order order = Order::linear, const CuckooParameters& parameters = {})
      : parameters_(parameters), index_(order) {}

  /// As CompactGrid::build. Expected O(entries). Throws Error if most_growths did not suffice, which
  /// happens only with special parameters.
  template <class Footprint>
  void build(const parallel::Threads& threads, const Lattice& lattice, std::size_t count,
             Footprint&& footprint);

  /// Calls visit(reference) for each entry in the cells of `range`, in order of cells, then references. At
  /// most three slots are read for each cell; where there are more cells than keys, each key once.
  template <class Visit>
  void for_each(const CellRange& range, Visit&& visit) const;

  /// Counts of the last build.
  [[nodiscard]] const CuckooCounts& counts() const { return counts_; }
  /// Memory that a query reads, and memory of the construction.
  [[nodiscard]] std::size_t bytes() const {
    return slots_.capacity() * sizeof(Slot) + seeds_.capacity() * sizeof(std::uint64_t) +
           references_.capacity() * sizeof(Index) + keys_.capacity() * sizeof(Key) +
           entries_.capacity() * sizeof(Entry) + words_.capacity() * sizeof(std::uint64_t);
  }

 private:
  /// One primitive in one cell, as written.
  struct Entry {
    std::uint64_t cell;
    Index reference;
  };
  /// A cell and the begin of its references, which end at the begin of the next key.
  struct Key {
    std::uint64_t cell;
    std::uint32_t begin;
    std::uint32_t hash;  ///< the first hash
  };
  struct Slot {
    std::uint64_t cell;
    std::uint32_t begin;
    std::uint32_t count;
  };
  static constexpr std::uint64_t no_cell = ~std::uint64_t{0};  ///< an index has at most 63 bits

  void insert_entries(const parallel::Threads& threads);
  void sort_by_hash(const parallel::Threads& threads);
  void split_clashes(const parallel::Threads& threads);
  void find_keys(const parallel::Threads& threads);
  [[nodiscard]] bool find_buckets(std::size_t buckets);
  [[nodiscard]] bool fill_tables(const parallel::Threads& threads);

  static std::uint64_t mixed(std::uint64_t x) {  // the finaliser of splitmix64
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9U;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebU;
    return x ^ (x >> 31);
  }
  /// Seed of hash function number `attempt` of `user` (the distribution or a bucket).
  [[nodiscard]] std::uint64_t seed_of(std::uint64_t user, int attempt) const;
  [[nodiscard]] std::uint32_t hash_of(std::uint64_t cell) const {
    return static_cast<std::uint32_t>(mixed(cell + seed_) >> 32);
  }
  [[nodiscard]] std::size_t bucket_of(std::uint32_t hash) const {
    return static_cast<std::size_t>((std::uint64_t{hash} * seeds_.size()) >> 32);
  }
  /// Three slots of a bucket, one in each sub-table: three parts of one hash, 21 bits each.
  struct Places {
    std::array<std::size_t, 3> place;
  };
  [[nodiscard]] Places places_of(std::uint64_t cell, std::uint64_t seed) const {
    const std::uint64_t hash = mixed(cell ^ seed);
    constexpr std::uint64_t mask = (1U << 21) - 1;
    const std::size_t n = parameters_.table_slots;
    return {{static_cast<std::size_t>(((hash & mask) * n) >> 21),
             n + static_cast<std::size_t>((((hash >> 21) & mask) * n) >> 21),
             2 * n + static_cast<std::size_t>((((hash >> 42) & mask) * n) >> 21)}};
  }
  struct BucketResult {
    int functions = 0;  ///< sets of hash functions that were tried
    bool filled = false;
  };
  [[nodiscard]] BucketResult fill_bucket(std::size_t bucket);

  template <class Visit>
  void visit_cell(std::uint64_t cell, Visit&& visit) const;

  CuckooParameters parameters_;
  CellIndex index_;
  std::uint64_t seed_ = 0;                   ///< of the distribution
  std::vector<std::uint64_t> seeds_;         ///< (buckets) of their functions
  std::vector<Slot> slots_;                  ///< (buckets x 3 x table_slots)
  std::vector<Index> references_;            ///< (entries), by key
  std::vector<Key> keys_;                    ///< (keys + 1), by first hash; the last ends the one before
  std::vector<std::uint32_t> bucket_begin_;  ///< (buckets + 1) into keys
  std::vector<Entry> entries_;               ///< by reference
  std::vector<std::uint64_t> words_;         ///< (entries) first hash and index of the entry
  std::vector<BucketResult> results_;        ///< (buckets)
  std::vector<std::uint32_t> homeless_;  ///< (keys) keys without a slot yet, in the interval of their bucket
  std::vector<std::size_t> chunk_begin_;
  parallel::ChunkedList<Key> key_lists_;
  parallel::ChunkedList<std::uint32_t> clash_lists_;
  std::vector<std::uint32_t> clashes_;
  RadixSort sort_;
  CuckooCounts counts_;
};

template <class Footprint>
void CuckooGrid::build(const parallel::Threads& threads, const Lattice& lattice, std::size_t count,
                       Footprint&& footprint) {
  index_.resize(lattice.size());
  write_footprints(
      threads, count, chunk_begin_, footprint,
      [&](std::size_t n) {
        require_countable(n);
        resize_with_room(entries_, n);
      },
      [&](std::size_t e, Index p, const Cell& cell) {
        entries_[e] = {index_(cell), p};
      });
  insert_entries(threads);
}

template <class Visit>
void CuckooGrid::for_each(const CellRange& range, Visit&& visit) const {
  if (range.count() > counts_.cells) {
    for (std::size_t key = 0; key < counts_.cells; ++key) {
      if (!range.contains(index_.cell_of(keys_[key].cell))) continue;
      for (std::uint32_t e = keys_[key].begin; e < keys_[key + 1].begin; ++e) visit(references_[e]);
    }
    return;
  }
  for (std::int32_t k = range.lower[2]; k <= range.upper[2]; ++k) {
    for (std::int32_t j = range.lower[1]; j <= range.upper[1]; ++j) {
      const std::uint64_t row = index_.part(1, j) + index_.part(2, k);
      for (std::int32_t i = range.lower[0]; i <= range.upper[0]; ++i)
        visit_cell(row + index_.part(0, i), visit);
    }
  }
}

template <class Visit>
void CuckooGrid::visit_cell(std::uint64_t cell, Visit&& visit) const {
  const std::size_t bucket = bucket_of(hash_of(cell));
  const Slot* slots = slots_.data() + bucket * 3 * parameters_.table_slots;
  for (const std::size_t place : places_of(cell, seeds_[bucket]).place) {
    const Slot& slot = slots[place];
    if (slot.cell != cell) continue;
    for (std::uint32_t e = slot.begin; e < slot.begin + slot.count; ++e) visit(references_[e]);
    return;
  }
}

/// The counts of a structure; none unless it is a cuckoo table.
template <class Structure>
std::optional<CuckooCounts> cuckoo_counts(const Structure& structure) {
  if constexpr (std::is_same_v<Structure, CuckooGrid>) {
    return structure.counts();
  } else {
    return std::nullopt;
  }
}

}  // namespace palpate
