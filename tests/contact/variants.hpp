#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <palpate/settings.hpp>

namespace palpate::test {

/// All distinct combinations of structure, cell order and sort. Only the compact grid sorts; hash and brute
/// have no cell order.
inline std::vector<DetectionSettings> every_variant() {
  std::vector<DetectionSettings> variants;
  for (std::size_t structure = 0; structure < structure_names.size(); ++structure) {
    for (std::size_t order = 0; order < order_names.size(); ++order) {
      for (std::size_t sort = 0; sort < sort_names.size(); ++sort) {
        DetectionSettings variant;
        variant.structure = static_cast<Structure>(structure);
        variant.order = static_cast<Order>(order);
        variant.sort = static_cast<Sort>(sort);
        const bool sorts = variant.structure == Structure::compact;
        const bool numbers_cells =
            variant.structure != Structure::hash && variant.structure != Structure::brute;
        if ((sorts || sort == 0) && (numbers_cells || order == 0)) variants.push_back(variant);
      }
    }
  }
  return variants;
}

inline std::string name_of(const DetectionSettings& variant) {
  const auto of = [](const auto& names, auto value) {
    return std::string(names[static_cast<std::size_t>(value)]);
  };
  return of(structure_names, variant.structure) + " " + of(order_names, variant.order) + " " +
         of(sort_names, variant.sort);
}

}  // namespace palpate::test
