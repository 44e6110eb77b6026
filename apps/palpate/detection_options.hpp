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
  /// Outer: given at all; inner: none for mean-edge.
  std::optional<std::optional<double>> cell_size;

  void apply(DetectionSettings& settings) const;
};

/// Adds `--structure`, `--order`, `--sort` and `--cell-size`.
void add_detection_options(CLI::App& app, DetectionOptions& options);

}  // namespace palpate::app
