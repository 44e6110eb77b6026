#pragma once

#include <CLI/CLI.hpp>
#include <optional>

#include <palpate/settings.hpp>

namespace palpate::app {

/// The flags that replace the contact settings of a scene; what is not given stays as the scene says.
struct DetectionOptions {
  std::optional<Structure> structure;
  std::optional<Order> order;
  std::optional<Sort> sort;
  std::optional<CellSize> cell_size;
  /// Outer: given at all; inner: none for exact.
  std::optional<std::optional<int>> cells_per_primitive;

  void apply(DetectionSettings& settings) const;  ///< throws BadInput where a flag rules out its budget
};

/// Adds `--structure`, `--order`, `--sort`, `--cell-size` and `--cells-per-primitive`.
void add_detection_options(CLI::App& app, DetectionOptions& options);

}  // namespace palpate::app
