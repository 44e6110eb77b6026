#include "contact/crossings.hpp"

#include <algorithm>

#include "room.hpp"
#include "sort/rows.hpp"

namespace palpate {

void Crossings::set(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
                    const BorderEdgeView& border, std::span<const EdgeInTriangle> found) {
  sort_into_rows<EdgeInTriangle>(
      found, border.size(), [](const EdgeInTriangle& pair) { return pair.border_edge; }, begin_, sorted_);
  parallel::for_each(threads, border.size(), 4096, [&](std::size_t e) {
    if (begin_[e + 1] - begin_[e] < 2) return;
    std::sort(sorted_.begin() + begin_[e], sorted_.begin() + begin_[e + 1],
              [](const EdgeInTriangle& a, const EdgeInTriangle& b) { return a.triangle < b.triangle; });
  });
  resize_with_room(crossings_, sorted_.size());
  find_parameters(threads, bodies, positions, border, sorted_, crossings_);
}

}  // namespace palpate
