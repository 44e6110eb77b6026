#include "detection_options.hpp"

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
}

void add_detection_options(CLI::App& app, DetectionOptions& options) {
  add_choice(app, "--structure", "spatial structure, in place of the scene's", structure_names,
             options.structure);
  add_choice(app, "--order", "order of cells, in place of the scene's", order_names, options.order);
  add_choice(app, "--sort", "how cells are sorted, in place of the scene's", sort_names, options.sort);
  add_value(app, "--cell-size", "mean-edge|NUMBER", "edge length of a cell, in place of the scene's",
            [&options](const std::string& flag, const std::string& text) {
              if (text == "mean-edge") {
                options.cell_size.emplace(std::nullopt);
                return;
              }
              try {
                options.cell_size.emplace(parse_number(flag, text, scene_format::above(0.0)));
              } catch (const BadInput&) {
                throw BadInput(flag, "", "'" + text + "'", "'mean-edge' or a number > 0");
              }
            });
}

}  // namespace palpate::app
