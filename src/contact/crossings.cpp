#include "contact/crossings.hpp"

#include <algorithm>

#include "room.hpp"

namespace palpate {

void Crossings::set(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
                    const BorderEdgeView& border, std::span<const EdgeInTriangle> found) {
  resize_with_room(begin_, border.size() + 1);
  Index* const begin = begin_.data();
  std::size_t edge = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const auto own = static_cast<std::size_t>(found[i].border_edge);
    for (; edge < own; ++edge) begin[edge] = static_cast<Index>(i);  // without crossing
    if (edge == own) begin[edge++] = static_cast<Index>(i);
  }
  std::fill(begin + edge, begin + begin_.size(), static_cast<Index>(found.size()));
  resize_with_room(crossings_, found.size());
  find_parameters(threads, bodies, positions, border, found, crossings_);
}

}  // namespace palpate
