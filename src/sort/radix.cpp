#include "sort/radix.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <span>
#include <utility>

namespace palpate {
namespace {

constexpr int digit_bits = 8;
constexpr std::size_t buckets = std::size_t{1} << digit_bits;
/// Words of a chunk: its histogram (1 KiB) and the 256 open write positions stay in the first-level cache.
constexpr std::size_t grain = std::size_t{1} << 14;

std::size_t digit_of(std::uint64_t word, int bit) {
  return (word >> bit) & (buckets - 1);
}

/// Turns counts into write positions: all of digit 0 in chunk order, then digit 1, and so on. Returns whether
/// one digit holds everything, when there is nothing to move.
bool scan(std::span<std::uint32_t> histograms, std::size_t chunks, std::size_t words) {
  std::uint32_t position = 0;
  for (std::size_t digit = 0; digit < buckets; ++digit) {
    const std::uint32_t before = position;
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
      std::uint32_t& slot = histograms[chunk * buckets + digit];
      const std::uint32_t count = slot;
      slot = position;
      position += count;
    }
    if (position - before == words) return true;
  }
  return false;
}

}  // namespace

void RadixSort::operator()(const parallel::Threads& threads, std::vector<std::uint64_t>& words, int first_bit,
                           std::uint64_t largest) {
  const auto last_bit = static_cast<int>(std::bit_width(largest));
  const std::size_t chunks = parallel::chunk_count(words.size(), grain);
  scratch_.resize(words.size());
  histograms_.resize(chunks * buckets);
  for (int bit = first_bit; bit < last_bit; bit += digit_bits) {
    parallel::for_chunks(threads, words.size(), grain,
                         [&](std::size_t begin, std::size_t end, std::size_t chunk) {
                           const auto histogram = std::span(histograms_).subspan(chunk * buckets, buckets);
                           std::fill(histogram.begin(), histogram.end(), 0U);
                           for (std::size_t i = begin; i < end; ++i) ++histogram[digit_of(words[i], bit)];
                         });
    if (scan(histograms_, chunks, words.size())) continue;
    parallel::for_chunks(threads, words.size(), grain,
                         [&](std::size_t begin, std::size_t end, std::size_t chunk) {
                           const auto position = std::span(histograms_).subspan(chunk * buckets, buckets);
                           for (std::size_t i = begin; i < end; ++i)
                             scratch_[position[digit_of(words[i], bit)]++] = words[i];
                         });
    std::swap(words, scratch_);
  }
}

}  // namespace palpate
