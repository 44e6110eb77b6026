#include "grid/point_grid.hpp"

#include <algorithm>
#include <array>

#include "prefetch.hpp"
#include "room.hpp"

namespace palpate {

Sort PointGrid::build(const parallel::Threads& threads, const Lattice& lattice,
                      const FixedPositions& points) {
  const Sort sort = cells_.build_points(threads, lattice, points);
  put_in_order(threads, points);
  return sort;
}

void PointGrid::put_in_order(const parallel::Threads& threads, const FixedPositions& points) {
  constexpr std::size_t grain = 8192;
  const std::span<const Entry> entries = cells_.entries();
  const std::span<const simd::FixedPoint> all = points.points();
  // All included points have an entry, so these arrays grow once.
  words_.resize(std::max(words_.size(), entries.size() + simd::row_padding));
  names_.resize(words_.size());
  const bool asks_ahead = entries.size() > most_in_cache;
  parallel::for_chunks(threads, entries.size(), grain, [&](std::size_t begin, std::size_t end, std::size_t) {
    constexpr std::size_t at_a_time = 256;
    constexpr std::size_t ahead = 24;
    std::array<simd::FixedPoint, at_a_time + simd::row_padding> some{};
    for (std::size_t first = begin; first < end; first += at_a_time) {
      const std::size_t n = std::min(at_a_time, end - first);
      for (std::size_t i = 0; i < n; ++i) {
        if (asks_ahead && first + i + ahead < end)
          prefetch(&at(all, reference_of(entries[first + i + ahead])));
        some[i] = at(all, reference_of(entries[first + i]));
      }
      simd::coarse_words(std::span(some).first(n), points.coarse_shift(), words_.data() + first,
                         names_.data() + first);
    }
  });
}

}  // namespace palpate
