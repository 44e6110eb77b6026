#include "sort/radix.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <utility>

#include "room.hpp"
#include "sort/digit_pass.hpp"
#include "sort/word.hpp"

namespace palpate {
namespace {

/// Width of digits with which keys of `bits` bits need the fewest passes.
int digit_width(int bits) {
  const int passes = std::max(1, (bits + most_digit_bits - 1) / most_digit_bits);
  return std::max(1, (bits + passes - 1) / passes);
}

}  // namespace

void RadixSort::pass(const parallel::Threads& threads, std::vector<std::uint64_t>& words, int bit,
                     int digit_bits) {
  const std::size_t digits = std::size_t{1} << digit_bits;
  const auto digit_of = [=](std::uint64_t word) { return (word >> bit) & (digits - 1); };
  const std::size_t grain = digit_grain_for(threads, words.size());
  const std::size_t chunks = parallel::chunk_count(words.size(), grain);
  resize_with_room(histograms_, chunks * digits);
  parallel::for_chunks(threads, words.size(), grain,
                       [&](std::size_t begin, std::size_t end, std::size_t chunk) {
                         std::uint32_t* const histogram = histograms_.data() + chunk * digits;
                         std::fill_n(histogram, digits, 0U);
                         for (std::size_t i = begin; i < end; ++i) ++histogram[digit_of(words[i])];
                       });
  if (counts_to_positions(histograms_, chunks, digits) == words.size()) return;
  parallel::for_chunks(threads, words.size(), grain,
                       [&](std::size_t begin, std::size_t end, std::size_t chunk) {
                         std::uint32_t* const position = histograms_.data() + chunk * digits;
                         std::uint64_t* const out = scratch_.data();
                         const std::uint64_t* const in = words.data();
                         for (std::size_t i = begin; i < end; ++i) out[position[digit_of(in[i])]++] = in[i];
                       });
  std::swap(words, scratch_);
}

void RadixSort::operator()(const parallel::Threads& threads, std::vector<std::uint64_t>& words, int first_bit,
                           std::uint64_t largest) {
  const auto last_bit = static_cast<int>(std::bit_width(largest));
  const int width = digit_width(last_bit - first_bit);
  scratch_.reserve(words.capacity());  // the two swap places
  scratch_.resize(words.size());
  for (int bit = first_bit; bit < last_bit; bit += width)
    pass(threads, words, bit, std::min(width, last_bit - bit));
}

void RadixSort::from_keys(const parallel::Threads& threads, std::span<const std::uint32_t> keys,
                          std::uint32_t key_count, std::vector<std::uint64_t>& words) {
  const int bits = key_count == 0 ? 0 : static_cast<int>(std::bit_width(key_count - 1));
  const int width = digit_width(bits);
  words.resize(keys.size());
  scratch_.reserve(keys.size());  // the two buffers are swapped, so both need room for the next call
  scatter_keys(threads, keys, 0, std::size_t{1} << width, histograms_, digit_begin_, words);
  words.resize(digit_begin_.back());
  scratch_.resize(words.size());
  for (int bit = width; bit < bits; bit += width)
    pass(threads, words, word_key_bit + bit, std::min(width, bits - bit));
}

}  // namespace palpate
