#include "view/colour_field.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "scene/field_values.hpp"

namespace palpate::view {
namespace {

constexpr std::array<std::string_view, 6> symmetric{"xx", "yy", "zz", "xy", "yz", "xz"};
constexpr std::array<std::string_view, 3> ordered{"1", "2", "3"};  // largest first
constexpr std::array<std::string_view, 9> row_by_row{"xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"};
constexpr std::array<std::string_view, 9> of_ordered{"1x", "1y", "1z", "2x", "2y", "2z", "3x", "3y", "3z"};

/// Names of the components that are shown one by one; none where the number or the length says enough.
std::span<const std::string_view> component_names(const FieldInfo& info) {
  if (info.name == "principal_stress") return ordered;
  if (info.name == "principal_directions") return of_ordered;
  if (info.components == 6) return symmetric;
  if (info.components == 9) return row_by_row;
  return {};
}

std::vector<ColourField> all_fields() {
  std::vector<ColourField> all;
  for (const FieldInfo& info : field_infos()) {
    if (info.components <= 3) all.push_back({&info, -1, std::string(info.name), std::string(info.title)});
    const std::span<const std::string_view> components = component_names(info);
    for (std::size_t c = 0; c < components.size(); ++c) {
      all.push_back({&info, static_cast<int>(c), std::string(info.name).append("_").append(components[c]),
                     std::string(info.title).append(" ").append(components[c])});
    }
  }
  return all;
}

}  // namespace

std::span<const ColourField> colour_fields() {
  static const std::vector<ColourField> all = all_fields();
  return all;
}

const ColourField* find_colour_field(std::string_view name) {
  const auto all = colour_fields();
  const auto found = std::ranges::find(all, name, &ColourField::name);
  return found == all.end() ? nullptr : &*found;
}

std::vector<double> colour_values(const ColourField& field, std::vector<double> rows) {
  if (field.component < 0) return row_sizes(std::move(rows), field.info->components);
  const auto width = static_cast<std::size_t>(field.info->components);
  std::vector<double> values(rows.size() / width);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = rows[width * i + static_cast<std::size_t>(field.component)];
  return values;
}

nlohmann::ordered_json field_json(const ColourField& field) {
  const Dimension& d = field.info->dimension;
  return {{"name", field.name},
          {"title", field.title},
          {"group", field.info->title},
          {"dimension", {d.mass, d.length, d.time}}};
}

}  // namespace palpate::view
