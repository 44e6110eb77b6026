#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "scene/field_list.hpp"

namespace palpate::view {

/// One number a point, of a field: what a page can colour by.
struct ColourField {
  const FieldInfo* info = nullptr;
  int component = -1;  ///< of the field; -1: its number, or the length of its vector
  std::string name;    ///< "von_mises", "stress_xx", "principal_stress_1"
  std::string title;
};

/// All of them, at least one for each field: numbers, lengths of vectors, components of tensors and of the
/// principal directions, and each principal stress.
[[nodiscard]] std::span<const ColourField> colour_fields();
/// nullptr where there is none of that name.
[[nodiscard]] const ColourField* find_colour_field(std::string_view name);

/// \param rows  (n x components) numbers of the field
///
/// Its numbers, (n).
[[nodiscard]] std::vector<double> colour_values(const ColourField& field, std::vector<double> rows);

/// Name, title, dimension, and the title of the whole field as `group`, for Stage::about.
[[nodiscard]] nlohmann::ordered_json field_json(const ColourField& field);

}  // namespace palpate::view
