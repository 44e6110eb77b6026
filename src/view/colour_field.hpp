#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "scene/field_list.hpp"

namespace palpate::view {

/// One number for each point, derived from a field, by which a page can colour.
struct ColourField {
  const FieldInfo* info = nullptr;
  int component = -1;  ///< of the field; -1: the number itself, or the length of the vector
  std::string name;    ///< "von_mises", "stress_xx", "principal_stress_1"
  std::string title;
};

/// All colour fields, at least one for each field: numbers, lengths of vectors, components of tensors and of
/// the principal directions, and each principal stress.
[[nodiscard]] std::span<const ColourField> colour_fields();
/// nullptr where there is none of that name.
[[nodiscard]] const ColourField* find_colour_field(std::string_view name);

/// The numbers (n) of a colour field.
/// \param rows  (n x components) values of the field
[[nodiscard]] std::vector<double> colour_values(const ColourField& field, std::vector<double> rows);

/// Name, title, dimension, and the title of the whole field as `group`, for Stage::about.
[[nodiscard]] nlohmann::ordered_json field_json(const ColourField& field);

}  // namespace palpate::view
