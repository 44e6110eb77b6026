#include "grid/compact.hpp"

#include <limits>
#include <string>

#include <palpate/error.hpp>

namespace palpate {

void CompactGrid::reserve_entries() {
  for (std::size_t chunk = 1; chunk < chunk_begin_.size(); ++chunk)
    chunk_begin_[chunk] += chunk_begin_[chunk - 1];
  const std::size_t total = chunk_begin_.back();
  if (total > std::numeric_limits<std::uint32_t>::max()) {
    throw Error("compact grid", "", std::to_string(total) + " entries (cells covered by primitives)",
                "at most 4294967295: a larger cell size");
  }
  entries_.resize(total);
}

void CompactGrid::index_entries(const parallel::Threads& threads) {
  const std::uint32_t cells = lattice_.cell_count();
  // Entries were written in order of their references, so a stable sort by cell index alone gives the order
  // of words.
  sort_(threads, entries_, entry_key_bit, make_entry(cells - 1, 0));
  cell_begin_.resize(std::size_t{cells} + 1);
  // Entry e starts every cell from that of its predecessor (exclusive) to its own: each cell is written once.
  const std::size_t n = entries_.size();
  parallel::for_each(threads, n + 1, std::size_t{1} << 14, [&](std::size_t e) {
    const std::size_t first = e == 0 ? 0 : std::size_t{cell_index_of(entries_[e - 1])} + 1;
    const std::size_t last = e == n ? cells : std::size_t{cell_index_of(entries_[e])};
    for (std::size_t cell = first; cell <= last; ++cell) cell_begin_[cell] = static_cast<std::uint32_t>(e);
  });
}

}  // namespace palpate
