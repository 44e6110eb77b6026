#pragma once

#include <span>
#include <string_view>

#include "scene/units.hpp"

/// The fields that a run can write and show, by the names that scenes, frames, Python and the viewer use.
/// Their meaning: palpate/tissue.hpp, palpate/forces.hpp.
namespace palpate {

struct FieldInfo {
  std::string_view name;
  Dimension dimension;     ///< dimension of its numbers
  int components;          ///< 1, 3, 6 (symmetric: xx, yy, zz, xy, yz, xz) or 9 (row by row)
  bool of_tets;            ///< has values at tets and at points
  std::string_view title;  ///< of a legend
  std::string_view meaning;
};

[[nodiscard]] std::span<const FieldInfo> field_infos();
/// The field of that name; nullptr if there is none.
[[nodiscard]] const FieldInfo* find_field(std::string_view name);
[[nodiscard]] std::span<const std::string_view> field_names();

}  // namespace palpate
