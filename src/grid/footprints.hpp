#pragma once

#include <cstddef>
#include <vector>

#include "grid/lattice.hpp"
#include "parallel/parallel.hpp"
#include "room.hpp"

namespace palpate {

/// The first two steps of the parallel construction (paper 4.2, Kalojanov & Slusallek 2009): counts the cells
/// that each primitive covers, then writes one entry for each, in order of primitives.
///
/// `footprint(p, emit)` calls emit(i, j, k) for each cell that primitive p in [0, count) covers, the same in
/// both passes. `reserve(n)` is called once, with the number of entries; `write(e, p, cell)` once for each
/// entry e < n, from any thread. `chunk_begin` is scratch. O(entries).
template <class Footprint, class Reserve, class Write>
void write_footprints(const parallel::Threads& threads, std::size_t count,
                      std::vector<std::size_t>& chunk_begin, Footprint&& footprint, Reserve&& reserve,
                      Write&& write) {
  constexpr std::size_t grain = 2048;
  assign_with_room(chunk_begin, parallel::chunk_count(count, grain) + 1, std::size_t{0});
  parallel::for_chunks(threads, count, grain, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
    std::size_t covered = 0;
    for (std::size_t p = begin; p < end; ++p) {
      footprint(static_cast<Index>(p), [&](std::int32_t, std::int32_t, std::int32_t) { ++covered; });
    }
    chunk_begin[chunk + 1] = covered;
  });
  for (std::size_t chunk = 1; chunk < chunk_begin.size(); ++chunk)
    chunk_begin[chunk] += chunk_begin[chunk - 1];
  reserve(chunk_begin.back());
  parallel::for_chunks(threads, count, grain, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
    std::size_t next = chunk_begin[chunk];
    for (std::size_t p = begin; p < end; ++p) {
      footprint(static_cast<Index>(p), [&](std::int32_t i, std::int32_t j, std::int32_t k) {
        write(next++, static_cast<Index>(p), Cell{i, j, k});
      });
    }
  });
}

/// Throws Error if the number of entries does not fit 32 bits.
void require_countable(std::size_t entries);

}  // namespace palpate
