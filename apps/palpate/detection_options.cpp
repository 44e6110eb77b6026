#include "detection_options.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <span>
#include <string>
#include <string_view>

#include "exit_codes.hpp"
#include "option_values.hpp"

namespace palpate::app {
namespace {

std::string joined(std::span<const std::string_view> names) {
  std::string text;
  for (const std::string_view name : names) text.append(text.empty() ? "" : "|").append(name);
  return text;
}

/// Adds a flag whose value is the name of an enumerator; `names` is indexed by its value.
template <class Choice>
void add_choice(CLI::App& app, const std::string& flag, const std::string& help,
                std::span<const std::string_view> names, std::optional<Choice>& choice) {
  add_value(app, flag, joined(names), help, [names, &choice](const std::string& f, const std::string& text) {
    choice = static_cast<Choice>(parse_choice(f, text, names));
  });
}

}  // namespace

void DetectionOptions::apply(DetectionSettings& settings) const {
  settings.structure = structure.value_or(settings.structure);
  settings.order = order.value_or(settings.order);
  settings.sort = sort.value_or(settings.sort);
  settings.cell_size = cell_size.value_or(settings.cell_size);
  settings.cells_per_primitive = cells_per_primitive.value_or(settings.cells_per_primitive);
  if (!settings.budget) return;  // without a budget every combination is allowed
  if (settings.structure != Structure::compact) {
    throw BadInput("--structure", "",
                   fmt::format("'{}'", structure_names[static_cast<std::size_t>(settings.structure)]),
                   "'compact': the scene has a budget (contact.budget)");
  }
  if (settings.cells_per_primitive) {
    throw BadInput("--cells-per-primitive", "", fmt::format("'{}'", *settings.cells_per_primitive),
                   "'exact': the scene has a budget (contact.budget)");
  }
}

void add_detection_options(CLI::App& app, DetectionOptions& options) {
  add_choice(app, "--structure", "spatial structure, instead of the scene's", structure_names,
             options.structure);
  add_choice(app, "--order", "order of cells, instead of the scene's", order_names, options.order);
  add_choice(app, "--sort", "how cells are sorted, instead of the scene's", sort_names, options.sort);
  add_value(app, "--cell-size", joined(cell_size_rule_names) + "|NUMBER",
            "edge length of a cell, instead of the scene's",
            [&options](const std::string& flag, const std::string& text) {
              const auto name = std::find(cell_size_rule_names.begin(), cell_size_rule_names.end(), text);
              if (name != cell_size_rule_names.end()) {
                options.cell_size = static_cast<CellSizeRule>(name - cell_size_rule_names.begin());
                return;
              }
              try {
                options.cell_size = parse_number(flag, text, scene_format::above(0.0));
              } catch (const BadInput&) {
                throw BadInput(flag, "", "'" + text + "'", "'auto', 'mean-edge', 'max-edge' or a number > 0");
              }
            });
  add_value(app, "--cells-per-primitive", "exact|1..27",
            "number of cells used for each primitive: fewer cells are faster and may miss contacts",
            [&options](const std::string& flag, const std::string& text) {
              if (text == "exact") {
                options.cells_per_primitive.emplace(std::nullopt);
                return;
              }
              try {
                options.cells_per_primitive.emplace(static_cast<int>(parse_integer(flag, text, 1, 27)));
              } catch (const BadInput&) {
                throw BadInput(flag, "", "'" + text + "'", "'exact' or an integer from 1 to 27");
              }
            });
}

}  // namespace palpate::app
