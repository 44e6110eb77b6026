#include "sort/digit_pass.hpp"

namespace palpate {

void scatter_keys(const parallel::Threads& threads, std::span<const std::uint32_t> keys, int shift,
                  std::size_t digits, std::vector<std::uint32_t>& histograms,
                  std::vector<std::uint32_t>& digit_begin, std::span<std::uint64_t> words) {
  const std::size_t grain = digit_grain_for(threads, keys.size());
  const std::size_t chunks = parallel::chunk_count(keys.size(), grain);
  const std::size_t slots = digits + 1;
  const auto digit_of = [=](std::uint32_t key) {
    const std::size_t digit = (key >> shift) & (digits - 1);
    return key == no_key ? digits : digit;
  };
  histograms.resize(chunks * slots);
  digit_begin.assign(slots, 0);
  if (chunks == 0) return;
  parallel::for_chunks(threads, keys.size(), grain,
                       [&](std::size_t begin, std::size_t end, std::size_t chunk) {
                         std::uint32_t* const histogram = histograms.data() + chunk * slots;
                         std::fill_n(histogram, slots, 0U);
                         for (std::size_t i = begin; i < end; ++i) ++histogram[digit_of(keys[i])];
                       });
  counts_to_positions(histograms, chunks, slots);
  std::copy_n(histograms.begin(), slots, digit_begin.begin());
  parallel::for_chunks(
      threads, keys.size(), grain, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
        std::uint32_t* const position = histograms.data() + chunk * slots;
        for (std::size_t i = begin; i < end; ++i)
          words[position[digit_of(keys[i])]++] = make_word(keys[i], static_cast<std::uint32_t>(i));
      });
}

}  // namespace palpate
