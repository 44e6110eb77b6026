#include "grid/cuckoo.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <span>
#include <string>
#include <utility>

#include <palpate/error.hpp>

namespace palpate {
namespace {

constexpr std::size_t cuckoo_grain = std::size_t{1} << 14;

std::uint32_t hash_in(std::uint64_t word) {
  return static_cast<std::uint32_t>(word >> 32);
}
std::uint32_t entry_in(std::uint64_t word) {
  return static_cast<std::uint32_t>(word);
}

}  // namespace

std::uint64_t CuckooGrid::seed_of(std::uint64_t user, int attempt) const {
  // Odd multiples of the golden ratio give different (user, attempt) different values before mixing.
  return mixed(mixed(parameters_.seed + 0x9e3779b97f4a7c15U * (user + 1)) +
               static_cast<std::uint64_t>(attempt));
}

void CuckooGrid::insert_entries(const parallel::Threads& threads) {
  constexpr std::uint64_t distribution = std::numeric_limits<std::uint64_t>::max() - 1;
  counts_ = {};
  std::size_t buckets = 1;
  for (int growth = 0; growth <= parameters_.most_growths; ++growth) {
    for (int attempt = 0; attempt < parameters_.most_distributions; ++attempt) {
      seed_ = seed_of(distribution, attempt);
      sort_by_hash(threads);
      find_keys(threads);
      if (growth == 0) {
        const std::size_t target = parameters_.bucket_target;
        buckets = std::max<std::size_t>(1, (counts_.cells + target - 1) / target);
      }
      if (!find_buckets(buckets)) {
        ++counts_.redistributions;
        continue;
      }
      if (fill_tables(threads)) return;
      break;  // each bucket has tried all its functions
    }
    ++counts_.growths;
    buckets += (buckets + 3) / 4;
  }
  const std::size_t keys = std::exchange(counts_.cells, 0);  // so that queries find nothing, and not a part
  throw Error("cuckoo grid", "", "no slot for some of " + std::to_string(keys) + " cells",
              "a table that holds all cells, within the limits for new hash functions and larger tables");
}

void CuckooGrid::sort_by_hash(const parallel::Threads& threads) {
  const std::size_t n = entries_.size();
  resize_with_room(words_, n);
  parallel::for_each(threads, n, cuckoo_grain,
                     [&](std::size_t e) { words_[e] = std::uint64_t{hash_of(entries_[e].cell)} << 32 | e; });
  sort_(threads, words_, 32, std::numeric_limits<std::uint64_t>::max());
  split_clashes(threads);
}

/// Cells with the same 32 bits of hash may be mixed in the sorted entries: sorts such runs by cell.
void CuckooGrid::split_clashes(const parallel::Threads& threads) {
  const auto cell = [&](std::uint64_t word) { return entries_[entry_in(word)].cell; };
  clash_lists_.fill(threads, words_.size(), cuckoo_grain,
                    [&](std::size_t begin, std::size_t end, std::vector<std::uint32_t>& list) {
                      for (std::size_t w = std::max<std::size_t>(begin, 1); w < end; ++w) {
                        const bool clash = hash_in(words_[w]) == hash_in(words_[w - 1]) &&
                                           cell(words_[w]) != cell(words_[w - 1]);
                        if (clash) list.push_back(static_cast<std::uint32_t>(w));
                      }
                    });
  clash_lists_.join(threads, clashes_);
  const auto by_hash = [](std::uint64_t a, std::uint64_t b) { return hash_in(a) < hash_in(b); };
  const auto by_cell = [&](std::uint64_t a, std::uint64_t b) {
    return cell(a) != cell(b) ? cell(a) < cell(b) : a < b;
  };
  std::size_t done = 0;
  for (const std::uint32_t w : clashes_) {
    if (w < done) continue;
    const auto [begin, end] = std::equal_range(words_.begin(), words_.end(), words_[w], by_hash);
    std::sort(begin, end, by_cell);
    done = static_cast<std::size_t>(end - words_.begin());
  }
}

void CuckooGrid::find_keys(const parallel::Threads& threads) {
  const std::size_t n = words_.size();
  resize_with_room(references_, n);
  key_lists_.fill(threads, n, cuckoo_grain, [&](std::size_t begin, std::size_t end, std::vector<Key>& list) {
    std::uint64_t before = begin == 0 ? no_cell : entries_[entry_in(words_[begin - 1])].cell;
    for (std::size_t w = begin; w < end; ++w) {
      const Entry& entry = entries_[entry_in(words_[w])];
      references_[w] = entry.reference;
      if (entry.cell != before)
        list.push_back({entry.cell, static_cast<std::uint32_t>(w), hash_in(words_[w])});
      before = entry.cell;
    }
    if (end == n) list.push_back({no_cell, static_cast<std::uint32_t>(n), 0});
  });
  key_lists_.join(threads, keys_);
  if (n == 0) keys_.push_back({no_cell, 0, 0});
  counts_.cells = keys_.size() - 1;
  resize_with_room(homeless_, counts_.cells);
}

/// Cuts the keys into intervals, one for each bucket. Returns whether none overflows.
bool CuckooGrid::find_buckets(std::size_t buckets) {
  resize_with_room(seeds_, buckets);
  assign_with_room(bucket_begin_, buckets + 1, std::uint32_t{0});
  for (std::size_t key = 0; key < counts_.cells; ++key) ++bucket_begin_[bucket_of(keys_[key].hash) + 1];
  const std::uint32_t largest = *std::max_element(bucket_begin_.begin(), bucket_begin_.end());
  for (std::size_t b = 0; b < buckets; ++b) bucket_begin_[b + 1] += bucket_begin_[b];
  return largest <= parameters_.bucket_capacity;
}

bool CuckooGrid::fill_tables(const parallel::Threads& threads) {
  const std::size_t buckets = seeds_.size();
  resize_with_room(slots_, buckets * 3 * parameters_.table_slots);
  resize_with_room(results_, buckets);
  parallel::for_each(threads, buckets, 1,
                     [&](std::size_t bucket) { results_[bucket] = fill_bucket(bucket); });
  bool filled = true;
  for (const BucketResult& result : results_) {
    counts_.bucket_retries += static_cast<std::size_t>(result.functions - 1);
    filled = filled && result.filled;
  }
  counts_.buckets = buckets;
  counts_.slots = slots_.size();
  return filled;
}

/// All keys of a bucket are inserted into sub-table 0, the evicted ones into sub-table 1, and so on: round i
/// puts those evicted in round i - 1 into sub-table i mod 3.
CuckooGrid::BucketResult CuckooGrid::fill_bucket(std::size_t bucket) {
  const auto keys =
      std::span(keys_).subspan(bucket_begin_[bucket], bucket_begin_[bucket + 1] - bucket_begin_[bucket] + 1);
  const std::size_t size = 3 * parameters_.table_slots;
  const auto slots = std::span(slots_).subspan(bucket * size, size);
  // During the insertion, `begin` of a slot holds the number of its key.
  const auto homeless = std::span(homeless_).subspan(bucket_begin_[bucket], keys.size() - 1);
  BucketResult result;
  while (!result.filled && result.functions < parameters_.most_functions) {
    const std::uint64_t seed = seed_of(bucket, result.functions++);
    seeds_[bucket] = seed;
    std::fill(slots.begin(), slots.end(), Slot{no_cell, 0, 0});
    std::iota(homeless.begin(), homeless.end(), 0U);
    std::size_t left = homeless.size();
    int round = 0;
    for (; left > 0 && round < parameters_.most_rounds; ++round) {
      std::size_t evicted = 0;
      for (const std::uint32_t key : homeless.first(left)) {
        Slot& slot = slots[at(places_of(keys[key].cell, seed).place, round % 3)];
        if (slot.cell != no_cell) homeless[evicted++] = slot.begin;
        slot = {keys[key].cell, key, 0};
      }
      left = evicted;
    }
    result.filled = left == 0;
  }
  for (Slot& slot : slots) {
    if (slot.cell == no_cell) continue;
    const std::uint32_t key = slot.begin;
    slot.begin = keys[key].begin;
    slot.count = keys[key + 1].begin - slot.begin;
  }
  return result;
}

}  // namespace palpate
