#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <palpate/settings.hpp>

namespace palpate::test {

/// Every way to find candidates that differs from the others: structure x order x sort. Only the compact grid
/// sorts its points, and only it and the numbered structures have an order.
inline std::vector<DetectionSettings> every_way() {
  std::vector<DetectionSettings> ways;
  for (std::size_t structure = 0; structure < structure_names.size(); ++structure) {
    for (std::size_t order = 0; order < order_names.size(); ++order) {
      for (std::size_t sort = 0; sort < sort_names.size(); ++sort) {
        DetectionSettings way;
        way.structure = static_cast<Structure>(structure);
        way.order = static_cast<Order>(order);
        way.sort = static_cast<Sort>(sort);
        const bool sorts = way.structure == Structure::compact;
        const bool numbers_cells = way.structure != Structure::hash && way.structure != Structure::brute;
        if ((sorts || sort == 0) && (numbers_cells || order == 0)) ways.push_back(way);
      }
    }
  }
  return ways;
}

inline std::string name_of(const DetectionSettings& way) {
  const auto of = [](const auto& names, auto value) {
    return std::string(names[static_cast<std::size_t>(value)]);
  };
  return of(structure_names, way.structure) + " " + of(order_names, way.order) + " " +
         of(sort_names, way.sort);
}

}  // namespace palpate::test
