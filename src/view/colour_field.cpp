#include "view/colour_field.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "scene/field_values.hpp"

namespace palpate::view {
namespace {

constexpr std::array<std::string_view, 6> symmetric{"xx", "yy", "zz", "xy", "yz", "xz"};
constexpr std::array<std::string_view, 3> ordered{"1", "2", "3"};  // largest first

std::vector<ColourField> all_fields() {
  std::vector<ColourField> all;
  const auto add_components = [&](const FieldInfo& info, std::span<const std::string_view> components) {
    for (std::size_t c = 0; c < components.size(); ++c) {
      all.push_back({&info, static_cast<int>(c), std::string(info.name).append("_").append(components[c]),
                     std::string(info.title).append(" ").append(components[c])});
    }
  };
  for (const FieldInfo& info : field_infos()) {
    if (info.components <= 3) all.push_back({&info, -1, std::string(info.name), std::string(info.title)});
    if (info.name == "principal_stress") add_components(info, ordered);
    if (info.components == 6) add_components(info, symmetric);
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
  return {{"name", field.name}, {"title", field.title}, {"dimension", {d.mass, d.length, d.time}}};
}

}  // namespace palpate::view
