#pragma once

#include <CLI/CLI.hpp>
#include <optional>

#include <palpate/settings.hpp>

namespace palpate::app {

/// The flags that replace contact settings of a scene; settings without a flag stay as in the scene.
struct DetectionOptions {
  std::optional<Structure> structure;
  std::optional<Order> order;
  std::optional<Sort> sort;
  std::optional<CellSize> cell_size;
  /// Outer optional: whether the flag was given. Inner optional: empty for "exact".
  std::optional<std::optional<int>> cells_per_primitive;

  void apply(
      DetectionSettings& settings) const;  ///< throws BadInput if a flag and the budget exclude each other
};

/// Adds `--structure`, `--order`, `--sort`, `--cell-size` and `--cells-per-primitive`.
void add_detection_options(CLI::App& app, DetectionOptions& options);

}  // namespace palpate::app
